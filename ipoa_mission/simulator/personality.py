"""The measured habits of ArduCopter 4.7 and PX4 1.17 in the mission service, one field a habit, as data.

What each firmware stores and drops is in `mission.firmware_facts`; how it judges an item in `judgement`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from ipoa_mission.link.conversations import Manners
from ipoa_mission.link.dialogue import Patience
from ipoa_mission.link.messages import Firmware, MissionType, Result
from ipoa_mission.mission.firmware_facts import FIRMWARE
from ipoa_mission.simulator.flight import FlightMode
from ipoa_mission.vehicle import Autopilot


class Answer(Enum):
    """What a firmware makes of something that comes in the middle of an upload."""

    SILENCE = "silence"
    TEXT = "words only"
    DENIED = "DENIED"
    ERROR = "ERROR"
    OBEY = "does it, and the upload ends"


@dataclass(frozen=True)
class Personality:
    """One firmware's habits."""

    autopilot: Autopilot
    mav_autopilot: int
    manners: Manners  # how it fetches
    patience: Patience  # when it asks again, and when it gives up
    timeout_result: int | None  # the Ack that ends a transfer which timed out
    timeout_text: str
    truncating: frozenset[int]  # the lists whose old items go as soon as a COUNT comes
    separate_lists: bool  # whether the three lists are transferred independently of each other
    answers_requests_at_any_time: bool  # a MISSION_REQUEST without a REQUEST_LIST before it
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
    rewinds_after_landing: bool  # a mission that ends in LAND stands at its first item again
    takes_orders_as_items: bool  # an item with current 2 ("go there now") or 3 ("change altitude")
    missing_takeoff_text: str | None  # said when a mission without take-off is started on the ground
    boot_s: float  # until then a COUNT gets NO_SPACE, and arming is refused
    modes: Mapping[FlightMode, int]  # HEARTBEAT.custom_mode
    version: int  # AUTOPILOT_VERSION.flight_sw_version: major, minor, patch, type

    @property
    def limits(self) -> Mapping[int, int]:
        """How many items each list holds."""
        facts = FIRMWARE[self.autopilot]
        return {
            MissionType.MISSION: facts.max_items,
            MissionType.FENCE: facts.max_fence_items,
            MissionType.RALLY: facts.max_rally_points,
        }

    @property
    def home_is_item_0(self) -> bool:
        """Whether the list begins with home, as the vehicle knows it."""
        return FIRMWARE[self.autopilot].home_is_item_0


def _asks_every(seconds: float, give_up_s: float) -> Patience:
    retries = round(give_up_s / seconds) - 1
    return Patience(seconds, seconds, retries, retries, retries, adapt=False, echo_s=0.0)


def _px4_mode(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


ARDUCOPTER = Personality(
    autopilot=Autopilot.ARDUPILOT,
    mav_autopilot=Firmware.ARDUPILOT,
    manners=Manners(legacy=True, rebukes=True),
    patience=_asks_every(1.0, 8.0),
    timeout_result=Result.OPERATION_CANCELLED,
    timeout_text="Mission upload timeout",
    truncating=frozenset({MissionType.MISSION, MissionType.RALLY}),
    separate_lists=True,
    answers_requests_at_any_time=True,
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
    rewinds_after_landing=True,
    takes_orders_as_items=True,
    missing_takeoff_text="Auto: Missing Takeoff Cmd",
    boot_s=45.0,
    modes=MappingProxyType({FlightMode.HOLD: 5, FlightMode.MISSION: 3, FlightMode.RETURN: 6, FlightMode.LAND: 9}),
    version=0x04070000,
)

PX4 = Personality(
    autopilot=Autopilot.PX4,
    mav_autopilot=Firmware.PX4,
    manners=Manners(),
    patience=_asks_every(0.25, 5.0),
    timeout_result=None,
    timeout_text="Operation timeout",
    truncating=frozenset(),
    separate_lists=False,
    answers_requests_at_any_time=False,
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
    rewinds_after_landing=False,
    takes_orders_as_items=False,
    missing_takeoff_text=None,
    boot_s=0.0,
    modes=MappingProxyType(
        {
            FlightMode.HOLD: _px4_mode(4, 3),
            FlightMode.MISSION: _px4_mode(4, 4),
            FlightMode.RETURN: _px4_mode(4, 5),
            FlightMode.LAND: _px4_mode(4, 6),
        }
    ),
    version=0x011100FF,
)

PERSONALITIES: Mapping[Autopilot, Personality] = MappingProxyType({Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4})
