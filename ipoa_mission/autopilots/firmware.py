"""What ArduCopter and PX4 take, and what they keep of it: tables, no behavior.

Measured on ArduCopter 4.7.0-dev and PX4 1.17.0; what was not measured is read in their storage code (AP_Mission,
mavlink_mission). A row gives, for each of the seven params, what a read-back returns:

    `.` what was sent          `-` 0                          `b` 1 where positive, else 0
    `w` cut to a whole number  `s` 1 or -1, by its sign       `y` a heading wrapped into 0 to 360
    `c` cut to centimetres     `m` cut to whole metres        `d` degrees in steps of 1e-7
    `t` turns: whole, below one in 256ths                     `r` a radius: whole metres to 255, tens of metres to 2550
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Command, Frame


@dataclass(frozen=True)
class Firmware:
    """The habits of one firmware: a command is in `placed` (with a position), in `plain` (frame 2), or in neither."""

    name: str
    home_is_item_0: bool  # on the wire and in the counting of DO_JUMP
    keeps_autocontinue: bool
    frames: frozenset[int]  # of commands with a position
    placed: Mapping[int, str]
    plain: Mapping[int, str]
    fence: Mapping[int, str]
    rally: Mapping[int, str]
    fence_is_union: bool  # of areas to stay in: inside one is enough; else the vehicle must be inside all
    max_items: int  # the home item counts
    max_fence_items: int
    max_rally_points: int
    highest_altitude: float  # [m]; items at or above it are refused
    takes_nan_param4: frozenset[int] | None  # None: NaN is taken anywhere
    renames: Mapping[int, int] = field(default_factory=lambda: MappingProxyType({}))  # stored under another number

    def kept(self, command: int, frame: int) -> str | None:
        """The row for an item, seven letters; None where the firmware has no such command."""
        tables = (self.plain, self.placed) if frame == Frame.MISSION else (self.placed, self.plain)
        for table in (*tables, self.fence, self.rally):
            if command in table:
                return table[command]
        return None


def _table(rows: dict[str, tuple[Command, ...]]) -> Mapping[int, str]:
    return MappingProxyType({int(command): kept for kept, commands in rows.items() for command in commands})


ARDUCOPTER = Firmware(
    name="ArduPilot",
    home_is_item_0=True,
    keeps_autocontinue=False,
    frames=frozenset({0, 2, 3, 5, 6, 10, 11}),
    placed=_table(
        {
            "w---ddc": (
                Command.NAV_WAYPOINT,
                Command.NAV_TAKEOFF,
                Command.NAV_SPLINE_WAYPOINT,
                Command.NAV_CONTINUE_AND_CHANGE_ALT,
                Command.NAV_VTOL_LAND,
                Command.DO_SET_HOME,
                Command.DO_SET_ROI,
            ),
            "w--sddc": (Command.NAV_LAND,),
            "--w-ddc": (Command.NAV_LOITER_UNLIM,),
            "t-rbddc": (Command.NAV_LOITER_TURNS,),
            "w-sbddc": (Command.NAV_LOITER_TIME,),
            "-w-bddc": (Command.NAV_LOITER_TO_ALT,),
            "c---ddc": (Command.NAV_PAYLOAD_PLACE,),
            "----ddc": (
                Command.NAV_VTOL_TAKEOFF,
                Command.DO_LAND_START,
                Command.DO_RETURN_PATH_START,
                Command.DO_GO_AROUND,
                Command.DO_SET_ROI_LOCATION,
            ),
        }
    ),
    plain=_table(
        {
            "-------": (Command.NAV_RETURN_TO_LAUNCH, Command.DO_SET_ROI_NONE),
            "w------": (
                Command.NAV_GUIDED_ENABLE,
                Command.DO_FENCE_ENABLE,
                Command.DO_PARACHUTE,
                Command.DO_INVERTED_FLIGHT,
                Command.DO_AUTOTUNE_ENABLE,
                Command.DO_SET_RESUME_REPEAT_DIST,
                Command.DO_SPRAYER,
                Command.DO_PAUSE_CONTINUE,
                Command.JUMP_TAG,
                Command.IMAGE_STOP_CAPTURE,
                Command.VIDEO_START_CAPTURE,
                Command.VIDEO_STOP_CAPTURE,
            ),
            ".------": (Command.CONDITION_DELAY, Command.CONDITION_DISTANCE, Command.DO_VTOL_TRANSITION),
            ".www---": (Command.NAV_DELAY,),
            "..ww---": (Command.CONDITION_YAW,),
            "...----": (
                Command.DO_CHANGE_SPEED,
                Command.NAV_ALTITUDE_WAIT,
                Command.NAV_SET_YAW_SPEED,
                Command.DO_MOUNT_CONTROL,
            ),
            "ww-----": (
                Command.DO_JUMP,
                Command.DO_JUMP_TAG,
                Command.DO_SET_RELAY,
                Command.DO_SET_SERVO,
                Command.DO_GRIPPER,
                Command.DO_AUX_FUNCTION,
            ),
            "ww.----": (Command.DO_REPEAT_RELAY,),
            "www.---": (Command.DO_REPEAT_SERVO,),
            "w...---": (Command.DO_GUIDED_LIMITS, Command.DO_SEND_SCRIPT_MESSAGE),
            "ww..---": (Command.DO_WINCH,),
            ".-w----": (Command.DO_SET_CAM_TRIGG_DIST,),
            "bbc----": (Command.DO_ENGINE_CONTROL,),
            "wwwwwww": (Command.DO_DIGICAM_CONFIGURE,),
            "wwwwww-": (Command.DO_DIGICAM_CONTROL,),
            "....w-w": (Command.DO_GIMBAL_MANAGER_PITCHYAW,),
            "w.ww---": (Command.IMAGE_START_CAPTURE,),
            "w.-----": (Command.SET_CAMERA_ZOOM, Command.SET_CAMERA_FOCUS),
            "www----": (Command.SET_CAMERA_SOURCE,),
        }
    ),
    fence=_table(
        {
            "w---dd-": (Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION),
            ".---dd-": (Command.NAV_FENCE_CIRCLE_INCLUSION, Command.NAV_FENCE_CIRCLE_EXCLUSION),
            "----dd-": (Command.NAV_FENCE_RETURN_POINT,),
        }
    ),
    rally=_table({"----ddm": (Command.NAV_RALLY_POINT,)}),
    fence_is_union=False,  # unless bit 1 of FENCE_OPTIONS says so
    max_items=650,
    max_fence_items=70,
    max_rally_points=46,
    highest_altitude=83_000.0,
    takes_nan_param4=frozenset({Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LAND, Command.NAV_TAKEOFF}),
)

PX4 = Firmware(
    name="PX4",
    home_is_item_0=False,
    keeps_autocontinue=True,
    frames=frozenset({0, 2, 3, 5, 6}),
    placed=_table(
        {
            "..-ydd.": (Command.NAV_WAYPOINT,),
            "--.ydd.": (Command.NAV_LOITER_UNLIM,),
            ".b.bdd.": (Command.NAV_LOITER_TIME,),
            "b.-bdd.": (Command.NAV_LOITER_TO_ALT,),
            "-w-ydd.": (Command.NAV_LAND,),
            "---ydd.": (Command.NAV_TAKEOFF, Command.NAV_VTOL_TAKEOFF, Command.NAV_VTOL_LAND),
            # Stored whole, but the code that answers a download has no words for their params.
            "----dd.": (
                Command.CONDITION_GATE,
                Command.NAV_ROI,
                Command.DO_SET_ROI,
                Command.DO_SET_ROI_LOCATION,
                Command.COMPONENT_ARM_DISARM,
                Command.DO_AUTOTUNE_ENABLE,
            ),
        }
    ),
    plain=_table(
        {
            "ww.....": (Command.DO_JUMP,),
            ".......": (
                Command.NAV_RETURN_TO_LAUNCH,
                Command.NAV_DELAY,
                Command.NAV_ROI,
                Command.CONDITION_DELAY,
                Command.CONDITION_DISTANCE,
                Command.DO_CHANGE_SPEED,
                Command.DO_SET_HOME,
                Command.DO_LAND_START,
                Command.DO_SET_ACTUATOR,
                Command.DO_SET_ROI_WPNEXT_OFFSET,
                Command.DO_SET_ROI_NONE,
                Command.DO_SET_ROI,
                Command.DO_CONTROL_VIDEO,
                Command.DO_DIGICAM_CONTROL,
                Command.DO_MOUNT_CONFIGURE,
                Command.DO_MOUNT_CONTROL,
                Command.DO_SET_CAM_TRIGG_DIST,
                Command.DO_SET_CAM_TRIGG_INTERVAL,
                Command.DO_GRIPPER,
                Command.DO_WINCH,
                Command.DO_AUTOTUNE_ENABLE,
                Command.OBLIQUE_SURVEY,
                Command.COMPONENT_ARM_DISARM,
                Command.SET_CAMERA_MODE,
                Command.SET_CAMERA_FOCUS,
                Command.SET_CAMERA_SOURCE,
                Command.DO_GIMBAL_MANAGER_PITCHYAW,
                Command.DO_GIMBAL_MANAGER_CONFIGURE,
                Command.IMAGE_START_CAPTURE,
                Command.IMAGE_STOP_CAPTURE,
                Command.DO_TRIGGER_CONTROL,
                Command.VIDEO_START_CAPTURE,
                Command.VIDEO_STOP_CAPTURE,
                Command.DO_VTOL_TRANSITION,
            ),
        }
    ),
    fence=_table(
        {
            "w---dd.": (Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION),
            ".---dd.": (Command.NAV_FENCE_CIRCLE_INCLUSION, Command.NAV_FENCE_CIRCLE_EXCLUSION),
            "----dd.": (Command.NAV_FENCE_RETURN_POINT,),
        }
    ),
    rally=_table({"----dd.": (Command.NAV_RALLY_POINT,)}),
    fence_is_union=True,
    max_items=10_000,
    max_fence_items=64,
    max_rally_points=32,
    highest_altitude=float("inf"),
    takes_nan_param4=None,
    renames=MappingProxyType({int(Command.NAV_ROI): int(Command.DO_SET_ROI)}),
)

FIRMWARE: Mapping[Autopilot, Firmware] = MappingProxyType({Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4})
