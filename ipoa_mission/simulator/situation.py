from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

from ipoa_mission.autopilot.commands import FLOWN_TO, Command
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import HOME, ReturnOrder
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Place
from ipoa_mission.ground import FLAT_GROUND, Ground
from ipoa_mission.link.messages import MissionState
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import MAX_ACTIONS, Program
from ipoa_mission.wind import CALM, Wind

STEP_S = 0.02  # [s]


@dataclass(frozen=True)
class Conditions:
    wind: Wind = CALM
    ground: Ground = FLAT_GROUND  # above home [m]
    vehicle: LearnedVehicle | None = None  # with properties learned from logs
    version: Version | None = None  # None: the newest measured
    seed: int = 0  # of sensor errors
    cold: bool = False  # powered up now, without a position


STANDARD_CONDITIONS = Conditions()


class FlightMode(IntEnum):
    HOLD = 0
    MISSION = 1
    RETURN = 2
    LAND = 3


@dataclass(frozen=True)
class ItemDone:
    index: int
    time_s: float
    announced: bool = True  # by MISSION_ITEM_REACHED


@dataclass
class Situation:
    """State of a flight. Its controller and its commands write to it."""

    program: Program
    conditions: Conditions = STANDARD_CONDITIONS
    place: Place = (0.0, 0.0, 0.0)  # east, north, up of home [m]
    motion: Place = (0.0, 0.0, 0.0)  # [m/s]
    tilt_accel: tuple[float, float] = (0.0, 0.0)  # horizontal acceleration by tilt: g tan(angle) [m/s^2]
    yaw: float = 0.0  # [rad]
    on_ground: bool = True
    time_s: float = 0.0
    armed: bool = False
    armed_s: float = 0.0
    landed: bool = True
    mode: FlightMode = FlightMode.HOLD
    mission: MissionState = MissionState.NO_MISSION
    current: int = 0
    reached: list[ItemDone] = field(default_factory=list)
    rally: tuple[Place, ...] = ()

    def goal_of_return(self, here: Place, parameters: Parameters) -> Place:
        program = self.program
        n = program.autopilot.return_route(parameters, ReturnOrder(here, self.rally, version=program.version)).rally
        return HOME if n is None else self.rally[n]

    def done(self, index: int, announced: bool = True) -> None:
        self.reached.append(ItemDone(index, self.time_s, announced))

    def come_to(self, behind: int, change_speed: Callable[[Item], None]) -> Item | None:
        """Do the items after `behind` up to the next flown one; return that, or None at the end."""
        next_index: int | None = behind
        moved = FLOWN_TO | {Command.NAV_RETURN_TO_LAUNCH, Command.NAV_DELAY}
        if self.program.autopilot.guidance.flies_vtol_items:
            moved |= {Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND}
        for _ in range(MAX_ACTIONS):
            if next_index is None:
                break
            passed, next_index = self.program.advance(next_index)
            for index in passed:
                self.current = index
                if self.program.items[index].command == Command.DO_CHANGE_SPEED:
                    change_speed(self.program.items[index])
                self.done(index)
            if next_index is not None:
                self.current = next_index
                item = self.program.items[next_index]
                if item.command in moved:
                    return item
                self.done(next_index)
        self.mission = MissionState.COMPLETE
        return None

    def disarm(self) -> None:
        self.armed = False
        self.landed = True

    def end_on_ground(self, announced: bool = True) -> None:
        if self.mode is FlightMode.MISSION:
            self.done(self.current, announced)
            self.mission = MissionState.COMPLETE
        self.disarm()
        self.mode = FlightMode.HOLD
