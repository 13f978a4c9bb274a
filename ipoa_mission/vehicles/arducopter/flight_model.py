"""Flight times of ArduCopter 4.x in AUTO, by its simulated dynamics."""

import math
from collections.abc import Hashable, Iterator
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.commands import LANDINGS, LAST_NAV, TAKEOFFS, Command
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.errors import BadInput, EndlessFlight, MissionError
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.forecast.itinerary.itinerary import UNTIMED, Itinerary
from ipoa_mission.forecast.timing.flight_model import (
    FlightModel,
    Kinematics,
    LegSpeeds,
    Prediction,
    SharedStretches,
    corner_deg,
)
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Samples
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.arducopter.dynamics import procedures
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter, airframe_of
from ipoa_mission.vehicles.arducopter.dynamics.legs import limits_along
from ipoa_mission.vehicles.arducopter.dynamics.motion import ARDUPILOT_SIMULATOR, Airframe, Kind
from ipoa_mission.vehicles.arducopter.limits import LANDED_S, copter_limits
from ipoa_mission.wind import Wind


class TimeUncertainty(NamedTuple):
    """Half widths of the 90 % interval of times, as flown."""

    flight_s: float = 0.12
    flight_share: float = 0.0065  # of the time
    contingency_s: float = 0.4  # of a contingency
    contingency_share: float = 0.018
    landing_leg_s: float = 0.9  # of the leg before LAND (`procedures.LAND_BELOW`)
    return_leg_early_s: float = 0.3  # of the leg before RTL: its clock waits for a drifting vehicle
    return_leg_late_s: float = 1.5

    def first_leg(self, item: Item) -> tuple[float, float]:
        """Return how much shorter and longer the first leg of a landing or RTL may be [s]."""
        if item.command == Command.NAV_RETURN_TO_LAUNCH:
            return self.return_leg_early_s, self.return_leg_late_s
        if item.command in LANDINGS and item.latitude_deg != 0.0:
            return self.landing_leg_s, self.landing_leg_s
        return 0.0, 0.0


UNCERTAINTY = TimeUncertainty()


class ArduCopterModel(FlightModel):
    scatter = (0.15, 0.01, 0.6)
    takeoff_scatter_s = 0.6  # version 4.8-dev is 0.5 s early
    is_always_noise_free = True
    simulated_lag = ARDUPILOT_SIMULATOR.lag

    def __init__(self) -> None:
        self._latest = SharedStretches[_VisitEnd](most=1600)

    def predicted(self, itinerary: Itinerary, wind: Wind, noise_free: bool) -> Prediction:
        flight = _MissionRun(itinerary, wind)
        start = flight.end_of_visit("")
        ends = self._latest.fly(flight.conditions, start, flight.stretches(), flight.fly_on)
        track = Track.joined([samples for end in (start, *ends) for samples in end.samples])
        reasons = tuple(end.reason for end in ends)
        done = np.array([end.copter.state.time for end in ends], dtype=np.float64)
        first_legs = np.array([UNCERTAINTY.first_leg(visit.item) for visit in itinerary.visits]).reshape(-1, 2)
        early, late = np.maximum.accumulate(first_legs).T
        doubt = UNCERTAINTY.flight_s + UNCERTAINTY.flight_share * done
        low = done - np.hypot(doubt, early)
        high = done + np.hypot(doubt, late)
        return Prediction(done, low, high, reasons, track, tuple(remark for end in ends for remark in end.remarks))

    def predict_contingency(
        self, itinerary: Itinerary, wind: Wind, contingency: Contingency, time: float
    ) -> Prediction:
        """The track has a sample at the order."""
        flight = _MissionRun(itinerary, wind)
        flight.until = time
        for n in range(len(itinerary.visits)):
            if flight.is_aborted:
                break
            flight.visit(n)
        flight.until = math.inf
        copter = flight.copter
        returns = contingency is Contingency.RTL
        if returns and copter.limits.rtl_final > 0.0:
            words = "with an RTL_ALT_FINAL above 0 it waits over its goal and does not land"
            raise MissionError(words, code="endless-flight")
        if returns:
            flight.go(procedures.return_home(copter, itinerary.goal_of_return(copter.place)))
        else:
            flight.go(procedures.land(copter, None))
        done = np.array([copter.state.time])
        doubt = UNCERTAINTY.contingency_s + UNCERTAINTY.contingency_share * (done - time)
        touched = flight.touched
        off = UNCERTAINTY.contingency_s + UNCERTAINTY.contingency_share * (touched - time)
        track = Track.joined(flight.samples)
        between = touched - off, touched, touched + off
        return Prediction(done, done - doubt, done + doubt, ("",), track, touched=between)

    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        limits = copter_limits(parameters)
        return Kinematics(speed or limits.speed, limits.climb, limits.descent, limits.accel, limits.jerk)

    def airframe(self, altitude: float) -> Airframe:
        return ARDUPILOT_SIMULATOR.at_altitude(altitude)


class _VisitEnd(NamedTuple):
    """A flight after a visit, and that visit's samples and remarks."""

    copter: Copter
    airborne: bool
    touched: float
    samples: list[Samples]
    remarks: list[str]
    reason: str


class _MissionRun:
    """A mission flown visit by visit, until a time [s]."""

    def __init__(self, itinerary: Itinerary, wind: Wind) -> None:
        mission = itinerary.mission
        self.itinerary = itinerary
        self.wind = wind
        self.limits = copter_limits(mission.parameters, mission.firmware_version)
        self.airframe = airframe_of(mission.vehicle).at_altitude(mission.home.altitude)
        height = itinerary.start_height
        self.copter = Copter(self.limits, wind, self.airframe, itinerary.ground)
        self.copter.start_at((0.0, 0.0, height or 0.0))
        self.airborne = height is not None
        self.until = math.inf
        self.touched = math.nan
        self.remarks: list[str] = []
        self.samples: list[Samples] = []
        self.note()

    @property
    def conditions(self) -> Hashable:
        mission = self.itinerary.mission
        ground = self.itinerary.ground
        height = self.itinerary.start_height
        return (
            *(self.limits, self.airframe, self.wind, height, id(ground.terrain), ground.datum, ground.earth_radius),
            *(mission.home, mission.rally, tuple(sorted(mission.parameters.items()))),
            *(mission.firmware_version, self.itinerary.program.ground_at_home),
        )

    def stretches(self) -> list[Hashable]:
        """Return each visit, with all to the second next one that moves: it depends on these."""
        visits = self.itinerary.visits
        moving = [n for n, visit in enumerate(visits) if visit.item.moves]
        after = np.searchsorted(moving, np.arange(len(visits)), side="right").tolist()
        lasts = [moving[k + 1] if k + 1 < len(moving) else len(visits) for k in after]
        return [visits[n : last + 1] for n, last in enumerate(lasts)]

    def fly_on(self, before: _VisitEnd, n: int) -> _VisitEnd:
        self.copter = before.copter.copied()
        self.airborne = before.airborne
        self.touched = before.touched
        self.samples = []
        self.remarks = []
        try:
            return self.end_of_visit(self.visit(n))
        except BadInput:
            raise
        except MissionError as lost:
            raise lost.at(f"item {self.itinerary.visits[n].seq}") from None

    def end_of_visit(self, reason: str) -> _VisitEnd:
        return _VisitEnd(self.copter, self.airborne, self.touched, self.samples, self.remarks, reason)

    @property
    def is_aborted(self) -> bool:
        return self.copter.state.time >= self.until or not self.copter.passed

    def visit(self, n: int) -> str:
        """Fly visit n; return why it was slow."""
        visit = self.itinerary.visits[n]
        command = visit.item.command
        copter = self.copter
        if command == Command.DO_CHANGE_SPEED:
            copter.change_speed(int(visit.item.params[0]), visit.item.params[1])
            return ""
        if command == Command.NAV_LOITER_UNLIM:
            raise EndlessFlight("loiters without end, so the flight has no time", place=f"item {visit.seq}")
        legs = procedures.legs_of(copter, self.itinerary.program, n)
        if command == Command.NAV_RETURN_TO_LAUNCH:
            legs = procedures.return_home(copter, self.itinerary.goal_of_return(copter.here))
        if legs is None:
            if command <= LAST_NAV or command in UNTIMED:
                self.remarks.append(f"item {visit.seq}: command {command} is not modeled and counts as no time")
            return ""
        if command == Command.NAV_LOITER_TO_ALT and visit.seq in self.itinerary.over_terrain:
            self.remarks.append(f"item {visit.seq}: ArduCopter skips it if it has no terrain data")
        if command in procedures.FLOWN_AS_WAYPOINTS:
            return self.fly_to(n, legs)
        if command == Command.NAV_DELAY and not self.airborne:
            self.wait_on_ground(copter.wait_at(visit.item))
            return "hold"
        if command in TAKEOFFS and not self.airborne:
            self.wait_on_ground(max(self.limits.lift_off_s + self.airframe.lift_delay, 0.0))
            self.airborne = True
        self.go(legs)
        if command == Command.NAV_DELAY:
            return "hold"
        return "circle" if command == Command.NAV_LOITER_TURNS else ""

    def fly_to(self, n: int, legs: Iterator[None]) -> str:
        copter = self.copter
        next(legs)
        this, following = copter.this, copter.following
        flown_speed = self.run()
        if self.is_aborted:
            return ""
        is_straight = this.kind == Kind.STRAIGHT
        why = LegSpeeds(
            planned=this.profile.peak if is_straight and this.length > 1.0 else None,
            allowed=limits_along(this.origin, this.target, copter.speeds, self.limits).speed,
            asked=copter.speeds.horizontal,
            top=self.airframe.top_speed(self.limits.max_tilt) + self.wind.along(this.direction[0], this.direction[1]),
            flown=flown_speed,
            corner=corner_deg(this.origin, this.target, following.target) if following.kind == Kind.STRAIGHT else 0.0,
            stops=self.itinerary.program.onward(n) is None,
            curved=not is_straight,
        ).why_slow()
        self.go(legs)
        return "hold" if copter.this.kind == Kind.HOLD else why

    def wait_on_ground(self, seconds: float) -> None:
        self.copter.wait_on_ground(seconds)
        self.note()

    def go(self, legs: Iterator[None]) -> None:
        kind: int = Kind.NOTHING
        for _ in legs:
            self.run()
            if self.is_aborted:
                return
            kind = self.copter.this.kind
        if kind == Kind.DESCENT:
            self.touched = self.copter.state.time
            delay = self.airframe.landing_delay
            self.wait_on_ground(max(LANDED_S + self.copter.limits.spool_up + delay, 0.0))
            self.airborne = False

    def run(self) -> float:
        """Fly the leg; return its highest horizontal speed [m/s]."""
        flown = self.copter.run(self.until)
        self.samples.append(flown.copy())
        self.note()
        return float(np.hypot(flown[:, 4], flown[:, 5]).max(initial=0.0))

    def note(self) -> None:
        state = self.copter.state
        velocity = state.velocity.real, state.velocity.imag, state.vz
        self.samples.append(np.array([[state.time, *self.copter.place, *velocity]]))


MODEL = ArduCopterModel()

#: The measured distance of ArduCopter's flights from their predicted paths (docs/safety.md).
LAW = DeviationLaw(
    lateral=Quantiles((-0.1, 0.0, 0.02, 0.04, 0.06, 0.12, 0.28, 0.5), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Quantiles((-0.3, 0.0, 0.02, 0.04, 0.1, 0.25), (1.0, 0.5, 0.2, 0.1, 0.01, 0.002)),
    up=Quantiles((-0.1, 0.09, 0.11, 0.13, 0.17, 0.27, 0.43), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.05, 0.13, 0.30), (1.0, 0.2, 0.05, 0.01)),
    highest=Quantiles((0.0, 0.05, 0.2, 0.3, 0.65), (1.0, 0.4, 0.1, 0.05, 0.01)),
    farthest=Quantiles((0.0, 0.06, 0.1, 0.17, 0.25, 0.6), (1.0, 0.5, 0.25, 0.1, 0.05, 0.01)),
    doubling_acceleration=4.0,
    after_cruise_factor=1.5,
    decorrelation_s=2.0,
    height_decorrelation_s=10.0,
    growth=(0.06, 0.03, 0.1),
    source="ArduCopter 4.7.0-dev in its simulator: 42 flights, 17 of them by its true position, and 25 in wind",
    strongest=8.0,
)
