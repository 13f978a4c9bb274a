"""Describe the measured behavior of ArduCopter 4.7 and PX4 1.17 in the mission service, as data.

`vehicles.firmware_tables` defines what each version takes and stores, `vehicles.refusal` why it refuses an item.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from ipoa_mission.link.conversations import RequestStyle
from ipoa_mission.link.dialogue import Patience
from ipoa_mission.link.messages import MissionType
from ipoa_mission.simulator.simulated_flight import FlightMode
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.firmware_tables import NO_VERSION
from ipoa_mission.vehicles.firmware_tables import Firmware as Tables
from ipoa_mission.vehicles.version import Version

#: MAV_PROTOCOL_CAPABILITY: mission and parameters as floats, MISSION_INT, COMMAND_INT, MAVLink 2, fence, rally.
CAPABILITIES = 1 | 2 | 4 | 8 | 8192 | 16384 | 32768
BYTEWISE, FTP = 16, 32


class Answer(Enum):
    """Name a firmware's reaction to a message in the middle of an upload."""

    SILENCE = "silence"
    TEXT = "words only"
    DENIED = "DENIED"
    ERROR = "ERROR"
    OBEY = "does it, and the upload ends"


@dataclass(frozen=True)
class StartUp:
    """Hold seconds from power-up until it takes lists, has an origin, has steady sensors, and has a position."""

    listens_s: float
    origin_s: float
    steady_s: float
    position_s: float
    unsteady: str  # reason against arming until then
    unplaced: str
    no_mission: str  # reason against arming in the mission mode without a mission


@dataclass(frozen=True, kw_only=True)
class MockProfile:
    """Describe one firmware's behavior; a default means that it lacks the feature."""

    autopilot: Autopilot
    protocol_profile: RequestStyle  # request form
    patience: Patience  # times of repeats and giving up
    timeout_result: int | None = None  # MISSION_ACK after a timeout
    timeout_text: str
    truncating: frozenset[int] = frozenset()  # lists whose old items are dropped at COUNT
    separate_lists: bool = False  # the three lists are transferred independently
    reads_item_by_item: bool = False  # each MISSION_REQUEST returns the item as it is then; else the list is frozen
    count_from_stranger: Answer
    count_again: Answer  # after the first item was received
    read_during_upload: Answer
    clear_during_upload: Answer
    obeys_cancel: bool = False
    stray_item: Answer  # no transfer in progress
    wrong_list: Answer  # item of another list
    confirms_last_item_again: bool = False
    partial_lists: bool = False
    knows_command_224: bool = False
    reached_repeats: int = 0  # repeats of MISSION_ITEM_REACHED
    reached_slot_s: float  # an item done within this time of another is not reported
    takes_orders_as_items: bool = False  # items with current 2 ("go there now") or 3 ("change altitude")
    clears_all: bool = False  # MISSION_CLEAR_ALL of type 255 or of an unknown type
    stored_text: Mapping[int, str] = field(default_factory=dict)  # text after a list is stored
    flags_kept: frozenset[int]  # lists whose autocontinue reads back as 1, else 0
    int_frames: bool = False  # frames read back with `_INT`
    reports_list_id: bool = False  # MISSION_ACK and MISSION_CURRENT carry the list's id
    no_total: int  # MISSION_CURRENT.total without a mission
    missing_takeoff_text: str | None = None  # text at the start of a mission without take-off on the ground
    no_item_text: str | None = None  # text after MISSION_SET_CURRENT of a missing item
    runs_on_ground: bool = False  # in mission mode the mission advances on the ground, too
    flight_texts: bool = False  # texts report start, climb height and landing
    restores_mode: bool = False  # after return or landing the earlier mode comes back
    no_such_mode_text: str | None = None
    refuses_modes: bool = False  # an armed vehicle refuses a mode that it cannot fly, with the reason
    repositions: bool = False  # takes DO_REPOSITION
    reboots: bool = False
    switches_fence: bool = False  # takes DO_FENCE_ENABLE as a command
    start_up: StartUp
    modes: Mapping[FlightMode, int]  # HEARTBEAT.custom_mode
    first_mode: int  # after power-up
    placed_modes: frozenset[int]  # modes that need a position
    armable_modes: frozenset[int]
    takeoff_mode: int | None = None  # mode of the take-off command, left at the top
    mission_arms: bool = False  # MISSION_START arms
    reports_prearm: bool = False  # SYS_STATUS reports the pre-arm check, texts report its failures
    prearm_every_s: float = 0.0  # interval of the checks: their reported result may be this old [s]
    refused_arming: int  # COMMAND_ACK of a refused arming, or disarming in flight
    arm_texts: tuple[str, str, str, str]  # armed, disarmed by command, by landing, by timeout
    disarm_delay: str  # parameter of the time until it disarms on the ground [s]
    mode_acks: int = 1  # COMMAND_ACKs of one DO_SET_MODE
    acks_first: bool = False  # COMMAND_ACK precedes the requested message
    heartbeat_on_change: bool = False  # sends HEARTBEAT when the mode changes
    streams: Mapping[str, float]  # default streams and their intervals [s]
    fixed_streams: frozenset[str] = frozenset()  # streams with a fixed rate
    no_such_stream: int  # COMMAND_ACK of an interval for an unknown message
    no_such_message: int  # COMMAND_ACK of a request for an unknown message
    no_such_interval: tuple[int, int]  # MESSAGE_INTERVAL of an unknown message, and its COMMAND_ACK
    base_mode: int  # HEARTBEAT.base_mode while disarmed
    capabilities: int  # AUTOPILOT_VERSION: bits of MAV_PROTOCOL_CAPABILITY that are simulated
    protocol: tuple[int, int, int] | None = None  # PROTOCOL_VERSION, if known: in use, least, greatest
    stream_groups: Mapping[int, frozenset[str]] = field(default_factory=dict)
    """Messages of each MAV_DATA_STREAM of REQUEST_DATA_STREAM."""
    version: Version = NO_VERSION  # as reported

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


def asks_every(seconds: float, give_up_s: float) -> Patience:
    """Return a patience that repeats every `seconds` and gives up after `give_up_s` [s]."""
    retries = round(give_up_s / seconds) - 1
    return Patience(seconds, seconds, retries, retries, retries, adapt=False, echo_s=0.0)


def mock_profile(autopilot: Autopilot, version: Version | None = None) -> MockProfile:
    """Return the profile of a version: its own tables, all else as measured; None: the newest measured."""
    return replace(autopilot.part(MockProfile), version=version or autopilot.newest)
