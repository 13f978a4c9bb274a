"""Measured behavior of ArduCopter 4.7 and PX4 1.17 in the mission service."""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Protocol

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.firmware_tables import NO_VERSION
from ipoa_mission.autopilot.firmware_tables import Firmware as Tables
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.link.dialogue import RetryPolicy
from ipoa_mission.link.messages import CommandResult, MissionType
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.situation import FlightMode, Situation

#: MAV_PROTOCOL_CAPABILITY: mission and parameters as floats, MISSION_INT, COMMAND_INT, MAVLink 2, fence, rally.
CAPABILITIES = 1 | 2 | 4 | 8 | 8192 | 16384 | 32768
BYTEWISE, FTP = 16, 32


class Answer(Enum):
    """To a message in the middle of an upload."""

    SILENCE = "silence"
    TEXT = "words only"
    DENIED = "DENIED"
    ERROR = "ERROR"
    OBEY = "does it, and the upload ends"


@dataclass(frozen=True)
class StartUp:
    """From power-up until it takes lists, has an origin, steady sensors, a position [s]."""

    listens_s: float
    origin_s: float
    steady_s: float
    position_s: float
    unsteady: str  # reason against arming
    unplaced: str
    no_mission: str  # reason against arming in mission mode


class FlightController(Protocol):
    def enter(self) -> None:
        """Follow a new mode or current item."""

    def follow_new_mission(self, before: tuple[Item, ...]) -> None:
        """Continue after the mission was replaced in flight."""

    def climb(self, height: float) -> None:
        """Take off to a height above home [m], and hold."""

    def step(self) -> None:
        """Fly for `STEP_S`."""


@dataclass(frozen=True, kw_only=True)
class MockProfile:
    """A simulated firmware; a default means that it lacks the feature."""

    autopilot: Autopilot
    controller: Callable[[Situation, Parameters, random.Random], FlightController]
    requests_legacy: bool = False  # by MISSION_REQUEST; it refuses other items
    retry_policy: RetryPolicy
    timeout_result: int | None = None
    timeout_text: str
    truncating: frozenset[int] = frozenset()  # lists cleared at COUNT
    separate_lists: bool = False  # in transfers
    reads_item_by_item: bool = False  # else the list is frozen
    count_from_stranger: Answer
    count_again: Answer  # after the first item
    read_during_upload: Answer
    clear_during_upload: Answer
    obeys_cancel: bool = False
    stray_item: Answer
    confirms_last_item_again: bool = False
    reached_repeats: int = 0  # of MISSION_ITEM_REACHED
    reached_slot_s: float  # an item done within it is not reported
    clears_all: bool = False  # type 255, or unknown
    stored_text: Mapping[int, str] = field(default_factory=dict)  # after a list is stored
    flags_kept: frozenset[int]  # lists whose autocontinue reads back as 1
    int_frames: bool = False  # read back with `_INT`
    reports_list_id: bool = False  # in MISSION_ACK and MISSION_CURRENT
    no_total: int  # MISSION_CURRENT.total
    no_item_text: str | None = None
    runs_on_ground: bool = False  # without texts of a flight
    restores_mode: bool = False  # after return or landing
    refuses_modes: bool = False  # when armed, with the reason
    unsupported: frozenset[int]  # of another firmware's commands
    start_up: StartUp
    modes: Mapping[FlightMode, int]  # HEARTBEAT.custom_mode
    first_mode: int  # after power-up
    placed_modes: frozenset[int]
    armable_modes: frozenset[int]
    mission_arms: bool = False  # by MISSION_START
    reports_prearm: bool = False
    prearm_every_s: float = 0.0  # the reported result may be this old [s]
    refused_arming: CommandResult  # also of disarming in flight
    arm_texts: tuple[str, str, str, str]  # armed, disarmed by command, by landing, by timeout
    disarm_delay: str  # parameter [s]
    mode_acks: int = 1  # of one DO_SET_MODE
    acks_first: bool = False  # before the requested message
    heartbeat_on_change: bool = False  # of mode
    streams: Mapping[str, float]  # default intervals [s]
    fixed_streams: frozenset[str] = frozenset()  # with a fixed rate
    no_such_stream: CommandResult  # COMMAND_ACK
    no_such_message: CommandResult  # COMMAND_ACK
    base_mode: int  # disarmed
    capabilities: int  # simulated bits of MAV_PROTOCOL_CAPABILITY
    protocol: tuple[int, int, int] | None = None  # PROTOCOL_VERSION: in use, least, greatest
    stream_groups: Mapping[int, frozenset[str]] = field(default_factory=dict)
    """Messages of each MAV_DATA_STREAM of REQUEST_DATA_STREAM."""
    version: Version = NO_VERSION

    @property
    def firmware(self) -> Tables:
        return self.autopilot.firmware(self.version)

    @property
    def limits(self) -> Mapping[int, int]:
        facts = self.firmware
        return {
            MissionType.MISSION: facts.max_items,
            MissionType.FENCE: facts.max_fence_items,
            MissionType.RALLY: facts.max_rally_points,
        }


def asks_every(seconds: float, give_up_s: float) -> RetryPolicy:
    """Repeat every `seconds` and give up after `give_up_s` [s]."""
    retries = round(give_up_s / seconds) - 1
    return RetryPolicy(seconds, seconds, retries, retries, retries, adapt=False, echo_s=0.0)


def mock_profile(autopilot: Autopilot, version: Version | None = None) -> MockProfile:
    """Return a version's tables, all else as measured; None: the newest."""
    return replace(autopilot.part(MockProfile), version=version or autopilot.newest)
