"""What both autopilots know of a flight under way: mode, mission, how far it is; and the notes of what was done."""

from dataclasses import dataclass, field
from enum import IntEnum

from ipoa_mission.simulator.program import Program

STEP_S = 0.02  # in which a flight is integrated


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
    reached: list[Reached] = field(default_factory=list)

    def done(self, index: int, announced: bool = True) -> None:
        """Note that an item is done."""
        self.reached.append(Reached(index, self.time_s, announced))

    def disarm(self) -> None:
        """The motors stop."""
        self.armed = False
        self.landed = True
