"""The measured habits of ArduCopter 4.7 and PX4 1.17 in the mission service, one field a habit, as data.

What each version takes and stores is in `autopilots.firmware`, why it refuses an item in `autopilots.refusal`.
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
SPOKEN = 1 | 2 | 4 | 8 | 8192 | 16384 | 32768
BYTEWISE, FTP = 16, 32


class Answer(Enum):
    """What a firmware makes of something that comes in the middle of an upload."""

    SILENCE = "silence"
    TEXT = "words only"
    DENIED = "DENIED"
    ERROR = "ERROR"
    OBEY = "does it, and the upload ends"


@dataclass(frozen=True)
class StartUp:
    """Seconds from power-up until it takes lists, has an origin, has sensors that agree, and has a position."""

    listens_s: float
    origin_s: float
    steady_s: float
    position_s: float
    unsteady: str  # what hinders arming until then
    unplaced: str
    no_mission: str  # what hinders it in the mission mode without a mission


@dataclass(frozen=True, kw_only=True)
class MockProfile:
    """One firmware's habits; what is left out it does not have, or does not do."""

    autopilot: Autopilot
    protocol_profile: RequestStyle  # how it fetches
    patience: Patience  # when it asks again, and when it gives up
    timeout_result: int | None = None  # the Ack that ends a transfer which timed out
    timeout_text: str
    truncating: frozenset[int] = frozenset()  # the lists whose old items go as soon as a COUNT comes
    separate_lists: bool = False  # whether the three lists are transferred independently of each other
    reads_item_by_item: bool = False  # each MISSION_REQUEST gets the item as it is then; else the list is kept
    count_from_stranger: Answer
    count_again: Answer  # after the first item has come
    read_during_upload: Answer
    clear_during_upload: Answer
    obeys_cancel: bool = False
    stray_item: Answer  # no transfer is under way
    wrong_list: Answer  # an item of another list than the one under way
    confirms_last_item_again: bool = False
    partial_lists: bool = False
    knows_command_224: bool = False
    reached_repeats: int = 0  # how often MISSION_ITEM_REACHED is said again
    reached_slot_s: float  # an item that is done within this time of another hides it
    takes_orders_as_items: bool = False  # an item with current 2 ("go there now") or 3 ("change altitude")
    clears_all: bool = False  # MISSION_CLEAR_ALL of type 255, or of one that does not exist
    stored_text: Mapping[int, str] = field(default_factory=dict)  # said when a list has been taken
    flags_kept: frozenset[int]  # the lists whose autocontinue is 1 when they are read back, else 0
    int_frames: bool = False  # frames are read back with their `_INT`
    tells_list_id: bool = False  # MISSION_ACK and MISSION_CURRENT name the list that is kept
    no_total: int  # MISSION_CURRENT.total where there is no mission
    missing_takeoff_text: str | None = None  # said when a mission without take-off is started on the ground
    no_item_text: str | None = None  # said to a MISSION_SET_CURRENT of an item that is not there
    runs_on_ground: bool = False  # in its mission mode the mission goes on, whether it flies or not
    words_of_flight: bool = False  # texts say that a mission is begun, how high it climbs, and that it has landed
    restores_mode: bool = False  # after a return or a landing it has the mode of before
    no_such_mode_text: str | None = None
    doubts_modes: bool = False  # an armed vehicle fails to change into a mode that it cannot fly, with its reason
    repositions: bool = False  # DO_REPOSITION
    reboots: bool = False
    switches_fence: bool = False  # DO_FENCE_ENABLE as a command
    start_up: StartUp
    modes: Mapping[FlightMode, int]  # HEARTBEAT.custom_mode
    first_mode: int  # after power-up
    placed_modes: frozenset[int]  # those that need a position
    armable_modes: frozenset[int]
    takeoff_mode: int | None = None  # into which the order to take off changes, and which it leaves up there
    mission_arms: bool = False  # MISSION_START arms by itself
    tells_prearm: bool = False  # SYS_STATUS has the pre-arm check among its sensors, and texts say what it lacks
    prearm_every_s: float = 0.0  # how often these checks are made: what is told of them is as old [s]
    refused_arming: int  # COMMAND_ACK of an arming, or of a disarming in flight, that is refused
    arm_words: tuple[str, str, str, str]  # armed, disarmed by order, by landing, by standing too long
    disarm_delay: str  # the parameter that says how long it may stand armed on the ground [s]
    mode_acks: int = 1  # COMMAND_ACKs to one DO_SET_MODE
    acks_first: bool = False  # the COMMAND_ACK comes before the message that was asked for
    heartbeat_on_change: bool = False  # a HEARTBEAT at once when the mode changes
    streams: Mapping[str, float]  # what is told unasked, and every how many seconds
    fixed_streams: frozenset[str] = frozenset()  # whose rate nobody can change
    no_such_stream: int  # COMMAND_ACK of an interval for a message that it does not send
    no_such_message: int  # and of a request for one
    no_such_interval: tuple[int, int]  # what MESSAGE_INTERVAL says of such a message, and the COMMAND_ACK with it
    base_mode: int  # HEARTBEAT.base_mode while disarmed
    capabilities: int  # AUTOPILOT_VERSION: what of MAV_PROTOCOL_CAPABILITY it has, and this stand-in does
    protocol: tuple[int, int, int] | None = None  # PROTOCOL_VERSION, where it knows that: in use, least, most
    stream_groups: Mapping[int, frozenset[str]] = field(default_factory=dict)
    """What each MAV_DATA_STREAM of REQUEST_DATA_STREAM turns on and off."""
    version: Version = NO_VERSION  # what it says that it is

    @property
    def firmware(self) -> Tables:
        """What it takes in a list, and what it keeps of it."""
        return self.autopilot.firmware(self.version)

    @property
    def limits(self) -> Mapping[int, int]:
        """How many items each list holds."""
        facts = self.firmware
        return {
            MissionType.MISSION: facts.max_items,
            MissionType.FENCE: facts.max_fence_items,
            MissionType.RALLY: facts.max_rally_points,
        }


def asks_every(seconds: float, give_up_s: float) -> Patience:
    """The patience of one that asks again every so often, and gives up after so long [s]."""
    retries = round(give_up_s / seconds) - 1
    return Patience(seconds, seconds, retries, retries, retries, adapt=False, echo_s=0.0)


def mock_profile(autopilot: Autopilot, version: Version | None = None) -> MockProfile:
    """The habits of a version: what it takes by its own tables, all else as measured; None: the newest measured."""
    return replace(autopilot.part(MockProfile), version=version or autopilot.newest)
