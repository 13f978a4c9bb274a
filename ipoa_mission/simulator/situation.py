"""What both autopilots know of a flight under way: mode, mission, how far it is; and the notes of what was done."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

from ipoa_mission.forecast.itinerary.program import MOST_ACTIONS, Place, Program
from ipoa_mission.mission.commands import FLOWN_TO, Command
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.returning import HOME

STEP_S = 0.02  # in which a flight is integrated
#: Commands at which a vehicle spends time; all others are done in passing.
NAVIGATED = FLOWN_TO | {Command.NAV_RETURN_TO_LAUNCH, Command.NAV_DELAY}
VTOL = frozenset({Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND})


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
class ItemDone:
    """Item `index` was done at `time_s`; `announced`: whether this autopilot tells so (MISSION_ITEM_REACHED)."""

    index: int
    time_s: float
    announced: bool = True


@dataclass
class Situation:
    """Changes as the flight goes on; the pilot and `Flight` both write to it."""

    program: Program
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
        """Where a return from `here` leads: home, or a rally point and its height."""
        program = self.program
        n = program.autopilot.return_route(parameters, here, self.rally, version=program.version).rally
        return HOME if n is None else self.rally[n]

    def done(self, index: int, announced: bool = True) -> None:
        """Note that an item is done."""
        self.reached.append(ItemDone(index, self.time_s, announced))

    def come_to(self, behind: int, change_speed: Callable[[Item], None]) -> Item | None:
        """The item that is flown after item `behind`, now the current one, those before it done in passing.

        None: there is none.
        """
        at: int | None = behind
        moved = NAVIGATED | (VTOL if self.program.autopilot.guidance.flies_vtol_items else frozenset())
        for _ in range(MOST_ACTIONS):
            if at is None:
                break
            passed, at = self.program.advance(at)
            for index in passed:
                self.current = index
                if self.program.items[index].command == Command.DO_CHANGE_SPEED:
                    change_speed(self.program.items[index])
                self.done(index)
            if at is not None:
                self.current, item = at, self.program.items[at]
                if item.command in moved:
                    return item
                self.done(at)
        self.mission = MissionState.COMPLETE
        return None

    def disarm(self) -> None:
        """The motors stop."""
        self.armed = False
        self.landed = True
