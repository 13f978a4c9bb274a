"""Flight times of ArduCopter 4.x in AUTO.

Sources: ArduPilot's documentation of S-curves and splines, and flights.
"""

import math
from collections.abc import Iterator

import numpy as np

from ipoa_mission.autopilot.commands import LAST_NAV, TAKEOFFS, Command
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import BadInput, EndlessFlight, MissionError
from ipoa_mission.forecast.itinerary.itinerary import UNTIMED, Itinerary, flying_already
from ipoa_mission.forecast.itinerary.program import Place
from ipoa_mission.forecast.timing.flight_model import Abort
from ipoa_mission.forecast.timing.prediction import Prediction, corner_deg, slow_because
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.arducopter.dynamics.airframe import ARDUPILOT_SIMULATOR, Airframe
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter, stop_at
from ipoa_mission.vehicles.arducopter.dynamics.legs import limits_along
from ipoa_mission.vehicles.arducopter.dynamics.motion import DESCENT, STRAIGHT
from ipoa_mission.vehicles.arducopter.dynamics.procedures import (
    LANDINGS,
    circle,
    land,
    landing_place,
    loiter_to_alt,
    payload_place,
    return_home,
)
from ipoa_mission.vehicles.arducopter.limits import (
    ARMING_DELAY_S,
    LAND_DETECTOR_S,
    LIFT_S,
    THROTTLE_DOWN_S,
    CopterLimits,
)
from ipoa_mission.vehicles.arducopter.vehicle import ARDUCOPTER
from ipoa_mission.wind import CALM, Wind

NO_PLACE = (math.nan,) * 3
DOUBT, DOUBT_SHARE = 0.12, 0.0065  # half width: [s] and share of the time

ABORT_DOUBT, ABORT_DOUBT_SHARE = 0.4, 0.018  # of a contingency: 90 % of 94 flown

LANDING_DOUBT = 0.9  # of the leg before LAND (`procedures.LAND_BELOW`) [s]
#: The leg before RTL may be shorter or longer: its clock waits for a drifting vehicle [s].
RETURN_EARLY, RETURN_LATE = 0.3, 1.5

PLACE_COMMANDS = ARDUCOPTER.guidance.flown_on_into - {Command.NAV_PAYLOAD_PLACE}


def fly_arducopter(
    route: Itinerary,
    limits: CopterLimits,
    wind: Wind = CALM,
    fast: bool | None = None,
    airframe: Airframe = ARDUPILOT_SIMULATOR,
) -> Prediction:
    """Predict the times of an itinerary.

    Raises:
        BadInput: an item never ends, or a parameter is invalid.
        MissionError: no progress, for example against the wind.
    """
    flight = _begun(route, limits, wind, fast, airframe)
    for n in range(len(route.visits)):
        try:
            flight.reasons.append(flight.visit(n))
        except BadInput:
            raise
        except MissionError as lost:
            raise MissionError(
                f"{lost}", lost.hint, code="unreachable", place=f"items[{route.visits[n].seq - 1}]"
            ) from None
        flight.done.append(flight.copter.state.time)
    track = Track.joined(flight.tracks)
    done = np.array(flight.done, dtype=np.float64)
    first_legs = np.array([_ending_doubt(visit.item) for visit in route.visits]).reshape(-1, 2)
    early, late = np.maximum.accumulate(first_legs).T
    doubt = DOUBT + DOUBT_SHARE * done
    low, high = done - np.hypot(doubt, early), done + np.hypot(doubt, late)
    return Prediction(done, low, high, tuple(flight.reasons), track, tuple(flight.remarks))


def _ending_doubt(item: Item) -> tuple[float, float]:
    """Return how much shorter and longer the first leg of a landing or RTL may be [s]."""
    if item.command == Command.NAV_RETURN_TO_LAUNCH:
        return RETURN_EARLY, RETURN_LATE
    if item.command in LANDINGS and item.latitude_deg != 0.0:
        return LANDING_DOUBT, LANDING_DOUBT
    return 0.0, 0.0


def fly_aborted(
    route: Itinerary,
    limits: CopterLimits,
    wind: Wind,
    fast: bool | None,
    airframe: Airframe,
    order: Abort,
) -> Prediction:
    """Predict the times with an abort and its contingency; raises as `fly_arducopter`.

    The track has a sample at the abort.
    """
    flight = _begun(route, limits, wind, fast, airframe)
    flight.until = order.time
    for n in range(len(route.visits)):
        if flight.is_broken_off:
            break
        flight.visit(n)
    flight.until, copter = math.inf, flight.copter
    returns = order.contingency is Contingency.RTL
    if returns and copter.limits.rtl_final > 0.0:
        words = "with an RTL_ALT_FINAL above 0 it waits over its goal and does not land"
        raise MissionError(words, code="endless-flight")
    flight.come_down(return_home(copter, route.goal_of_return(copter.place)) if returns else land(copter, None))
    done = np.array([copter.state.time])
    doubt = ABORT_DOUBT + ABORT_DOUBT_SHARE * (done - order.time)
    touched, off = flight.touched, ABORT_DOUBT + ABORT_DOUBT_SHARE * (flight.touched - order.time)
    track = Track.joined(flight.tracks)
    between = touched - off, touched, touched + off
    return Prediction(done, done - doubt, done + doubt, ("",), track, touched=between)


def _begun(route: Itinerary, limits: CopterLimits, wind: Wind, fast: bool | None, airframe: Airframe) -> "_Flight":
    height = flying_already(route)
    copter = Copter(limits, wind, airframe, fast, (0.0, 0.0, height or 0.0), route.ground)
    return _Flight(route, copter, wind, airframe, height is not None)


class _Flight:
    def __init__(self, route: Itinerary, copter: Copter, wind: Wind, airframe: Airframe, airborne: bool) -> None:
        self.route, self.wind, self.copter, self.limits = route, wind, copter, copter.limits
        self.airframe, self.top = airframe, airframe.top_speed(self.limits.lean)
        self.airborne, self.until, self.touched = airborne, math.inf, math.nan
        self.done: list[float] = []
        self.reasons: list[str] = []
        self.remarks: list[str] = []
        self.tracks: list[Track] = []
        self.note()

    @property
    def is_broken_off(self) -> bool:
        return self.copter.state.time >= self.until or not self.copter.passed

    def visit(self, n: int) -> str:
        visit = self.route.visits[n]
        command, params = visit.item.command, visit.item.params
        if command in TAKEOFFS:
            self.take_off(self.target(n)[2])
        elif command == Command.NAV_LOITER_UNLIM:
            raise EndlessFlight("loiters without end, so the flight has no time", place=f"items[{visit.seq - 1}]")
        elif command in PLACE_COMMANDS:
            return self.fly_to(n)
        elif command == Command.NAV_LOITER_TURNS:
            self.go(circle(self.copter, self.target(n), visit.item))
            return "circle"
        elif command == Command.NAV_LOITER_TO_ALT:
            if visit.seq in self.route.over_terrain:
                self.remarks.append(f"item {visit.seq}: ArduCopter skips it if it has no terrain data")
            self.go(loiter_to_alt(self.copter, self.target(n)))
        elif command == Command.NAV_DELAY:
            self.hold(self.copter.wait_at(visit.item))
            return "hold"
        elif command == Command.DO_CHANGE_SPEED:
            self.copter.change_speed(int(params[0]), params[1])
        elif command == Command.NAV_RETURN_TO_LAUNCH:
            self.come_down(return_home(self.copter, self.route.goal_of_return(self.copter.here)))
        elif command in LANDINGS:
            self.come_down(land(self.copter, landing_place(self.route.program, visit.item)))
        elif command == Command.NAV_PAYLOAD_PLACE:
            self.go(payload_place(self.copter, self.target(n) if visit.item.has_position else None, visit.item))
        elif command <= LAST_NAV or command in UNTIMED:
            self.remarks.append(f"item {visit.seq}: command {command} is not modeled and counts as no time")
        return ""

    def target(self, n: int) -> Place:
        return self.route.program.place(n, self.here(n))

    def here(self, n: int) -> Place:
        """Return the stopping place if visit n leaves its place open; slow."""
        return self.copter.here if self.route.program.leaves_open(n) else NO_PLACE

    def fly_to(self, n: int) -> str:
        """Fly to visit n and hold; return why it was slow."""
        program, visit, copter = self.route.program, self.route.visits[n], self.copter
        onward, stop = program.onward(n), stop_at(program, n, self.here(n))
        copter.fly_to(stop, None if onward is None else stop_at(program, onward, stop.place))
        this, following = copter.this, copter.following
        flown_at = self.run()
        if self.is_broken_off:
            return ""
        corner = 0.0
        if following.kind == STRAIGHT:
            corner = corner_deg(this.origin, this.target, following.target)
        top = self.top + self.wind.along(this.direction[0], this.direction[1])
        why = slow_because(
            planned=this.profile.peak if this.kind == STRAIGHT and this.length > 1.0 else None,
            allowed=limits_along(this.origin, this.target, copter.speeds, self.limits).speed,
            asked=copter.speeds.level,
            top=top,
            flown=flown_at,
            corner=corner,
            stops=onward is None,
            curved=this.kind != STRAIGHT,
        )
        if onward is not None:
            return why
        seconds = copter.wait_at(visit.item)
        if seconds > 0:
            self.hold(seconds)
            return "hold"
        return why

    def hold(self, seconds: float) -> None:
        if self.airborne:
            self.copter.hold(seconds)
            self.run()
        else:
            self.stand(seconds)

    def stand(self, seconds: float) -> None:
        self.copter.stand(seconds)
        self.note()

    def take_off(self, height: float) -> None:
        if not self.airborne:
            self.stand(max(ARMING_DELAY_S + 2 * self.limits.spool_up + LIFT_S + self.airframe.lift_delay, 0.0))
            self.airborne = True
        if height > self.copter.here[2]:
            self.copter.take_off(height)
            self.run()

    def go(self, legs: Iterator[None]) -> None:
        for _ in legs:
            self.run()
            if self.is_broken_off:
                return

    def come_down(self, legs: Iterator[None]) -> None:
        self.go(legs)
        if self.copter.this.kind == DESCENT and not self.is_broken_off:
            self.touched, delay = self.copter.state.time, self.airframe.landing_delay
            self.stand(max(THROTTLE_DOWN_S + LAND_DETECTOR_S + self.copter.spool_down + delay, 0.0))
            self.airborne = False

    def run(self) -> float:
        """Fly the leg; return its highest level speed [m/s]."""
        flown = self.copter.run(self.until)
        self.tracks.append(Track.of(flown))
        self.note()
        return float(np.hypot(flown[:, 4], flown[:, 5]).max(initial=0.0))

    def note(self) -> None:
        state = self.copter.state
        self.tracks.append(Track.of(np.array([[state.time, *self.copter.place, state.vx, state.vy, state.vz]])))
