"""An ArduCopter in flight; the estimate calls `run`, the built-in autopilot `step`."""

import math
from copy import copy
from typing import Any

import numpy as np

import ipoa_mission.vehicles.arducopter.dynamics.legs as legs
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.compiled import compiled, records
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.itinerary.copter_curves import bearing_from, place_after, turn_of
from ipoa_mission.geometry import Enu, Place, Samples
from ipoa_mission.ground import FLAT_GROUND, Ground
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.vehicles.arducopter.braking import circle_spin
from ipoa_mission.vehicles.arducopter.dynamics.legs import Course, Stop
from ipoa_mission.vehicles.arducopter.dynamics.motion import (
    ARDUPILOT_SIMULATOR,
    NO_LEG,
    STEP,
    Airframe,
    CopterLeg,
    Kind,
    MotionLimits,
    Orbit,
    State,
    tuning,
)
from ipoa_mission.vehicles.arducopter.dynamics.shaping import rest_target
from ipoa_mission.vehicles.arducopter.dynamics.steps import SAMPLE_STEPS, fly_leg, step
from ipoa_mission.vehicles.arducopter.limits import CopterLimits
from ipoa_mission.wind import CALM, Wind

JUST_BEGUN = 0.3  # a later speed change does not replan the leg, as flown [s]
SAME_PLACE = 1e-3  # [m]
#: Climb left when a take-off counts as done [m]. Rounding leaves up to 0.5 mm, for a leg of 0 or 0.4 s; this one takes
#: 0.2 s.
TAKEOFF_REST = 0.00003
STANDING = 0.1  # [m/s]
UPRIGHT = frozenset({Kind.CLIMB, Kind.DESCENT})
SHAPED = frozenset({Kind.ORBIT, Kind.LEVEL_OFF})  # end in motion
SLOWEST = 0.5  # least headway in wind [m/s]
NO_ROOM = -1
BLOWN_OFF = -2
TOO_WINDY = "fly in less wind, another way, or with a greater tilt (ANGLE_MAX, at its risk)"
NO_END = "there is no wind: the model of the flight is wrong here; fly this leg at another speed, or report the mission"
SETTLED = 10.0  # of a hold [s]
SLOWEST_SPIN_UP = math.radians(2.0)  # [rad/s^2]


def airframe_of(vehicle: LearnedVehicle | None) -> Airframe:
    """Return the simulator's airframe with the learned values."""
    simulated = ARDUPILOT_SIMULATOR
    if vehicle is None:
        return simulated
    drag = vehicle.value("drag", 1.0)
    rotor_drag = simulated.rotor_drag * drag
    body_drag = simulated.body_drag * drag
    learned = vehicle.values("lag", "lift_delay", "landing_delay")
    return simulated._replace(rotor_drag=rotor_drag, body_drag=body_drag, **learned)


def stop_at(program: Program, n: int, here: Place) -> Stop:
    """Return item n as a stop; open coordinates as `here`."""
    item = program.items[n]
    place = program.place(n, here)
    if item.command != Command.NAV_SPLINE_WAYPOINT:
        return Stop(place, turn=turn_of(item))
    following = program.shaped_by(n)
    if following is None:
        return Stop(place, True)
    shapes = program.items[following]
    named = program.place(following, place) if shapes.has_position else program.place_of(shapes)
    return Stop(place, True, place_after(item, shapes, place, named))


class Copter:
    """The flight state, and the leg before, this one and the following; `fly_to` and the like begin a leg."""

    def __init__(
        self,
        limits: CopterLimits,
        wind: Wind = CALM,
        airframe: Airframe = ARDUPILOT_SIMULATOR,
        ground: Ground = FLAT_GROUND,
    ) -> None:
        self.limits = limits
        self._tuning = tuning(limits, airframe, wind)
        self._wind = wind
        self._ground = ground
        self._slowest = SLOWEST if wind.speed > 0 else math.inf
        self.speeds = MotionLimits(limits.speed, limits.climb, limits.descent)
        self._records: dict[int, tuple[CopterLeg, Any]] = {}
        self._before = NO_LEG
        self.following = NO_LEG
        self.passed = True
        self._left = 0.0  # of the last planned spline [m/s]
        self.start_at((0.0, 0.0, 0.0))

    def start_at(self, here: Place) -> None:
        self.state = _at_rest(here, 0.0)
        self.this = legs.hold_leg(here, 0.0)

    def copied(self) -> "Copter":
        copied = copy(self)
        copied.state = copy(self.state)
        return copied

    @property
    def place(self) -> Place:
        return self.state.place.real, self.state.place.imag, self.state.z

    @property
    def here(self) -> Place:
        this = self.this
        moves = this.kind in SHAPED or (this.kind > Kind.SPLINE and this.leave > 0.0)
        return this.target if self.passed and self.following is NO_LEG and not moves else self.stopping_place()

    def stopping_place(self) -> Place:
        state = self.state
        speed = math.hypot(state.velocity.real, state.velocity.imag)
        share = float(self.limits.stopping_distance(speed)) / speed if speed > STANDING else 0.0
        up = state.vz * abs(state.vz) / (2 * self.limits.accel_z)
        end = state.place + state.velocity * share
        return end.real, end.imag, max(state.z + up, self._ground.at(end.real, end.imag))

    def step(self) -> bool:
        """Return whether the leg is over."""
        over = step(self.state, self._before, self.this, self.following, self._tuning)
        self.passed = self.passed or over
        return self.passed

    def run(self, until: float = math.inf) -> Samples:
        """Fly the leg to its end, or to the time `until` [s].

        Raises:
            MissionError: the copter does not reach the end.
        """
        skipped_s = self._skip_settled_hold()
        sample_s = STEP * SAMPLE_STEPS
        most = int((60 + 4 * self._least_time() + self.this.length / self._slowest) / sample_s)
        ends_early = until < self.state.time + most * sample_s
        if ends_early:
            most = max(int((until - self.state.time) / sample_s), 0)
        samples = np.empty((most, 7))
        legs_flown = (self._before, self.this, self.following)
        known = self._records
        self._records = {id(leg): known.get(id(leg)) or (leg, records([leg], CopterLeg)) for leg in legs_flown}
        before, this, following = (self._records[id(leg)][1] for leg in legs_flown)
        states = records([self.state], State)
        taken = compiled(fly_leg)(states, before, this, following, self._tuning, samples)
        self.state = State(*states[0].item())
        if taken == NO_ROOM and ends_early:
            return samples
        if taken < 0:
            hint = TOO_WINDY if self._wind.speed > 0 else NO_END
            raise MissionError(self._lost(taken), hint=hint, code="unreachable")
        self.state.time += skipped_s
        self.passed = True
        return samples[:taken]

    def _skip_settled_hold(self) -> float:
        if self.this.kind != Kind.HOLD or self.this.lasts <= SETTLED:
            return 0.0
        skipped_s = self.this.lasts - SETTLED
        self.this = self.this._replace(lasts=SETTLED)
        return skipped_s

    def _lost(self, why: int) -> str:
        x, y, z = map(round, self.place)
        east, north, up = map(round, self.this.target)
        at, to = f"{x} m east, {y} m north, {z} m up of home", f"{east}, {north}, {up} m"
        wind = f"the wind of {self._wind.speed_at(z):.3g} m/s from {self._wind.from_deg:g} deg"
        if why == BLOWN_OFF:
            return f"{wind} blows the copter off its path at {at}"
        windy = f", in {wind}" if self._wind.speed > 0 else ""
        return f"the copter does not get on to {to}: after {self.state.time:.0f} s it is at {at}{windy}"

    def _least_time(self) -> float:
        leg = self.this
        slowest = min(*leg.speeds, self.limits.land_speed) if leg.kind in UPRIGHT else leg.speeds.horizontal
        way = leg.length / slowest if leg.length > 0 else 0.0
        return max(way, leg.profile.lasts, leg.lasts)

    def wait_on_ground(self, seconds: float) -> None:
        x, y, z = self.place
        yaw = self.state.yaw
        self.state = _at_rest((x, y, max(z, self._ground.at(x, y))), self.state.time + seconds)
        self.face(yaw)

    def face(self, yaw: float) -> None:
        self.state.yaw = yaw
        self.state.heading = complex(math.sin(yaw), math.cos(yaw))

    def fly_to(self, stop: Stop, following: Stop | None = None, turns: bool = True, ends_near: bool = False) -> None:
        """Start a leg to `stop`, as planned before or from `here`; with `following` it passes the stop.

        `turns`: the yaw follows the path. `ends_near`: it ends within the acceptance radius.
        """
        slew = self.limits.yaw_rate * STEP if turns else 0.0
        if slew != self._tuning.slew:
            self._tuning = self._tuning._replace(slew=slew)
        planned = self.following
        state = self.state
        if self.passed and planned is not NO_LEG and planned.target == stop.place:
            straight = self.this.kind == Kind.STRAIGHT
            state.leg_time_before = state.leg_time
            state.leg_time = state.leg_time_next if straight else 0.0
            self._before = self.this if straight else NO_LEG
            this = self._as_begun(planned)
        else:
            this = self._unplanned(stop)
            state.leg_time = 0.0
            self._before = NO_LEG
        onward = NO_LEG
        if following is not None:
            onward = self._leg(following, stop.place, this)
            this = legs.join(this, onward, self.limits, self._left)
            if onward.kind == Kind.SPLINE:
                self._left = legs.speed_left(onward)
        elif this.kind == Kind.SPLINE:
            this = this._replace(leave=legs.speed_left(this))
        self._begin(this._replace(ends_near=1.0) if ends_near else this, onward)

    def _unplanned(self, stop: Stop) -> CopterLeg:
        """Return a leg from `here`, at rest or at the speed of an unfinished spline; never an arc."""
        before = self.this
        here = self.here
        if self.passed and before.kind == Kind.SPLINE and before.leave > 0.0:
            if stop.spline:
                return self._leg(stop, here, before)
            return legs.straight_leg(here, stop.place, self.speeds, self.limits, Course(enter=self.state.speed))
        if before.kind in SHAPED:
            self._restart()
        self.state.speed = 0.0
        return self._leg(stop._replace(turn=0.0), here, NO_LEG)

    def _leg(self, stop: Stop, origin: Place, previous: CopterLeg) -> CopterLeg:
        if not stop.spline or math.dist(origin, stop.place) < SAME_PLACE:
            return legs.straight_leg(origin, stop.place, self.speeds, self.limits, Course(turn=stop.turn))
        return legs.spline_leg(origin, stop, previous, self.speeds, self.limits)

    def _as_begun(self, planned: CopterLeg) -> CopterLeg:
        elapsed = self.state.leg_time
        enter = self.state.speed if self._before is NO_LEG else 0.0  # a leg after a spline starts at its speed
        if planned.kind == Kind.SPLINE or elapsed > JUST_BEGUN or (enter == 0.0 and planned.speeds == self.speeds):
            return legs.at_speeds(planned, self.speeds, elapsed, self.limits)
        turn = 0.0 if self._before is NO_LEG else planned.turn
        course = Course(enter, turn=turn, is_changed=planned.speeds != self.speeds)
        return legs.straight_leg(planned.origin, planned.target, self.speeds, self.limits, course)

    def _begin(self, this: CopterLeg, following: CopterLeg = NO_LEG) -> None:
        self.this = this
        self.following = following
        self.passed = False
        self.state.leg_time_next = self.state.spline_u = self.state.az = 0.0

    def change_speed(self, kind: int, speed: float) -> None:
        """Execute DO_CHANGE_SPEED: kind 0 and 1 horizontal, 2 climb, 3 descent."""
        if speed > 0:
            name = {2: "up", 3: "down"}.get(kind, "horizontal")
            self.speeds = self.speeds._replace(**{name: speed})

    def wait_at(self, item: Item) -> float:
        if item.command == Command.NAV_LOITER_UNLIM:
            return math.inf
        if item.command == Command.NAV_ARC_WAYPOINT or not math.isfinite(item.params[0]):
            return 0.0
        return max(item.params[0], 0.0) if item.command == Command.NAV_DELAY else float(int(item.params[0]))

    def hold(self, seconds: float) -> None:
        self._begin_over(legs.hold_leg(self.here, seconds))

    def brake(self) -> Place:
        """Reset all but the tilt; return the stopping place."""
        self._restart()
        self._begin_over(legs.hold_leg(self.stopping_place(), math.inf))
        self.passed = True
        return self.this.target

    def _restart(self) -> None:
        state = self.state
        state.integral = state.setpoint
        state.error = 0j
        state.time_scale = 1.0

    def orbit(self, center: Place, radius: float, turn: float) -> None:
        self._restart()
        here = self.stopping_place()
        rest_target(self.state, Enu(*here))
        self.state.bearing = bearing_from(center, here)
        self.state.spin = self.state.turned = 0.0
        spin = spin_up = self.limits.circle_rate
        if radius > 0.0:
            spin = circle_spin(self.limits, radius, self.speeds.horizontal)
            spin_up = self.limits.accel / radius
        orbit = Orbit(radius, spin, max(spin_up, SLOWEST_SPIN_UP))
        leg = legs.leg_between(Kind.ORBIT, here, here, self.speeds)
        self._begin_over(leg._replace(length=radius * abs(turn), turn=turn, center=Enu(*center), orbit=orbit))

    def level_off(self, up: float) -> None:
        self.state.above = 0.0
        self._begin_over(legs.upright_leg(Kind.LEVEL_OFF, self.place, up, self._default_climb))

    def take_off(self, height: float) -> None:
        """Climb straight up, except TAKEOFF_REST."""
        leg = legs.upright_leg(Kind.CLIMB, self.place, max(height - TAKEOFF_REST, self.state.z), self.speeds)
        self._begin_over(leg._replace(leave=self._still_moving))

    def sink(self, most: float) -> bool:
        """Descend by at most `most` [m]; return whether to the ground."""
        x, y, z = self.here
        ground = self._ground.at(x, y)
        speed = min(self.limits.payload_speed, self.limits.descent)
        end = max(ground, z - most) if most > 0.0 else ground
        limits = self._tuning.limits._replace(land_speed=speed, land_speed_high=speed)
        self._tuning = self._tuning._replace(limits=limits)
        self._begin_over(legs.upright_leg(Kind.DESCENT, (x, y, z), end, self.speeds))
        return end == ground

    def rise(self, height: float) -> None:
        self._begin_over(legs.upright_leg(Kind.CLIMB, self.place, height, self._default_climb))

    @property
    def _default_climb(self) -> MotionLimits:
        return MotionLimits(self.speeds.horizontal, self.limits.climb, self.limits.descent)

    @property
    def _still_moving(self) -> float:
        return 1.0 if self.this.kind in SHAPED else self.this.leave

    def descend(self, counted_from: float = 0.0) -> None:
        """Descend to the ground: at LAND_SPEED below LAND_ALT_LOW.

        It counts from the ground with a range finder, else from `counted_from` [m above home].
        """
        ground = self._ground.at(*self.here[:2])
        low = self.limits.land_low + (ground if self.limits.sees_ground else counted_from)
        self._tuning = self._tuning._replace(limits=self.limits._replace(land_low=low))
        leg = legs.upright_leg(Kind.DESCENT, self.here, ground, self.speeds)
        self._begin_over(leg._replace(leave=self._still_moving))

    def _begin_over(self, leg: CopterLeg) -> None:
        self._before = NO_LEG
        self.state.leg_time = 0.0
        self._begin(leg)


def _at_rest(place: Place, time: float) -> State:
    horizontal = complex(*place[:2])
    return State(time, horizontal, place[2], target=horizontal, target_z=place[2])
