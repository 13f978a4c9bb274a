"""ArduCopter in AUTO, RTL, LAND and LOITER: what it makes of each item, and how it takes off and lands."""

import math
import random
from collections.abc import Callable

from ipoa_mission.autopilots.ardupilot import ARMING_DELAY_S, CENTIMETRE, LAND_DETECTOR_S, LIFT_S, THROTTLE_DOWN_S
from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.commands import Command
from ipoa_mission.items import Item
from ipoa_mission.simulator.ardupilot_control import PositionControl, ShapedHeight, speed_towards
from ipoa_mission.simulator.ardupilot_guidance import PathFollower, Stop
from ipoa_mission.simulator.body import GRAVITY, Body
from ipoa_mission.simulator.program import NAVIGATED
from ipoa_mission.simulator.scurve import Triple
from ipoa_mission.simulator.situation import FlightMode, MissionState, Situation

ROUNDING = 1e-4  # of heights, in single precision [m]: a waypoint over the take-off point is a leg nevertheless
FLOWN_THROUGH = frozenset(
    {Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME}
)
CONE, LEAST_CONE = 3.0, 0.5  # RTL_CONE_SLOPE, and the least that counts
Manoeuvre = Callable[[float], None]


class ArduPilotPilot:
    """One submode at a time: a method that is called at each step, and returns when there is no more to do."""

    def __init__(self, body: Body, situation: Situation, parameters: Parameters, chance: random.Random) -> None:
        """`chance` is not asked: ArduCopter's simulated flights repeat to a tenth of a second."""
        self._body, self._now, self._p = body, situation, parameters
        body.attitude_s = max(parameters["ATC_INPUT_TC"], 0.01)
        self._path = PathFollower(parameters)
        self._control = PositionControl(parameters)
        self._height = ShapedHeight(parameters)
        self._manoeuvre: Manoeuvre = self._wait
        self._until_s = math.inf
        self._touched_s: float | None = None
        self._heading = body.yaw
        self._lift_s = ARMING_DELAY_S + 2.0 * parameters["MOT_SPOOL_TIME"] + LIFT_S

    # --- orders -----------------------------------------------------------------------------------------------------

    def enter(self) -> None:
        """The mode has changed."""
        match self._now.mode:
            case FlightMode.MISSION:
                self._begin(self._now.current)
            case FlightMode.RETURN:
                self._begin_return()
            case FlightMode.LAND:
                self._begin_landing()
            case FlightMode.HOLD:
                self._stay()

    def replaced(self, before: tuple[Item, ...]) -> None:
        """Another mission lies in the store while this one is flown: go on; a waypoint that differs begins anew."""
        now, after = self._now.current, self._now.program.items
        ahead = slice(now, now + 3)
        if self._manoeuvre == self._follow and before[ahead] != after[ahead] and now < len(after):
            self._begin(now)

    def climb(self, height: float) -> None:
        """Take off outside a mission, in GUIDED, to a height above home."""
        self._begin_takeoff((self._body.x, self._body.y, height))

    def step(self, dt: float) -> None:
        """Decide, and let the body move."""
        if not self._now.armed or self._now.time_s - self._now.armed_s < self._lift_s:
            self._body.step((0.0, 0.0), 0.0, dt)
            return
        self._manoeuvre(dt)

    # --- the mission ------------------------------------------------------------------------------------------------

    def _begin(self, index: int | None) -> None:
        """Start item `index`, doing at once those at which no time is spent."""
        program = self._now.program
        while index is not None and index < len(program) and program.items[index].command not in NAVIGATED:
            item = program.items[index]
            self._now.current = index
            if item.command == Command.DO_JUMP:
                index = program.after(index - 1, taking=True)
                continue
            if item.command == Command.DO_CHANGE_SPEED and item.params[1] > 0.0 and item.params[0] in (0.0, 1.0):
                self._path.change_speed(item.params[1])
            self._now.done(index)
            index = program.after(index, taking=True)
        if index is None or index >= len(program):
            self._now.mission = MissionState.COMPLETE
            self._stay()
            return
        self._now.current = index
        self._start(index, program.items[index])

    def _done(self) -> None:
        self._now.done(self._now.current)
        self._begin(self._now.program.after(self._now.current, taking=True))

    def _start(self, index: int, item: Item) -> None:
        self._until_s = math.inf
        match item.command:
            case Command.NAV_TAKEOFF:
                self._begin_takeoff(self._now.program.place(index, self._body.place))
            case Command.NAV_RETURN_TO_LAUNCH:
                self._begin_return()
            case Command.NAV_LAND:
                self._begin_landing(self._now.program.place(index, self._body.place) if item.has_position else None)
            case Command.NAV_DELAY:
                self._stay()
                self._until_s = self._now.time_s + max(item.params[0], 0.0)
            case _ if self._now.landed:  # it stays on the ground
                self._manoeuvre = self._wait
            case _:
                self._fly_to(index)

    def _fly_to(self, index: int) -> None:
        program, here = self._now.program, self._body.place
        if self._manoeuvre not in (self._follow, self._hold) or not self._path.reached:
            self._path.begin(self._complete if self._manoeuvre == self._take_off else self._stopping_place())
            if self._manoeuvre != self._take_off:
                self._control.reset()
        after = program.next_flown(index) if self._passes(program.items[index]) else None
        following = self._stop(after) if after is not None and program.items[after].command in FLOWN_THROUGH else None
        self._path.fly_to(self._stop(index), following)
        self._look_at(program.place(index, here))
        self._manoeuvre = self._follow

    @staticmethod
    def _passes(item: Item) -> bool:
        """Whether a waypoint is left without stopping."""
        return item.command in (Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT) and int(item.params[0]) <= 0

    def _stop(self, index: int) -> Stop:
        program, here = self._now.program, self._body.place
        item = program.items[index]
        place = program.place(index, here)
        if item.command != Command.NAV_SPLINE_WAYPOINT:
            return Stop(place)
        after = program.next_flown(index) if self._passes(item) else None
        if after is None or program.items[after].command not in FLOWN_THROUGH or not program.items[after].has_position:
            return Stop(place, True)
        beyond = program.items[after].command == Command.NAV_SPLINE_WAYPOINT
        return Stop(place, True, program.place(after, here), beyond)

    # --- manoeuvres: one is called at each step ---------------------------------------------------------------------

    def _wait(self, dt: float) -> None:
        """On the ground, motors idle."""
        self._body.step((0.0, 0.0), 0.0, dt)

    def _follow(self, dt: float) -> None:
        self._path.advance(self._body, dt)
        self._track(dt)
        if not self._path.reached:
            return
        item = self._now.program.items[self._now.current]
        wait = int(item.params[0]) if item.command != Command.NAV_LOITER_UNLIM else math.inf
        if wait > 0:
            self._until_s = self._now.time_s + wait
            self._manoeuvre = self._hold
        else:
            self._done()

    def _hold(self, dt: float) -> None:
        """Stay at the end of the path, for a time or for good."""
        self._path.advance(self._body, dt)
        self._track(dt)
        if self._now.time_s >= self._until_s:
            self._done()

    def _begin_takeoff(self, target: Triple) -> None:
        here = self._body.place
        self._complete: Triple = (here[0], here[1], max(target[2], here[2]))
        self._height.begin(here[2], self._body.vz)
        self._control.reset()
        self._heading = self._body.yaw
        self._now.landed = False
        self._manoeuvre = self._take_off

    def _take_off(self, dt: float) -> None:
        x, y, top = self._complete
        most = self._path.speeds[1]
        self._height.approach(top, most, dt)
        self._fly((x, y), dt)
        if self._height.height >= top - 0.01 and self._height.climb < 0.1 * most:
            self._complete = (self._body.x, self._body.y, top + ROUNDING)
            self._done() if self._now.mode is FlightMode.MISSION else self._stay()

    def _begin_return(self) -> None:
        here = self._stopping_place()
        home = math.hypot(here[0], here[1])
        least = here[2] + max(self._p.get("RTL_CLIMB_MIN", 0.0) / 100, 0.0)
        height, cone = max(least, self._p["RTL_ALT"] / 100), self._p.get("RTL_CONE_SLOPE", CONE)
        if cone >= LEAST_CONE:
            height = min(height, max(cone * home, least))
        self._path.speeds = (self._p["RTL_SPEED"] / 100 or self._p["WPNAV_SPEED"] / 100, *self._path.speeds[1:])
        self._return_height = _whole_centimeters(height)
        self._path.begin(here)
        self._path.fly_to(Stop((here[0], here[1], self._return_height)), Stop((0.0, 0.0, self._return_height)))
        self._manoeuvre = self._climb_to_return

    def _climb_to_return(self, dt: float) -> None:
        self._path.advance(self._body, dt)
        self._track(dt)
        if self._path.reached:
            self._path.fly_to(Stop((0.0, 0.0, self._return_height)), None)
            self._look_at((0.0, 0.0, 0.0))
            self._manoeuvre = self._go_home

    def _go_home(self, dt: float) -> None:
        self._path.advance(self._body, dt)
        self._track(dt)
        if self._path.reached:
            self._until_s = self._now.time_s + self._p["RTL_LOIT_TIME"] / 1000
            self._manoeuvre = self._wait_at_home

    def _wait_at_home(self, dt: float) -> None:
        self._path.advance(self._body, dt)
        self._track(dt)
        if self._now.time_s >= self._until_s:
            if self._p["RTL_ALT_FINAL"] > 0.0:
                self._path.fly_to(Stop((0.0, 0.0, self._p["RTL_ALT_FINAL"] / 100)), None)
                self._manoeuvre = self._hold
                self._until_s = math.inf
            else:
                self._begin_descent((0.0, 0.0))

    def _begin_landing(self, place: Triple | None = None) -> None:
        if place is None:
            stop = self._stopping_place()
            self._begin_descent((stop[0], stop[1]))
            return
        if self._manoeuvre not in (self._follow, self._hold) or not self._path.reached:
            self._path.begin(self._stopping_place())
        self._path.fly_to(Stop((place[0], place[1], _whole_centimeters(self._body.z))), None)
        self._manoeuvre = self._fly_over_landing

    def _fly_over_landing(self, dt: float) -> None:
        self._path.advance(self._body, dt)
        self._track(dt)
        if self._path.reached:
            self._begin_descent((self._path.place[0], self._path.place[1]))

    def _begin_descent(self, over: tuple[float, float]) -> None:
        self._over = over
        self._height.begin(self._body.z, self._body.vz)
        self._touched_s = None
        self._manoeuvre = self._descend

    def _descend(self, dt: float) -> None:
        if self._body.on_ground and self._touched_s is None:
            self._touched_s = self._now.time_s
        if self._touched_s is not None:
            self._stand(dt)
            return
        slow = self._p["LAND_SPEED"] / 100
        fast = max(self._p["LAND_SPEED_HIGH"] / 100 or self._path.speeds[2], slow)
        above = self._body.z - max(self._p["LAND_ALT_LOW"] / 100, 1.0)
        rate = speed_towards(above, self._p.get("PSC_POSZ_P", 1.0), self._p["WPNAV_ACCEL_Z"] / 100)
        self._height.sink_or_climb(-min(max(rate, slow), fast), dt)
        self._fly(self._over, dt)

    def _stand(self, dt: float) -> None:
        """On the ground with the throttle running down, until it is sure to have landed."""
        self._body.step((0.0, 0.0), 0.0, dt)
        stood = self._now.time_s - (self._touched_s or 0.0)
        self._now.landed = stood >= THROTTLE_DOWN_S + LAND_DETECTOR_S
        if stood >= THROTTLE_DOWN_S + LAND_DETECTOR_S + self._p["MOT_SPOOL_TIME"]:  # motors spun down
            if self._now.mode is FlightMode.MISSION:
                last = self._now.program.items[self._now.current].command == Command.NAV_LAND
                self._now.done(self._now.current, announced=not last)
                self._now.mission = MissionState.COMPLETE
            self._now.disarm()
            self._now.mode = FlightMode.HOLD
            self._manoeuvre = self._wait

    # --- following --------------------------------------------------------------------------------------------------

    def _stay(self) -> None:
        """Brake, and stay where that ends."""
        if self._now.landed:
            self._manoeuvre = self._wait
            return
        if self._manoeuvre not in (self._follow, self._hold) or not self._path.reached:
            self._path.begin(self._stopping_place())
        self._until_s = math.inf
        self._manoeuvre = self._hold

    def _stopping_place(self) -> Triple:
        body, most = self._body, self._p["WPNAV_ACCEL"] / 100
        speed = math.hypot(body.vx, body.vy)
        near = most / self._p.get("PSC_POSXY_P", 1.0) ** 2
        way = speed if speed <= near else 0.5 * near + speed * speed / (2.0 * most)
        share = way / speed if speed > 0.1 else 0.0
        up = body.vz * abs(body.vz) / (2.0 * self._p["WPNAV_ACCEL_Z"] / 100)
        return body.x + body.vx * share, body.y + body.vy * share, max(body.z + up, 0.0)

    def _look_at(self, place: Triple) -> None:
        east, north = place[0] - self._body.x, place[1] - self._body.y
        if self._p["WP_YAW_BEHAVIOR"] > 0 and math.hypot(east, north) > 2.0:
            self._heading = math.atan2(east, north)

    def _track(self, dt: float) -> None:
        path, body = self._path, self._body
        lean = self._control.lean(body, path.place, path.motion, path.push, dt)
        thrust = self._control.thrust(body, path.place[2], path.motion[2], path.push[2] * path.pace)
        self._move(lean, thrust, dt)

    def _fly(self, over: tuple[float, float], dt: float) -> None:
        """Straight up or down over a place."""
        height = self._height
        lean = self._control.lean(self._body, (*over, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), dt)
        thrust = self._control.thrust(self._body, height.height, height.climb, height.push)
        self._move(lean, max(thrust, 0.2 * GRAVITY), dt)

    def _move(self, lean: tuple[float, float], thrust: float, dt: float) -> None:
        slew = math.radians(self._p.get("ATC_SLEW_YAW", 6000.0) / 100)
        self._body.turn(self._heading, slew, math.radians(270.0), dt)
        self._body.step(lean, thrust, dt)


def _whole_centimeters(height: float) -> float:
    """A height as ArduCopter keeps that of a place."""
    return math.floor(height / CENTIMETRE) * CENTIMETRE
