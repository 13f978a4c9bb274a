"""The measured habits of ArduCopter 4.7 and PX4 1.17 in the mission service, one field a habit, as data.

What each version takes and stores is in `autopilots.firmware`, why it refuses an item in `autopilots.refusal`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from ipoa_mission.autopilots.firmware import NO_VERSION, firmware
from ipoa_mission.autopilots.firmware import Firmware as Tables
from ipoa_mission.autopilots.modes import px4_mode
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.autopilots.version import MEASURED, Version
from ipoa_mission.link.conversations import RequestStyle
from ipoa_mission.link.dialogue import Patience
from ipoa_mission.link.messages import CommandResult, Firmware, MissionType, Result
from ipoa_mission.simulator.flight import FlightMode

#: MAV_PROTOCOL_CAPABILITY: mission and parameters as floats, MISSION_INT, COMMAND_INT, MAVLink 2, fence, rally.
_SPOKEN = 1 | 2 | 4 | 8 | 8192 | 16384 | 32768
_BYTEWISE, _FTP = 16, 32


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


@dataclass(frozen=True)
class Personality:
    """One firmware's habits."""

    autopilot: Autopilot
    mav_autopilot: int
    manners: RequestStyle  # how it fetches
    patience: Patience  # when it asks again, and when it gives up
    timeout_result: int | None  # the Ack that ends a transfer which timed out
    timeout_text: str
    truncating: frozenset[int]  # the lists whose old items go as soon as a COUNT comes
    separate_lists: bool  # whether the three lists are transferred independently of each other
    reads_item_by_item: bool  # each MISSION_REQUEST, at any time, gets the item as it is then; else the list is kept
    count_from_stranger: Answer
    count_again: Answer  # after the first item has come
    read_during_upload: Answer
    clear_during_upload: Answer
    obeys_cancel: bool
    stray_item: Answer  # no transfer is under way
    wrong_list: Answer  # an item of another list than the one under way
    confirms_last_item_again: bool
    partial_lists: bool
    has_mission_file: bool  # `@MISSION/mission.dat`
    knows_command_224: bool
    judges_after_ack: bool
    reached_repeats: int  # how often MISSION_ITEM_REACHED is said again
    reached_slot_s: float  # an item that is done within this time of another hides it
    takes_orders_as_items: bool  # an item with current 2 ("go there now") or 3 ("change altitude")
    clears_all: bool  # MISSION_CLEAR_ALL of type 255, or of one that does not exist
    stored_text: Mapping[int, str]  # said when a list has been taken
    flags_kept: frozenset[int]  # the lists whose autocontinue is 1 when they are read back, else 0
    int_frames: bool  # frames are read back with their `_INT`
    tells_list_id: bool  # MISSION_ACK and MISSION_CURRENT name the list that is kept
    no_total: int  # MISSION_CURRENT.total where there is no mission
    missing_takeoff_text: str | None  # said when a mission without take-off is started on the ground
    start_up: StartUp
    modes: Mapping[FlightMode, int]  # HEARTBEAT.custom_mode
    first_mode: int  # after power-up
    placed_modes: frozenset[int]  # those that need a position
    armable_modes: frozenset[int]
    takeoff_mode: int | None  # into which the order to take off changes, and which it leaves up there
    mission_arms: bool  # MISSION_START arms by itself
    tells_prearm: bool  # SYS_STATUS has the pre-arm check among its sensors, and texts say what it lacks
    refused_arming: int  # COMMAND_ACK of an arming, or of a disarming in flight, that is refused
    arm_words: tuple[str, str, str, str]  # armed, disarmed by order, by landing, by standing too long
    disarm_delay: str  # the parameter that says how long it may stand armed on the ground [s]
    mode_acks: int  # COMMAND_ACKs to one DO_SET_MODE
    acks_first: bool  # the COMMAND_ACK comes before the message that was asked for
    heartbeat_on_change: bool  # a HEARTBEAT at once when the mode changes
    streams: Mapping[str, float]  # what is told unasked, and every how many seconds
    fixed_streams: frozenset[str]  # whose rate nobody can change
    no_such_stream: int  # COMMAND_ACK of an interval for a message that it does not send
    no_such_message: int  # and of a request for one
    no_such_interval: tuple[int, int]  # what MESSAGE_INTERVAL says of such a message, and the COMMAND_ACK with it
    base_mode: int  # HEARTBEAT.base_mode while disarmed
    capabilities: int  # AUTOPILOT_VERSION: what of MAV_PROTOCOL_CAPABILITY it has, and this stand-in does
    protocol: tuple[int, int, int] | None  # PROTOCOL_VERSION: in use, least, most; None: it does not know the message
    stream_groups: Mapping[int, frozenset[str]]  # what each MAV_DATA_STREAM of REQUEST_DATA_STREAM turns on and off
    version: Version = NO_VERSION  # what it says that it is

    @property
    def firmware(self) -> Tables:
        """What it takes in a list, and what it keeps of it."""
        return firmware(self.autopilot, self.version)

    @property
    def limits(self) -> Mapping[int, int]:
        """How many items each list holds."""
        facts = self.firmware
        return {
            MissionType.MISSION: facts.max_items,
            MissionType.FENCE: facts.max_fence_items,
            MissionType.RALLY: facts.max_rally_points,
        }

    @property
    def home_is_item_0(self) -> bool:
        """Whether the list begins with home, as the vehicle knows it."""
        return self.firmware.home_is_item_0


def _asks_every(seconds: float, give_up_s: float) -> Patience:
    retries = round(give_up_s / seconds) - 1
    return Patience(seconds, seconds, retries, retries, retries, adapt=False, echo_s=0.0)


ARDUCOPTER = Personality(
    autopilot=Autopilot.ARDUPILOT,
    mav_autopilot=Firmware.ARDUPILOT,
    manners=RequestStyle(legacy=True, rebukes=True),
    patience=_asks_every(1.0, 8.0),
    timeout_result=Result.OPERATION_CANCELLED,
    timeout_text="Mission upload timeout",
    truncating=frozenset({MissionType.MISSION, MissionType.RALLY}),
    separate_lists=True,
    reads_item_by_item=True,
    count_from_stranger=Answer.DENIED,
    count_again=Answer.OBEY,
    read_during_upload=Answer.DENIED,
    clear_during_upload=Answer.OBEY,
    obeys_cancel=False,
    stray_item=Answer.ERROR,
    wrong_list=Answer.ERROR,
    confirms_last_item_again=False,
    partial_lists=True,
    has_mission_file=True,
    knows_command_224=True,
    judges_after_ack=False,
    reached_repeats=0,
    reached_slot_s=0.02,
    takes_orders_as_items=True,
    clears_all=False,
    stored_text={MissionType.MISSION: "Flight plan received"},
    flags_kept=frozenset({MissionType.MISSION}),
    int_frames=False,
    tells_list_id=False,
    no_total=0,
    missing_takeoff_text="Auto: Missing Takeoff Cmd",
    start_up=StartUp(
        3.0, 20.0, 23.5, 41.4, "Gyros inconsistent", "Need Position Estimate", no_mission="Mode requires mission"
    ),
    modes={FlightMode.HOLD: 5, FlightMode.MISSION: 3, FlightMode.RETURN: 6, FlightMode.LAND: 9},
    first_mode=0,
    placed_modes=frozenset({3, 4, 5, 6, 7, 16, 17, 21, 27}),
    armable_modes=frozenset({0, 1, 2, 4, 5, 16}),
    takeoff_mode=None,
    mission_arms=False,
    tells_prearm=True,
    refused_arming=CommandResult.FAILED,
    arm_words=("Arming motors", "Disarming motors", "Disarming motors", "Disarming motors"),
    disarm_delay="DISARM_DELAY",
    mode_acks=1,
    acks_first=True,
    heartbeat_on_change=True,
    streams={"HEARTBEAT": 1.0, "TIMESYNC": 10.0},
    fixed_streams=frozenset(),
    no_such_stream=CommandResult.DENIED,
    no_such_message=CommandResult.FAILED,
    no_such_interval=(0, CommandResult.FAILED),
    base_mode=81,
    capabilities=_SPOKEN | _FTP,
    protocol=None,
    stream_groups={
        2: frozenset({"SYS_STATUS", "MISSION_CURRENT", "GPS_RAW_INT"}),
        6: frozenset({"GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"}),
        10: frozenset({"ATTITUDE"}),
        11: frozenset({"VFR_HUD"}),
        12: frozenset({"SYSTEM_TIME", "BATTERY_STATUS"}),
    },
)

PX4 = Personality(
    autopilot=Autopilot.PX4,
    mav_autopilot=Firmware.PX4,
    manners=RequestStyle(),
    patience=_asks_every(0.25, 5.0),
    timeout_result=None,
    timeout_text="Operation timeout",
    truncating=frozenset(),
    separate_lists=False,
    reads_item_by_item=False,
    count_from_stranger=Answer.ERROR,
    count_again=Answer.ERROR,
    read_during_upload=Answer.TEXT,
    clear_during_upload=Answer.TEXT,
    obeys_cancel=True,
    stray_item=Answer.SILENCE,
    wrong_list=Answer.ERROR,
    confirms_last_item_again=True,
    partial_lists=False,
    has_mission_file=False,
    knows_command_224=False,
    judges_after_ack=True,
    reached_repeats=10,
    reached_slot_s=0.1,
    takes_orders_as_items=False,
    clears_all=True,
    stored_text={},
    flags_kept=frozenset({MissionType.MISSION, MissionType.RALLY}),
    int_frames=True,
    tells_list_id=True,
    no_total=65535,
    missing_takeoff_text=None,
    start_up=StartUp(0.5, 1.0, 1.5, 1.5, *(3 * ("Resolve system health failures first",))),
    modes={
        FlightMode.HOLD: px4_mode(4, 3),
        FlightMode.MISSION: px4_mode(4, 4),
        FlightMode.RETURN: px4_mode(4, 5),
        FlightMode.LAND: px4_mode(4, 6),
    },
    first_mode=px4_mode(4, 3),
    placed_modes=frozenset(px4_mode(4, sub) for sub in range(2, 7)),
    armable_modes=frozenset({px4_mode(4, 2), px4_mode(4, 3), px4_mode(4, 4)}),
    takeoff_mode=px4_mode(4, 2),
    mission_arms=True,
    tells_prearm=False,
    refused_arming=CommandResult.TEMPORARILY_REJECTED,
    arm_words=(
        "Armed by external command\t",
        "Disarmed by external command\t",
        "Disarmed by landing\t",
        "Disarmed by auto preflight disarming\t",
    ),
    disarm_delay="COM_DISARM_PRFLT",
    mode_acks=2,
    acks_first=False,
    heartbeat_on_change=False,
    streams={
        "HEARTBEAT": 1.0,
        "SYS_STATUS": 1.0,
        "SYSTEM_TIME": 1.0,
        "GPS_RAW_INT": 0.2,
        "GLOBAL_POSITION_INT": 0.2,
        "LOCAL_POSITION_NED": 1.0,
        "ATTITUDE": 1.0 / 15,
        "BATTERY_STATUS": 2.0,
        "VFR_HUD": 0.25,
        "EXTENDED_SYS_STATE": 1.0,
        "MISSION_CURRENT": 1.0,
        "HOME_POSITION": 2.0,
    },
    fixed_streams=frozenset({"HEARTBEAT", "MISSION_CURRENT"}),
    no_such_stream=CommandResult.FAILED,
    no_such_message=CommandResult.DENIED,
    no_such_interval=(-1, CommandResult.ACCEPTED),
    base_mode=29,
    capabilities=_SPOKEN | _BYTEWISE,
    protocol=(200, 100, 203),
    stream_groups={},
)

PERSONALITIES: Mapping[Autopilot, Personality] = {Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4}


def personality(autopilot: Autopilot, version: Version | None = None) -> Personality:
    """The habits of a version: what it takes by its own tables, all else as measured; None: the version measured."""
    return replace(PERSONALITIES[autopilot], version=version or MEASURED[autopilot])
