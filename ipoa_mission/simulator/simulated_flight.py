"""A body under gravity, air and thrust, steered by a controller of PX4 or ArduPilot; deterministic, without a clock."""

import math
import random
from dataclasses import replace

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import GRAVITY
from ipoa_mission.link.messages import MissionState
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.simulator.mock_profile import FlightController, MockProfile
from ipoa_mission.simulator.situation import STANDARD_CONDITIONS, STEP_S, Conditions, FlightMode, Situation


class SimulatedFlight(Situation):
    def __init__(
        self, autopilot: Autopilot, home: Geodetic, parameters: Parameters, conditions: Conditions = STANDARD_CONDITIONS
    ) -> None:
        """`parameters` are read again at each arming."""
        self.autopilot = autopilot
        self.home = home
        self.frame = LocalFrame(home)
        self.conditions = conditions
        self._parameters = parameters
        super().__init__(self._program(()), conditions)
        self._chance = random.Random(conditions.seed)
        self._last_position: tuple[object, Geodetic] = None, home
        self._controller = self._new_controller()

    def _new_controller(self) -> FlightController:
        return self.autopilot.part(MockProfile).controller(self, self.parameters, self._chance)

    def _program(self, items: tuple[Item, ...]) -> Program:
        first = self.autopilot.guidance.first_item
        return Program(items, self.frame, self.autopilot, first=first, version=self.conditions.version)

    @property
    def parameters(self) -> Parameters:
        """ArduCopter's by their names before 4.7, without values that would stop a flight."""
        return self.autopilot.parameter_table.usable(self.autopilot.complete(self._parameters, self.conditions.version))

    @property
    def position(self) -> Geodetic:
        """The altitude AMSL ignores the Earth's curvature, as autopilots do."""
        place = self.place
        if place != self._last_position[0]:  # several streams show one place
            there = self.frame.geodetic(np.array([*place[:2], 0.0]))
            self._last_position = place, replace(there, altitude=self.home.altitude + place[2])
        return self._last_position[1]

    @property
    def attitude(self) -> tuple[float, float, float]:
        """Return roll (right side down), pitch (nose up), yaw (clockwise from north) [rad]."""
        east, north = self.tilt_accel
        yaw = self.yaw
        forward = east * math.sin(yaw) + north * math.cos(yaw)
        right = east * math.cos(yaw) - north * math.sin(yaw)
        return math.atan2(right, GRAVITY), -math.atan2(forward, GRAVITY), yaw

    def load(self, items: tuple[Item, ...]) -> None:
        """`items` lack home; in flight the current index stays."""
        before = self.program.items
        if items == before:
            return
        self.program = self._program(items)
        if not items:
            self.mission = MissionState.NO_MISSION
            self.current = 0
            if self.mode is FlightMode.MISSION:
                self.hold()
            return
        if self.current >= len(items):
            self.current = self.autopilot.guidance.current_after_end % len(items)
        if self.mode is FlightMode.MISSION:
            self._controller.follow_new_mission(before)
        else:
            self.mission = MissionState.NOT_STARTED if self.on_ground else MissionState.PAUSED

    def know_rally(self, items: tuple[Item, ...]) -> None:
        places = [(self.frame.local(Geodetic(i.latitude_deg, i.longitude_deg, self.home.altitude)), i) for i in items]
        self.rally = tuple((float(place[0]), float(place[1]), item.height(self.home)) for place, item in places)

    def arm(self) -> None:
        if not self.armed:
            self.armed = True
            self.armed_s = self.time_s
            self.reached.clear()
            self._controller = self._new_controller()
            self._controller.enter()

    def start(self) -> None:
        """Begin or continue the mission; it moves once armed."""
        if not self.program.items:
            return
        if self.mission is MissionState.COMPLETE:
            self.current = 0
            self.program.jumped.clear()
        self.mission = MissionState.ACTIVE
        self.enter(FlightMode.MISSION)

    def hold(self) -> None:
        if self.mission is MissionState.ACTIVE:
            self.mission = MissionState.PAUSED
        self.enter(FlightMode.HOLD)

    def set_current(self, index: int) -> None:
        self.current = index
        if self.mode is FlightMode.MISSION:
            self._controller.enter()
        elif self.mission is MissionState.COMPLETE:
            self.mission = MissionState.PAUSED

    def rewind(self) -> None:
        """Call only while no mission is flown."""
        self.current = 0
        self.program.jumped.clear()
        if self.program.items:
            self.mission = MissionState.NOT_STARTED

    def climb(self, height: float) -> None:
        self.mode = FlightMode.HOLD
        self._controller.climb(height)

    def advance(self, to_s: float) -> None:
        while self.time_s + STEP_S <= to_s + 1e-9:
            self._controller.step()
            self.time_s += STEP_S

    def enter(self, mode: FlightMode) -> None:
        self.mode = mode
        self._controller.enter()
