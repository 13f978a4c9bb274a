"""Mission mode, protocol and modes of an autopilot, which other rooms ask instead of its name."""

import re
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import NamedTuple

from ipoa_mission.autopilot.commands import JUMPS, Command


class ArmingWords(NamedTuple):
    begin: re.Pattern[str]  # prefix of each reason
    passing: re.Pattern[str]  # reasons that clear by themselves

    def reasons(self, words: str) -> tuple[str, ...]:
        return tuple(reason for reason in words.split("; ") if self.begin.match(reason))

    def lasting(self, words: str) -> tuple[str, ...]:
        reasons = self.reasons(words)
        return tuple(reason for reason in reasons if not self.passing.search(self.begin.sub("", reason, count=1)))


class WaypointDefaults(NamedTuple):
    """Hold [s], below which a waypoint may be passed, and radius [m]; 0: its parameter."""

    hold: float = 0.0
    radius: float = 0.0


class GuidanceProfile(NamedTuple):
    passes_before: Set[int]  # commands before which it passes a waypoint without a stop
    flies_vtol_items: bool = False  # it flies them as take-off and landing of a multicopter
    zero_is_here: bool = False  # latitude and longitude 0 mean the previous place, altitude 0 its height
    stops_to_hold: bool = False  # it stops for a hold of 1 s or more, and ignores shorter ones
    stops_at_terrain: bool = False  # it stops between an altitude over terrain and another frame
    flies_splines: bool = False  # it flies NAV_SPLINE_WAYPOINT as a curve
    climbs_where_it_stands: bool = False  # a take-off is vertical
    needs_takeoff: bool = False  # it refuses a mission on the ground without a take-off
    bars_takeoff: Set[int] = frozenset()  # actions that it refuses before a take-off, like a move
    takeoff_done_within: str = ""  # below its height by this parameter [m]
    own_takeoff: float = 0.0  # it takes off to this height at least [m]
    waits_armed: str = ""  # it disarms on the ground after this parameter's time [s]; empty: never
    waits_until_clock: bool = False  # NAV_DELAY without seconds waits until a time of day
    terrain_by: str = ""  # arming with items over terrain needs terrain data or this parameter's range finder
    turns_at_acceptance_radius: bool = False
    small_acceptance_radius: float = 0.0  # for late turns at low speed [m]
    first_item: int = 1  # jumps in the stored list give the first item this number
    current_after_end: int = 0  # index of the current item after a shorter list; -1: the last
    lands_below_item: bool = False  # LAND's slow stretch counts from an item below home
    climbs_coming_back: bool = False  # RTL decides at the point of the order, and climbs towards it
    holds_at_order: bool = False  # hold comes back to the order's height
    home_is_where_armed: bool = False  # it ignores the file's home
    brakes_after: float = 0.0  # it begins to brake at most this long after an abort [s]; docs/safety.md has flights

    def may_precede_takeoff(self, command: int) -> bool:
        is_action = command >= Command.CONDITION_DELAY or command in (Command.NAV_DELAY, Command.NAV_ROI)
        return is_action and command not in self.bars_takeoff


@dataclass(frozen=True)
class JumpProfile:
    """DO_JUMP and DO_JUMP_TAG, read in the source."""

    most: int = 65_535  # it counts passes of these jumps, and ignores others unless they are endless
    most_small: int = 65_535  # a board with little memory has fewer
    at_once: int = 1_000  # one more consecutive jump ends the mission
    most_repeats: int = 65_535
    repeats_without_end: bool = False  # a count of -1 repeats without end
    resets: bool = False  # a finished jump jumps again
    kept_by: tuple[str, int] = ("", 0)  # this parameter's bit keeps a finished jump's counter
    looks_past_jumps: bool = False  # it looks for the next navigation item past a jump to another item
    #: Only the first action is looked up before the next navigation item, the others after it. The jump counters at
    #: that moment apply: an action after a finished jump comes one pass early.
    queues_actions: bool = False


class ProtocolProfile(NamedTuple):
    #: A transfer deletes the old mission or rally points first; a fence is replaced at its end.
    forgets_at_count: bool = False
    judges_later: bool = False  # may report the stored mission unflyable after its Ack
    starts_by_command: bool = False  # once armed it waits for MISSION_START
    pauses_in_mission: bool = False  # DO_PAUSE_CONTINUE pauses its mission
    takes_mission_file: bool = False  # it takes a mission as a file over MAVFTP
    boots_slowly: bool = False  # it answers before its storage is read
    tells_items: bool = False  # its status texts name items
    parameters_by_name: bool = False  # the answer has no index
    keeps_types: bool = False  # a set with another type has no effect
    limits_are_bits: str = ""  # this parameter switches its own fence's limits
    arming_words: ArmingWords = ArmingWords(re.compile(r"(?!)"), re.compile(r"(?!)"))  # never match
    widen_fence: str = "give the vehicle a wider fence; --anyway sends it all the same"


def mode_number(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


class Modes(NamedTuple):
    mission: int
    arming: int  # armed in it
    hold: int  # keeps its place without a pilot
    returning: int  # RTL
    returns: frozenset[int]  # all that return
    landing: int  # LAND
    names: Mapping[int, str]
    has_sub_modes: bool = False

    def name(self, custom_mode: int) -> str:
        return self.names.get(custom_mode, f"mode {custom_mode}")

    def does_next(self, custom_mode: int) -> str:
        if custom_mode == self.mission:
            return "it continues its mission"
        if custom_mode in self.returns:
            return "it returns home and lands"
        return "it lands where it is" if custom_mode == self.landing else "it stays in this mode"

    def numbers(self, custom_mode: int) -> tuple[float, ...]:
        return (custom_mode >> 16 & 0xFF, custom_mode >> 24) if self.has_sub_modes else (custom_mode,)

    def mode_of(self, main: float, sub: float) -> int:
        return mode_number(int(main) & 0xFF, int(sub) & 0xFF) if self.has_sub_modes else int(main)


#: Cameras, mounts, servos, messages.
EQUIPMENT = frozenset({
    Command.NAV_ROI, Command.DO_SET_RELAY, Command.DO_REPEAT_RELAY, Command.DO_SET_SERVO, Command.DO_REPEAT_SERVO,
    Command.DO_SET_ACTUATOR, Command.DO_SET_ROI_LOCATION, Command.DO_SET_ROI_WPNEXT_OFFSET, Command.DO_SET_ROI_NONE,
    Command.DO_CONTROL_VIDEO, Command.DO_SET_ROI, Command.DO_DIGICAM_CONFIGURE, Command.DO_DIGICAM_CONTROL,
    Command.DO_MOUNT_CONFIGURE, Command.DO_MOUNT_CONTROL, Command.DO_SET_CAM_TRIGG_DIST, Command.DO_GRIPPER,
    Command.DO_SET_CAM_TRIGG_INTERVAL, Command.DO_SPRAYER, Command.DO_SEND_SCRIPT_MESSAGE, Command.OBLIQUE_SURVEY,
    Command.SET_CAMERA_MODE, Command.SET_CAMERA_ZOOM, Command.SET_CAMERA_FOCUS, Command.SET_CAMERA_SOURCE,
    Command.DO_GIMBAL_MANAGER_PITCHYAW, Command.DO_GIMBAL_MANAGER_CONFIGURE, Command.IMAGE_START_CAPTURE,
    Command.IMAGE_STOP_CAPTURE, Command.DO_TRIGGER_CONTROL, Command.VIDEO_START_CAPTURE, Command.VIDEO_STOP_CAPTURE,
    Command.DO_WINCH,
})  # fmt: skip
SIMPLE = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME, Command.NAV_RETURN_TO_LAUNCH,
    Command.NAV_LAND, Command.NAV_TAKEOFF, Command.NAV_DELAY, Command.DO_CHANGE_SPEED,
})  # fmt: skip


@dataclass(frozen=True)
class CommandEffects:
    """Commands by effect; all others make the path unknown."""

    flown: Set[int] = SIMPLE
    still: Set[int] = EQUIPMENT  # they have no effect on the path
    why: Mapping[int, str] = field(default_factory=dict)
    replays_speed: bool = False  # the last change of speed before the item at which a mission begins
    #: They have no effect on the path if this is true of their params.
    unless: Mapping[int, Callable[[Sequence[float]], bool]] = field(default_factory=dict)
    #: True if items behind a command are flown. Arguments: the command, if a take-off follows, parameters.
    flies_on: Callable[[int, bool, Mapping[str, float]], bool] = lambda *_: True

    def why_unknown(self, command: int, params: Sequence[float]) -> str | None:
        marks = {*JUMPS, Command.JUMP_TAG, Command.DO_LAND_START, Command.DO_RETURN_PATH_START}
        if command in self.flown or command in self.still or command in marks:
            return None
        if command in self.unless and self.unless[command](params):
            return None
        return self.why.get(command, "its path is not modeled")


class FlownCircle(NamedTuple):
    radius: float  # [m]
    behind: float  # lag at the end [rad]
    runs_on: float  # way until it stops [m]
    sense: float = 0.0  # 1 clockwise, -1 counterclockwise, 0 as in the item
