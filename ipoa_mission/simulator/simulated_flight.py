"""A controller that decides as PX4 or ArduPilot does steers a body under gravity, air and thrust.

Deterministic and without a clock: `advance` integrates.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import GRAVITY, Vector
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.simulator.situation import (
    STANDARD_CONDITIONS,
    STEP_S,
    Conditions,
    FlightMode,
    ItemDone,
    MissionState,
    SimulatedVehicle,
    Situation,
)


class FlightController(Protocol):
    def enter(self) -> None:
        """Follow a new mode or current item."""

    def replaced(self, before: tuple[Item, ...]) -> None:
        """Continue after the mission was replaced in flight."""

    def climb(self, height: float) -> None:
        """Take off to a height above home [m], and hold."""

    @property
    def rising(self) -> bool: ...

    def go_to(self, east: float, north: float, up: float, speed: float) -> None:
        """Fly there and hold; NaN: the present target, height or default speed."""

    def step(self) -> None: ...


@dataclass(frozen=True)
class FlightControllers:
    """`make` makes a flight's controller; its random numbers are sensor errors."""

    make: Callable[[SimulatedVehicle, Situation, Parameters, random.Random], FlightController]


class SimulatedFlight:
    def __init__(
        self, autopilot: Autopilot, home: Geodetic, parameters: Parameters, conditions: Conditions = STANDARD_CONDITIONS
    ) -> None:
        """`parameters` are read again at each arming."""
        self.autopilot = autopilot
        self.home = home
        self.frame = LocalFrame(home)
        self._parameters = parameters
        self._body = SimulatedVehicle(conditions)
        self._now = Situation(self._program(()))
        self._chance = random.Random(conditions.seed)
        self._last_position: tuple[object, Geodetic] = None, home
        self._controller = self._new_controller()

    def _new_controller(self) -> FlightController:
        return self.autopilot.part(FlightControllers).make(self._body, self._now, self.parameters, self._chance)

    @property
    def parameters(self) -> Parameters:
        """ArduCopter's by their names before 4.7."""
        return self.autopilot.complete(self._parameters, self._body.conditions.version)

    @property
    def time_s(self) -> float:
        return self._now.time_s

    @property
    def armed(self) -> bool:
        return self._now.armed

    @property
    def landed(self) -> bool:
        return self._body.on_ground

    @property
    def mode(self) -> FlightMode:
        return self._now.mode

    @property
    def mission_state(self) -> MissionState:
        return self._now.mission

    @property
    def current(self) -> int:
        return self._now.current

    @property
    def reached(self) -> tuple[ItemDone, ...]:
        return tuple(self._now.reached)

    @property
    def local(self) -> Vector:
        """East, north, up of home, (3,) [m]."""
        return np.array(self._body.place)

    @property
    def velocity(self) -> Vector:
        """East, north, up, (3,) [m/s]."""
        return np.array(self._body.motion)

    @property
    def position(self) -> Geodetic:
        """The altitude AMSL ignores the Earth's curvature, as autopilots do."""
        place = self._body.place
        if place != self._last_position[0]:  # several streams show one place
            there = self.frame.geodetic(np.array([*place[:2], 0.0]))
            self._last_position = (
                place,
                Geodetic(there.latitude_deg, there.longitude_deg, self.home.altitude + place[2]),
            )
        return self._last_position[1]

    @property
    def yaw(self) -> float:
        """Clockwise from north [rad]."""
        return self._body.yaw

    @property
    def pitch(self) -> float:
        """Positive nose up [rad]."""
        east, north = self._body.lean_x, self._body.lean_y
        return -math.atan2(east * math.sin(self.yaw) + north * math.cos(self.yaw), GRAVITY)

    @property
    def roll(self) -> float:
        """Positive right side down [rad]."""
        east, north = self._body.lean_x, self._body.lean_y
        return math.atan2(east * math.cos(self.yaw) - north * math.sin(self.yaw), GRAVITY)

    def load(self, items: tuple[Item, ...]) -> None:
        """Without home, maybe empty; in flight the current index stays."""
        now, before = self._now, self._now.program.items
        if items == before:
            return
        now.program = self._program(items)
        if not items:
            now.mission, now.current = MissionState.NO_MISSION, 0
            if now.mode is FlightMode.MISSION:
                self.hold()
            return
        if now.current >= len(items):
            now.current = self.autopilot.guidance.past_the_end % len(items)
        if now.mode is FlightMode.MISSION:
            self._controller.replaced(before)
        else:
            now.mission = MissionState.NOT_STARTED if self.landed else MissionState.PAUSED

    def know_rally(self, items: tuple[Item, ...]) -> None:
        """Heights above home, for later returns."""
        at = [(self.frame.local(Geodetic(i.latitude_deg, i.longitude_deg, self.home.altitude)), i) for i in items]
        self._now.rally = tuple((float(place[0]), float(place[1]), item.height(self.home)) for place, item in at)

    def _program(self, items: tuple[Item, ...]) -> Program:
        first, version = self.autopilot.guidance.first_item, self._body.conditions.version
        return Program(items, self.frame, self.autopilot, first=first, version=version)

    def arm(self) -> None:
        if self.armed:
            return
        self._now.armed, self._now.armed_s = True, self.time_s
        self._now.reached.clear()
        self._controller = self._new_controller()
        self._controller.enter()

    def disarm(self) -> None:
        self._now.disarm()

    def start(self) -> None:
        """Nothing moves before arming."""
        now = self._now
        if not now.program.items:
            return
        if now.mission is MissionState.COMPLETE:
            now.current = 0
            now.program.jumped.clear()
        now.mission = MissionState.ACTIVE
        self.enter(FlightMode.MISSION)

    def hold(self) -> None:
        if self._now.mission is MissionState.ACTIVE:
            self._now.mission = MissionState.PAUSED
        self.enter(FlightMode.HOLD)

    def set_current(self, index: int) -> None:
        """Raise ValueError if there is none."""
        now = self._now
        if not 0 <= index < len(now.program):
            raise ValueError(f"index: expected 0 to {len(now.program) - 1}, not {index}")
        now.current = index
        if now.mode is FlightMode.MISSION:
            self._controller.enter()
        elif now.mission is MissionState.COMPLETE:
            now.mission = MissionState.PAUSED

    def rewind(self) -> None:
        """The mission must not be flown now."""
        self._now.current = 0
        self._now.program.jumped.clear()
        if self._now.program.items:
            self._now.mission = MissionState.NOT_STARTED

    def climb(self, height: float) -> None:
        self._now.mode = FlightMode.HOLD
        self._controller.climb(height)

    @property
    def rising(self) -> bool:
        return self._controller.rising

    def go_to(self, latitude_deg: float, longitude_deg: float, altitude: float, speed: float) -> None:
        self._now.mode = FlightMode.HOLD
        east = north = math.nan
        if math.isfinite(latitude_deg) and math.isfinite(longitude_deg):
            east, north, _ = map(float, self.frame.local(Geodetic(latitude_deg, longitude_deg, self.home.altitude)))
        self._controller.go_to(east, north, altitude - self.home.altitude, speed)

    def advance(self, to_s: float) -> None:
        now = self._now
        while now.time_s + STEP_S <= to_s + 1e-9:
            self._controller.step()
            now.time_s += STEP_S

    def enter(self, mode: FlightMode) -> None:
        self._now.mode = mode
        self._controller.enter()
