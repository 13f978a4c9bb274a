"""PX4 in AUTO.MISSION, AUTO.RTL, AUTO.LAND and AUTO.LOITER: what it makes of each item, take-off and landing."""

import math
import random
from collections.abc import Callable

from ipoa_mission.autopilots.px4 import RANGE_LAG_S, STAGES, Px4Return, Px4Touchdown
from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.commands import Command
from ipoa_mission.items import Item
from ipoa_mission.simulator.body import GRAVITY, Body, Triple
from ipoa_mission.simulator.program import NAVIGATED
from ipoa_mission.simulator.px4_control import PositionControl
from ipoa_mission.simulator.px4_estimate import MotionEstimate
from ipoa_mission.simulator.px4_guidance import PathFollower
from ipoa_mission.simulator.px4_home import HomeHeight
from ipoa_mission.simulator.situation import FlightMode, MissionState, Situation

ON_GROUND_SINK = 0.7  # before taking off the target sinks at this rate [m/s]
NAVIGATOR_S = 0.05  # how often it is looked whether an item is done
HEADING_ERROR = math.radians(12.0)  # MIS_YAW_ERR
TURN_FIRST = 4.0  # MPC_YAW_MODE: the nose first, then the way
#: Items that hide the report of the waypoint before them (as measured).
HIDING = frozenset({Command.DO_JUMP, Command.DO_CHANGE_SPEED, Command.NAV_RETURN_TO_LAUNCH})
Manoeuvre = Callable[[float], None]


class PX4Pilot:
    """One manoeuvre at a time: a method that is called at each step."""

    def __init__(self, body: Body, situation: Situation, parameters: Parameters, chance: random.Random) -> None:
        self._body, self._now, self._p = body, situation, parameters
        body.attitude_s = 1.0 / parameters.get("MC_ROLL_P", 6.5)
        self._path = PathFollower(parameters)
        self._control = PositionControl(parameters, body.airframe.most_thrust)
        self._home = HomeHeight(chance)
        self._motion = MotionEstimate(chance)
        self._manoeuvre: Manoeuvre = self._wait
        self._goal: Triple = body.place
        self._radius = parameters["NAV_ACC_RAD"]
        self._heading: float | None = None  # none: the way it flies
        self._entered_s: float | None = None
        self._been_there = False
        self._touchdown = Px4Touchdown.of(parameters)
        self._stands, self._ground_lost = False, False
        self._sure, self._since_s = 0, 0.0  # of being landed: how many stages are over, and since when the next is on
        self._asked, self._believed_climb = GRAVITY, 0.0  # thrust that was asked for, climb rate that was believed
        self._ramp = 0.0
        self._next_check_s = 0.0
        self._above_home = False  # whether the goal's height moves with what home is believed to be

    # --- orders -----------------------------------------------------------------------------------------------------

    def enter(self) -> None:
        """The mode has changed."""
        match self._now.mode:
            case FlightMode.MISSION:
                self._begin(self._now.current)
            case FlightMode.RETURN:
                self._begin_return()
            case FlightMode.LAND:
                self._begin_landing(self._body.place)
            case FlightMode.HOLD:
                self._stay()

    def replaced(self, before: tuple[Item, ...]) -> None:
        """Another mission lies in the store while one is flown: it goes on at the present index."""
        self._begin(self._now.current)

    def step(self, dt: float) -> None:
        """Decide, and let the body move."""
        if not self._now.armed:
            self._ramp = 0.0
            self._body.step((0.0, 0.0), 0.0, dt)
            return
        if not self._now.landed:
            self._correct_home(dt)
        self._manoeuvre(dt)

    def _correct_home(self, dt: float) -> None:
        before = self._home.shift
        self._home.advance(dt)
        rise = self._home.shift - before
        if rise != 0.0 and self._above_home:
            x, y, z = self._goal
            self._goal = (x, y, z + rise)
            self._path.lift(rise)

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
                self._path.set_speed(item.params[1])
            self._now.done(index)
            self._next_check_s = self._now.time_s
            index = program.after(index, taking=True)
        if index is None or index >= len(program):
            self._now.mission = MissionState.COMPLETE
            self._now.mode = FlightMode.HOLD
            self._stay()
            return
        self._now.current = index
        self._start(index, program.items[index])

    def _done(self) -> None:
        items, index = self._now.program.items, self._now.current
        hidden = index + 1 < len(items) and items[index + 1].command in HIDING
        self._now.done(index, announced=not hidden)
        self._begin(self._now.program.after(index, taking=True))

    def _start(self, index: int, item: Item) -> None:
        here = self._body.place
        self._entered_s, self._been_there = None, False
        self._radius = self._p["NAV_ACC_RAD"]
        match item.command:
            case Command.NAV_TAKEOFF:
                self._begin_takeoff(self._place(index))
            case Command.NAV_RETURN_TO_LAUNCH:
                self._now.mission = MissionState.COMPLETE
                self._now.mode = FlightMode.RETURN
                self._now.done(index)
                self._begin_return()
            case Command.NAV_LAND:
                self._begin_landing(self._place(index) if item.has_position else here)
            case Command.NAV_DELAY:
                self._lead(self._goal)
                self._entered_s = self._now.time_s
                self._manoeuvre = self._delay
            case _ if self._now.landed:  # told to begin in the air: it takes off to that height first
                self._begin_takeoff(self._place(index))
            case _:
                self._fly_to(index, item)

    def _place(self, index: int) -> Triple:
        """Where item `index` is, by what home is believed to be."""
        x, y, z = self._now.program.place(index, self._body.place)
        return x, y, z + self._home.shift if self._now.program.is_above_home(index) else z

    def _begin_takeoff(self, target: Triple) -> None:
        here = self._body.place
        self._heading = self._body.yaw
        self._lead((here[0], here[1], max(target[2], here[2])))  # wherever home is believed to be by then
        self._path.begin(here, (0.0, 0.0, -ON_GROUND_SINK) if self._now.landed else self._body.motion)
        self._manoeuvre = self._take_off

    def _fly_to(self, index: int, item: Item) -> None:
        program = self._now.program
        if item.params[1] > 0.001 and item.command == Command.NAV_WAYPOINT:
            self._radius = item.params[1]
        heading = item.params[3]
        self._heading = math.radians(heading) if math.isfinite(heading) else None
        beyond = program.next_flown(index) if self._hold_s(item) <= 0.0 else None
        while beyond is not None and not program.items[beyond].has_position:
            if program.items[beyond].command == Command.NAV_RETURN_TO_LAUNCH:
                beyond = None
                break
            beyond = program.next_flown(beyond)
        self._lead(self._place(index), self._place(beyond) if beyond is not None else None, index)
        self._manoeuvre = self._follow

    @staticmethod
    def _hold_s(item: Item) -> float:
        if item.command == Command.NAV_LOITER_UNLIM:
            return math.inf
        return item.params[0] if item.command in (Command.NAV_WAYPOINT, Command.NAV_LOITER_TIME) else 0.0

    def _lead(self, goal: Triple, beyond: Triple | None = None, index: int | None = None) -> None:
        """Follow the line from the last goal to the next, item `index` if it is one of the mission's."""
        self._above_home = index is not None and self._now.program.is_above_home(index)
        self._path.lead(self._goal, goal, beyond, self._radius)
        self._goal = goal

    # --- manoeuvres: one is called at each step ---------------------------------------------------------------------

    def _wait(self, dt: float) -> None:
        """On the ground, motors idle."""
        self._body.step((0.0, 0.0), 0.0, dt)

    def _take_off(self, dt: float) -> None:
        if self._now.landed and self._now.time_s - self._now.armed_s < self._p["COM_SPOOLUP_TIME"]:
            self._path.begin(self._body.place, (0.0, 0.0, -ON_GROUND_SINK))
            self._control.reset()
            self._body.step((0.0, 0.0), 0.0, dt)
            return
        self._now.landed = False
        low = self._body.z < self._p["MPC_LAND_ALT1"]
        speed = min(self._p["MPC_TKO_SPEED"], self._p.get("MPC_Z_VEL_MAX_UP", 3.0))
        slow = (speed, speed / self._p["MPC_TKO_RAMP_T"])
        if low:
            self._path.axes[2].place = self._body.z
        self._ramp = min(self._ramp + dt / max(self._p["MPC_TKO_RAMP_T"], dt), 1.0)
        self._fly(dt, climb=slow if low else None)
        if self._is_check_due() and self._body.z > self._goal[2] - self._p["NAV_MC_ALT_RAD"]:
            self._lead(self._place(self._now.current), index=self._now.current)  # now a waypoint like any other
            self._manoeuvre = self._follow

    def _is_check_due(self) -> bool:
        """Whether the navigator, which runs less often than the controllers, looks at the place now."""
        if self._now.time_s < self._next_check_s - 1e-6:
            return False
        self._next_check_s = self._now.time_s + NAVIGATOR_S
        return True

    def _follow(self, dt: float) -> None:
        self._fly(dt)
        item = self._now.program.items[self._now.current]
        if self._entered_s is None and self._is_check_due():
            self._been_there = self._been_there or self._arrived()
            if self._been_there and self._is_headed():
                self._entered_s = self._now.time_s
        if self._entered_s is not None and self._now.time_s - self._entered_s >= self._hold_s(item):
            self._done()

    def _arrived(self) -> bool:
        body, goal = self._body, self._goal
        near = math.hypot(goal[0] - body.x, goal[1] - body.y) <= self._radius
        return near and abs(goal[2] - body.z) <= self._p["NAV_MC_ALT_RAD"]

    def _is_headed(self) -> bool:
        """Whether the nose points where the item says, if it says; having been at its place is enough for the rest."""
        if self._heading is None:
            return True
        return abs(math.remainder(self._heading - self._body.yaw, 2.0 * math.pi)) < HEADING_ERROR

    def _delay(self, dt: float) -> None:
        self._fly(dt)
        wait = self._now.program.items[self._now.current].params[0]
        if self._now.time_s - (self._entered_s or 0.0) >= wait:
            self._done()

    def _hover(self, dt: float) -> None:
        self._fly(dt)

    def _begin_return(self) -> None:
        here = self._body.place
        if self._now.landed:
            self._manoeuvre = self._wait
            return
        self._path.set_speed(self._p["MPC_XY_CRUISE"])
        self._radius = self._p["NAV_ACC_RAD"]
        self._heading = None
        home, low = math.hypot(here[0], here[1]), self._home.shift  # where it believes home to lie
        self._return_height = low + Px4Return.of(self._p).height(here[2] - low, home)
        self._goal = here
        self._lead((here[0], here[1], self._return_height))
        self._manoeuvre = self._climb_to_return

    def _climb_to_return(self, dt: float) -> None:
        self._fly(dt)
        if self._arrived():
            self._lead((0.0, 0.0, self._return_height), None)
            self._entered_s = None
            self._manoeuvre = self._go_home

    def _go_home(self, dt: float) -> None:
        self._fly(dt)
        if self._entered_s is None and self._arrived():
            self._entered_s = self._now.time_s
        if self._entered_s is not None and self._now.time_s - self._entered_s >= self._p["RTL_LAND_DELAY"]:
            self._begin_landing((0.0, 0.0, self._body.z))

    def _begin_landing(self, place: Triple) -> None:
        """Over the place first, at the present height, then down."""
        here = self._body.place
        if self._now.landed:
            self._manoeuvre = self._wait
            return
        self._stands, self._ground_lost, self._sure = False, False, 0
        over = (place[0], place[1], here[2])
        self._lead(over, None)
        away = math.hypot(over[0] - here[0], over[1] - here[1]) > self._radius
        self._manoeuvre = self._fly_over_landing if away else self._descend

    def _fly_over_landing(self, dt: float) -> None:
        self._fly(dt)
        if self._arrived():
            self._manoeuvre = self._descend

    def _descend(self, dt: float) -> None:
        """Sink, ever slower, and on the ground until it is sure to have landed; its simulator has a range finder.

        That finder's height lags; on the ground it is lost once the vehicle believes to be sinking on.
        """
        body = self._body
        self._stands = self._stands or body.on_ground
        self._ground_lost = self._ground_lost or (self._stands and self._believed_climb < 0.0)
        slow, fast = min(self._p["MPC_LAND_SPEED"], self._path.descent), self._path.descent
        low, high = self._p["MPC_LAND_ALT2"], max(self._p["MPC_LAND_ALT1"], self._p["MPC_LAND_ALT2"] + 1e-3)
        above = body.z - RANGE_LAG_S * body.vz
        share = min(max((above - low) / (high - low), 0.0), 1.0)
        crawls = above <= self._p.get("MPC_LAND_ALT3", 1.0) and not self._ground_lost
        self._fly(dt, sink=self._p.get("MPC_LAND_CRWL", 0.3) if crawls else slow + share * (fast - slow))
        self._feel_the_ground()

    def _feel_the_ground(self) -> None:
        """In contact, perhaps landed, landed: each once it has been quiet for long enough; then disarm."""
        known, now = self._touchdown, self._now
        if not now.landed:
            low = self._sure > 0 or self._asked <= known.low_thrust * GRAVITY
            if not (self._stands and low and abs(self._believed_climb) < known.most_speed):
                self._sure, self._since_s = 0, now.time_s
            elif now.time_s - self._since_s >= known.stage_s(self._ground_lost):
                self._sure, self._since_s = self._sure + 1, now.time_s
            if self._sure < STAGES:
                return
            now.landed = True
            if now.mode is FlightMode.MISSION:
                now.done(now.current)
                now.mission = MissionState.COMPLETE
        waits = NAVIGATOR_S if now.mode is FlightMode.MISSION else self._p.get("COM_DISARM_LAND", 2.0)  # (as recorded)
        if now.time_s - self._since_s >= waits:
            now.disarm()
            now.mode = FlightMode.HOLD
            self._manoeuvre = self._wait

    # --- following --------------------------------------------------------------------------------------------------

    def _stay(self) -> None:
        """Brake as the path's limits allow, and stay where that ends."""
        if self._now.landed:
            self._manoeuvre = self._wait
            return
        body, most = self._body, self._p["MPC_ACC_HOR"]
        speed = math.hypot(body.vx, body.vy)
        way = speed / (2.0 * most) + most / (2.0 * self._p["MPC_JERK_AUTO"])
        self._goal = body.place
        self._lead((body.x + body.vx * way, body.y + body.vy * way, body.z))
        self._manoeuvre = self._hover

    def _fly(self, dt: float, climb: tuple[float, float] | None = None, sink: float | None = None) -> None:
        body, path, at = self._body, self._path, self._body.place
        up = self._p.get("MPC_Z_VEL_MAX_UP", 3.0)
        down = max(self._p.get("MPC_Z_VEL_MAX_DN", 1.5), 1.2 * path.descent)
        if self._ramp < 1.0:
            none = -GRAVITY / self._p.get("MPC_Z_VEL_P_ACC", 4.0)
            up = none + self._ramp * (up - none)
        place, push = path.place, path.push
        if self._ramp < 1.0:
            push = (push[0], push[1], 0.0)
        seen = (at, self._motion.of(body.motion, dt))
        self._believed_climb = seen[1][2]
        lean, thrust = self._control.lean_and_thrust(body, seen, place, path.motion, push, (up, down), dt)
        self._asked = thrust
        left = self._turn(dt)
        body.step(lean, 0.0 if self._stands else thrust, dt)
        turning = self._p["MPC_YAW_MODE"] == TURN_FIRST and left > HEADING_ERROR and self._manoeuvre == self._follow
        path.advance(at, dt, climb, sink, turning)

    def _turn(self, dt: float) -> float:
        """Turn the nose; by how much it is off [rad]."""
        heading = self._heading
        if heading is None:
            east, north = self._goal[0] - self._body.x, self._goal[1] - self._body.y
            heading = math.atan2(east, north) if math.hypot(east, north) > self._radius else self._body.yaw
        rate = math.radians(self._p["MPC_YAWRAUTO_MAX"])
        self._body.turn(heading, rate, math.radians(self._p.get("MPC_YAWRAUTO_ACC", 20.0)), dt)
        return abs(math.remainder(heading - self._body.yaw, 2.0 * math.pi))
