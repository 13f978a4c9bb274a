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
    renames: Mapping[int, int] = field(default_factory=dict)  # stored under another number

    def kept(self, command: int, frame: int) -> str | None:
        """The row for an item, seven letters; None where the firmware has no such command."""
        tables = (self.plain, self.placed) if frame == Frame.MISSION else (self.placed, self.plain)
        for table in (*tables, self.fence, self.rally):
            if command in table:
                return table[command]
        return None


def _table(rows: str) -> Mapping[int, str]:
    """Rows of a read-back, each followed by the commands that it is of."""
    kept, table = "", dict[int, str]()
    for line in rows.splitlines():
        for word in line.partition("#")[0].split():
            if len(word) == 7 and word not in Command.__members__:
                kept = word
            else:
                table[int(Command[word])] = kept
    return table


ARDUCOPTER = Firmware(
    name="ArduPilot",
    home_is_item_0=True,
    keeps_autocontinue=False,
    frames=frozenset({0, 2, 3, 5, 6, 10, 11}),
    placed=_table(
        """
        w---ddc NAV_WAYPOINT NAV_TAKEOFF NAV_SPLINE_WAYPOINT NAV_CONTINUE_AND_CHANGE_ALT NAV_VTOL_LAND DO_SET_HOME
                DO_SET_ROI
        w--sddc NAV_LAND
        --w-ddc NAV_LOITER_UNLIM
        t-rbddc NAV_LOITER_TURNS
        w-sbddc NAV_LOITER_TIME
        -w-bddc NAV_LOITER_TO_ALT
        c---ddc NAV_PAYLOAD_PLACE
        ----ddc NAV_VTOL_TAKEOFF DO_LAND_START DO_RETURN_PATH_START DO_GO_AROUND DO_SET_ROI_LOCATION
        """
    ),
    plain=_table(
        """
        ------- NAV_RETURN_TO_LAUNCH DO_SET_ROI_NONE
        w------ NAV_GUIDED_ENABLE DO_FENCE_ENABLE DO_PARACHUTE DO_INVERTED_FLIGHT DO_AUTOTUNE_ENABLE
                DO_SET_RESUME_REPEAT_DIST DO_SPRAYER DO_PAUSE_CONTINUE JUMP_TAG IMAGE_STOP_CAPTURE VIDEO_START_CAPTURE
                VIDEO_STOP_CAPTURE
        .------ CONDITION_DELAY CONDITION_DISTANCE DO_VTOL_TRANSITION
        .www--- NAV_DELAY
        ..ww--- CONDITION_YAW
        ...---- DO_CHANGE_SPEED NAV_ALTITUDE_WAIT NAV_SET_YAW_SPEED DO_MOUNT_CONTROL
        ww----- DO_JUMP DO_JUMP_TAG DO_SET_RELAY DO_SET_SERVO DO_GRIPPER DO_AUX_FUNCTION
        ww.---- DO_REPEAT_RELAY
        www.--- DO_REPEAT_SERVO
        w...--- DO_GUIDED_LIMITS DO_SEND_SCRIPT_MESSAGE
        ww..--- DO_WINCH
        .-w---- DO_SET_CAM_TRIGG_DIST
        bbc---- DO_ENGINE_CONTROL
        wwwwwww DO_DIGICAM_CONFIGURE
        wwwwww- DO_DIGICAM_CONTROL
        ....w-w DO_GIMBAL_MANAGER_PITCHYAW
        w.ww--- IMAGE_START_CAPTURE
        w.----- SET_CAMERA_ZOOM SET_CAMERA_FOCUS
        www---- SET_CAMERA_SOURCE
        """
    ),
    fence=_table(
        """
        w---dd- NAV_FENCE_POLYGON_VERTEX_INCLUSION NAV_FENCE_POLYGON_VERTEX_EXCLUSION
        .---dd- NAV_FENCE_CIRCLE_INCLUSION NAV_FENCE_CIRCLE_EXCLUSION
        ----dd- NAV_FENCE_RETURN_POINT
        """
    ),
    rally=_table("----ddm NAV_RALLY_POINT"),
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
        """
        ..-ydd. NAV_WAYPOINT
        --.ydd. NAV_LOITER_UNLIM
        .b.bdd. NAV_LOITER_TIME
        b.-bdd. NAV_LOITER_TO_ALT
        -w-ydd. NAV_LAND
        ---ydd. NAV_TAKEOFF NAV_VTOL_TAKEOFF NAV_VTOL_LAND
        # Stored whole, but the code that answers a download has no words for their params.
        ----dd. CONDITION_GATE NAV_ROI DO_SET_ROI DO_SET_ROI_LOCATION COMPONENT_ARM_DISARM DO_AUTOTUNE_ENABLE
        """
    ),
    plain=_table(
        """
        ww..... DO_JUMP
        ....... NAV_RETURN_TO_LAUNCH NAV_DELAY NAV_ROI CONDITION_DELAY CONDITION_DISTANCE DO_CHANGE_SPEED DO_SET_HOME
                DO_LAND_START DO_SET_ACTUATOR DO_SET_ROI_WPNEXT_OFFSET DO_SET_ROI_NONE DO_SET_ROI DO_CONTROL_VIDEO
                DO_DIGICAM_CONTROL DO_MOUNT_CONFIGURE DO_MOUNT_CONTROL DO_SET_CAM_TRIGG_DIST DO_SET_CAM_TRIGG_INTERVAL
                DO_GRIPPER DO_WINCH DO_AUTOTUNE_ENABLE OBLIQUE_SURVEY COMPONENT_ARM_DISARM SET_CAMERA_MODE
                SET_CAMERA_FOCUS SET_CAMERA_SOURCE DO_GIMBAL_MANAGER_PITCHYAW DO_GIMBAL_MANAGER_CONFIGURE
                IMAGE_START_CAPTURE IMAGE_STOP_CAPTURE DO_TRIGGER_CONTROL VIDEO_START_CAPTURE VIDEO_STOP_CAPTURE
                DO_VTOL_TRANSITION
        """
    ),
    fence=_table(
        """
        w---dd. NAV_FENCE_POLYGON_VERTEX_INCLUSION NAV_FENCE_POLYGON_VERTEX_EXCLUSION
        .---dd. NAV_FENCE_CIRCLE_INCLUSION NAV_FENCE_CIRCLE_EXCLUSION
        ----dd. NAV_FENCE_RETURN_POINT
        """
    ),
    rally=_table("----dd. NAV_RALLY_POINT"),
    fence_is_union=True,
    max_items=10_000,
    max_fence_items=64,
    max_rally_points=32,
    highest_altitude=float("inf"),
    takes_nan_param4=None,
    renames={int(Command.NAV_ROI): int(Command.DO_SET_ROI)},
)

FIRMWARE: Mapping[Autopilot, Firmware] = {Autopilot.ARDUPILOT: ARDUCOPTER, Autopilot.PX4: PX4}
