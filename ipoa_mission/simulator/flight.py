"""A simulated flight: what the built-in autopilot does with a mission, moment by moment.

Deterministic and without a clock: `advance(to_s)` integrates to that simulated second and no further.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from ipoa_mission.geometry import Vector
from ipoa_mission.mission.items import SAME_FRAME, Command, Frame, Item
from ipoa_mission.vehicle import DEFAULT_PARAMETERS, Autopilot, Parameters
from ipoa_mission.world.frame import Geodetic, LocalFrame

STEP_S = 0.02


class MissionState(IntEnum):
    """MAVLink's MISSION_STATE."""

    UNKNOWN = 0
    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class FlightMode(IntEnum):
    """What the vehicle is asked to do."""

    HOLD = 0
    MISSION = 1
    RETURN = 2
    LAND = 3


@dataclass(frozen=True)
class Reached:
    """Item `index` was done at `time_s`; `announced`: whether this autopilot tells so (MISSION_ITEM_REACHED)."""

    index: int
    time_s: float
    announced: bool = True


class Flight:
    """One vehicle from its home on the ground: state lives through time."""

    def __init__(self, autopilot: Autopilot, home: Geodetic, parameters: Parameters) -> None:
        self.autopilot = autopilot
        self.home = home
        self.parameters = {**DEFAULT_PARAMETERS[autopilot], **parameters}
        self.frame = LocalFrame(home)
        self.time_s = 0.0
        self.armed = False
        self.landed = True
        self.mode = FlightMode.HOLD
        self.mission_state = MissionState.NO_MISSION
        self.current = 0
        self.reached: tuple[Reached, ...] = ()
        self.yaw = self.roll = self.pitch = 0.0
        self._items: tuple[Item, ...] = ()
        self._at = [0.0, 0.0, 0.0]
        self._velocity = [0.0, 0.0, 0.0]
        self._acceleration = [0.0, 0.0, 0.0]
        self._goal = [0.0, 0.0, 0.0]
        self._arrived_s: float | None = None
        self._phase = 0
        self._jumps: dict[int, int] = {}
        self._started = False
        is_px4 = autopilot is Autopilot.PX4
        scale = 1.0 if is_px4 else 0.01
        names = (
            ("MPC_XY_CRUISE", "MPC_Z_V_AUTO_UP", "MPC_Z_V_AUTO_DN", "MPC_ACC_HOR", "NAV_ACC_RAD", "MPC_LAND_SPEED")
            if is_px4
            else ("WPNAV_SPEED", "WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_RADIUS", "LAND_SPEED")
        )
        self._cruise, self._up, self._down, self._accel, self._radius, self._land_speed = (
            self.parameters[name] * scale for name in names
        )
        self._jerk = self.parameters["MPC_JERK_AUTO"] if is_px4 else 5.0
        self._return_height = self.parameters["RTL_RETURN_ALT"] if is_px4 else self.parameters["RTL_ALT"] * 0.01

    @property
    def local(self) -> Vector:
        """East, north, up of home, (3,) [m]."""
        return np.array(self._at)

    @property
    def velocity(self) -> Vector:
        """East, north, up, (3,) [m/s]."""
        return np.array(self._velocity)

    @property
    def position(self) -> Geodetic:
        """Where the vehicle is, altitude AMSL."""
        return self.frame.geodetic(self.local)

    def load(self, items: tuple[Item, ...]) -> None:
        """Take a new mission (without home; none: the mission is cleared); in flight the present index stays."""
        if items == self._items:
            return
        self._items = items
        self._jumps = {}
        if not items:
            self.mission_state = MissionState.NO_MISSION
            self.current = 0
            if self.mode is FlightMode.MISSION:
                self.hold()
            return
        if self.current >= len(items) or self.landed:
            self.current = 0
        if self.mode is FlightMode.MISSION:
            self._enter(self.current)
        else:
            self.mission_state = MissionState.NOT_STARTED if self.landed else MissionState.PAUSED

    def arm(self) -> None:
        """Let the motors run."""
        self.armed = True

    def disarm(self) -> None:
        """Stop the motors."""
        self.armed = False

    def start(self) -> None:
        """Enter the mission mode; nothing moves before the vehicle is armed."""
        if not self._items:
            return
        if self.mission_state is MissionState.COMPLETE:
            self.current = 0
        self.mode = FlightMode.MISSION
        self.mission_state = MissionState.ACTIVE
        self._enter(self.current)

    def hold(self) -> None:
        """Stop and stay."""
        self.mode = FlightMode.HOLD
        self._goal = list(self._at)
        if self.mission_state is MissionState.ACTIVE:
            self.mission_state = MissionState.PAUSED

    def set_current(self, index: int) -> None:
        """Go on with item `index`; ValueError where there is none."""
        if not 0 <= index < len(self._items):
            raise ValueError(f"index: expected 0 to {len(self._items) - 1}, not {index}")
        self.current = index
        if self.mode is FlightMode.MISSION:
            self._enter(index)
        elif self.mission_state is MissionState.COMPLETE:
            self.mission_state = MissionState.PAUSED

    def return_home(self) -> None:
        """Return to home and land there."""
        self.mode = FlightMode.RETURN
        self._phase = 0

    def land(self) -> None:
        """Land here."""
        self.mode = FlightMode.LAND
        self._goal = [*self._at[:2], 0.0]

    def advance(self, to_s: float) -> None:
        """Integrate to this simulated time."""
        while self.time_s + STEP_S <= to_s + 1e-9:
            self._step(STEP_S)
            self.time_s += STEP_S

    def _enter(self, index: int) -> None:
        self.current = index
        self._arrived_s = None
        self._phase = 0
        item = self._items[index]
        if item.command == Command.NAV_LAND:
            self._goal = [*self._at[:2], 0.0]
        if item.command == Command.NAV_TAKEOFF:
            self._goal = [*self._at[:2], self._height(item)]
        elif item.has_position:
            place = Geodetic(item.latitude_deg, item.longitude_deg, self.home.altitude + self._height(item))
            self._goal = [float(x) for x in self.frame.local(place)]

    def _height(self, item: Item) -> float:
        match SAME_FRAME.get(item.frame, item.frame):  # type: ignore[call-overload]
            case Frame.GLOBAL:
                return item.altitude - self.home.altitude
            case _:
                return item.altitude

    def _step(self, dt: float) -> None:
        if not self.armed:
            return
        if self.mode is FlightMode.MISSION:
            self._follow_items()
        elif self.mode is FlightMode.RETURN:
            self._return_and_land()
        elif self.mode is FlightMode.LAND:
            self._come_down()
        if self.armed:
            self._move(dt)

    def _follow_items(self) -> None:
        item = self._items[self.current]
        match item.command:
            case Command.DO_CHANGE_SPEED:
                if item.params[1] > 0:
                    self._cruise = item.params[1]
                self._done()
            case Command.DO_JUMP:
                count = self._jumps.get(self.current, 0)
                if item.params[1] < 0 or count < item.params[1]:
                    self._jumps[self.current] = count + 1
                    target = int(item.params[0]) - (self.autopilot is Autopilot.ARDUPILOT)
                    self._enter(min(max(target, 0), len(self._items) - 1))
                else:
                    self._done()
            case Command.NAV_RETURN_TO_LAUNCH:
                self._return_and_land()
            case Command.NAV_LAND:
                self._come_down()
            case Command.NAV_LOITER_UNLIM:
                pass
            case Command.NAV_DELAY:
                self._arrived_s = self.time_s if self._arrived_s is None else self._arrived_s
                if self.time_s - self._arrived_s >= item.params[0]:
                    self._done()
            case _:
                hold = 0.0
                if item.command in (Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME):
                    hold = item.params[0]
                if not item.has_position and item.command != Command.NAV_TAKEOFF:
                    self._done()
                elif self._arrived_s is None:
                    if math.dist(self._at, self._goal) < self._radius:
                        self._arrived_s = self.time_s
                elif self.time_s - self._arrived_s >= hold:
                    self._done()

    def _done(self) -> None:
        self.reached += (Reached(self.current, self.time_s),)
        if self.current + 1 < len(self._items):
            self._enter(self.current + 1)
        else:
            self.hold()
            self.mission_state = MissionState.COMPLETE

    def _return_and_land(self) -> None:
        if self._phase == 0:
            self._goal = [*self._at[:2], max(self._at[2], self._return_height)]
            self._phase = 1
        elif self._phase == 1 and abs(self._at[2] - self._goal[2]) < 0.5:
            self._goal = [0.0, 0.0, self._goal[2]]
            self._phase = 2
        elif self._phase == 2 and math.dist(self._at, self._goal) < self._radius / 2:
            self._goal = [0.0, 0.0, 0.0]
            self._phase = 3
        if self._phase == 3:
            self._come_down()

    def _come_down(self) -> None:
        self._goal[2] = 0.0
        if self._at[2] <= 0.0 and not self.landed:
            self._velocity = [0.0, 0.0, 0.0]
            self._acceleration = [0.0, 0.0, 0.0]
            self.landed = True
            self.armed = False
            if self.mode is FlightMode.MISSION:
                self.reached += (Reached(self.current, self.time_s),)
                self.mission_state = MissionState.COMPLETE
            self.mode = FlightMode.HOLD

    def _move(self, dt: float) -> None:
        away = [g - p for g, p in zip(self._goal, self._at, strict=True)]
        flat = math.hypot(away[0], away[1])
        speed = min(self._cruise, math.sqrt(2 * 0.6 * self._accel * flat), flat)
        wanted = [speed * away[0] / flat, speed * away[1] / flat, 0.0] if flat > 1e-6 else [0.0, 0.0, 0.0]
        down = self._land_speed if self._goal[2] <= 0.0 and self._at[2] < 8.0 else self._down
        wanted[2] = min(self._up, away[2]) if away[2] > 0 else -min(down, max(-away[2], self._land_speed))
        for i in range(3):
            push = (wanted[i] - self._velocity[i]) * 1.5
            push = min(max(push, -self._accel), self._accel)
            change = min(max(push - self._acceleration[i], -self._jerk * dt), self._jerk * dt)
            self._acceleration[i] += change
            self._velocity[i] += self._acceleration[i] * dt
            self._at[i] += self._velocity[i] * dt
        if self._at[2] > 0.1:
            self.landed = False
        if flat > 1.0:
            self.yaw = math.atan2(away[0], away[1])
        self._at[2] = max(self._at[2], 0.0)
