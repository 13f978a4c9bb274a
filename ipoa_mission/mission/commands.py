"""Number mission commands, vehicle commands and frames by MAVLink's names (MAV_CMD, MAV_FRAME)."""

from collections.abc import Mapping
from enum import IntEnum


class Command(IntEnum):
    """Number the MAV_CMDs that ArduCopter or PX4 take as mission items; an item may carry any other."""

    NAV_WAYPOINT = 16
    NAV_LOITER_UNLIM = 17
    NAV_LOITER_TURNS = 18
    NAV_LOITER_TIME = 19
    NAV_RETURN_TO_LAUNCH = 20
    NAV_LAND = 21
    NAV_TAKEOFF = 22
    NAV_CONTINUE_AND_CHANGE_ALT = 30
    NAV_LOITER_TO_ALT = 31
    NAV_ARC_WAYPOINT = 36
    NAV_ROI = 80
    NAV_SPLINE_WAYPOINT = 82
    NAV_ALTITUDE_WAIT = 83
    NAV_VTOL_TAKEOFF = 84
    NAV_VTOL_LAND = 85
    NAV_GUIDED_ENABLE = 92
    NAV_DELAY = 93
    NAV_PAYLOAD_PLACE = 94
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_SET_RELAY = 181
    DO_REPEAT_RELAY = 182
    DO_SET_SERVO = 183
    DO_REPEAT_SERVO = 184
    DO_SET_ACTUATOR = 187
    DO_RETURN_PATH_START = 188
    DO_LAND_START = 189
    DO_GO_AROUND = 191
    DO_PAUSE_CONTINUE = 193
    DO_SET_REVERSE = 194
    DO_SET_ROI_LOCATION = 195
    DO_SET_ROI_WPNEXT_OFFSET = 196
    DO_SET_ROI_NONE = 197
    DO_CONTROL_VIDEO = 200
    DO_SET_ROI = 201
    DO_DIGICAM_CONFIGURE = 202
    DO_DIGICAM_CONTROL = 203
    DO_MOUNT_CONFIGURE = 204
    DO_MOUNT_CONTROL = 205
    DO_SET_CAM_TRIGG_DIST = 206
    DO_FENCE_ENABLE = 207
    DO_PARACHUTE = 208
    DO_INVERTED_FLIGHT = 210
    DO_GRIPPER = 211
    DO_AUTOTUNE_ENABLE = 212
    NAV_SET_YAW_SPEED = 213
    DO_SET_CAM_TRIGG_INTERVAL = 214
    DO_SET_RESUME_REPEAT_DIST = 215
    DO_SPRAYER = 216
    DO_SEND_SCRIPT_MESSAGE = 217
    DO_AUX_FUNCTION = 218
    DO_GUIDED_LIMITS = 222
    DO_ENGINE_CONTROL = 223
    OBLIQUE_SURVEY = 260
    COMPONENT_ARM_DISARM = 400
    SET_CAMERA_MODE = 530
    SET_CAMERA_ZOOM = 531
    SET_CAMERA_FOCUS = 532
    SET_CAMERA_SOURCE = 534
    JUMP_TAG = 600
    DO_JUMP_TAG = 601
    DO_GIMBAL_MANAGER_PITCHYAW = 1000
    DO_GIMBAL_MANAGER_CONFIGURE = 1001
    IMAGE_START_CAPTURE = 2000
    IMAGE_STOP_CAPTURE = 2001
    DO_TRIGGER_CONTROL = 2003
    VIDEO_START_CAPTURE = 2500
    VIDEO_STOP_CAPTURE = 2501
    DO_VTOL_TRANSITION = 3000
    CONDITION_GATE = 4501
    NAV_FENCE_RETURN_POINT = 5000
    NAV_FENCE_POLYGON_VERTEX_INCLUSION = 5001
    NAV_FENCE_POLYGON_VERTEX_EXCLUSION = 5002
    NAV_FENCE_CIRCLE_INCLUSION = 5003
    NAV_FENCE_CIRCLE_EXCLUSION = 5004
    NAV_RALLY_POINT = 5100
    DO_WINCH = 42600
    NAV_SCRIPT_TIME = 42702
    NAV_ATTITUDE_TIME = 42703


class VehicleCommand(IntEnum):
    """Number the MAV_CMDs that a vehicle executes at once, and no mission holds."""

    DO_SET_MODE = 176
    DO_REPOSITION = 192
    DO_SET_MISSION_CURRENT = 224
    PREFLIGHT_REBOOT_SHUTDOWN = 246
    MISSION_START = 300
    RUN_PREARM_CHECKS = 401
    GET_HOME_POSITION = 410
    GET_MESSAGE_INTERVAL = 510
    SET_MESSAGE_INTERVAL = 511
    REQUEST_MESSAGE = 512
    REQUEST_PROTOCOL_VERSION = 519
    REQUEST_AUTOPILOT_CAPABILITIES = 520


def command_name(number: int) -> str:
    """Return the MAV_CMD name of a command, or its number if the package has no name for it."""
    return Command(number).name if number in set(Command) else f"command {number}"


def short_name(number: int) -> str:
    """Return the name in lower case without its kind: "return to launch" for NAV_RETURN_TO_LAUNCH."""
    return command_name(number).removeprefix("NAV_").removeprefix("DO_").replace("_", " ").lower()


class Frame(IntEnum):
    """Number the MAV_FRAMEs of mission files."""

    GLOBAL = 0  # altitude AMSL
    MISSION = 2  # not a position
    GLOBAL_RELATIVE_ALT = 3  # altitude above home
    GLOBAL_INT = 5
    GLOBAL_RELATIVE_ALT_INT = 6
    GLOBAL_TERRAIN_ALT = 10  # altitude above terrain
    GLOBAL_TERRAIN_ALT_INT = 11


#: Frames that equal an `_INT` frame.
PLAIN_FRAME: Mapping[int, int] = {
    Frame.GLOBAL_INT: Frame.GLOBAL,
    Frame.GLOBAL_RELATIVE_ALT_INT: Frame.GLOBAL_RELATIVE_ALT,
    Frame.GLOBAL_TERRAIN_ALT_INT: Frame.GLOBAL_TERRAIN_ALT,
}


def plain_frame(frame: int) -> int:
    return int(PLAIN_FRAME.get(frame, frame))


#: Commands whose latitude and longitude the vehicle flies to; TAKEOFF and LAND at (0, 0) mean "here".
FLOWN_TO = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TURNS,
    Command.NAV_LOITER_TIME, Command.NAV_LOITER_TO_ALT, Command.NAV_PAYLOAD_PLACE, Command.NAV_LAND,
    Command.NAV_TAKEOFF, Command.NAV_ARC_WAYPOINT,
})  # fmt: skip
#: Commands whose altitude 0 is valid: take-off and landing.
TAKEOFF_AND_LAND = frozenset({Command.NAV_TAKEOFF, Command.NAV_LAND})
TAKEOFFS = frozenset({Command.NAV_TAKEOFF, Command.NAV_VTOL_TAKEOFF})
#: NAV commands that may precede a take-off.
MAY_PRECEDE_TAKEOFF = frozenset({Command.NAV_DELAY})
#: Commands that end a flight on the ground.
ENDINGS = frozenset({Command.NAV_LAND, Command.NAV_VTOL_LAND, Command.NAV_RETURN_TO_LAUNCH})
WAYPOINTS = frozenset({Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_ARC_WAYPOINT})
#: Commands whose param1 is a hold time at their place [s].
HOLDING = frozenset({Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME})
LAST_NAV = 95  # MAV_CMD_NAV_LAST: higher numbers do not move the vehicle
#: Higher numbers that move the vehicle.
MOVING_AFTER_LAST_NAV = frozenset({Command.NAV_SET_YAW_SPEED, Command.NAV_SCRIPT_TIME, Command.NAV_ATTITUDE_TIME})
JUMPS = frozenset({Command.DO_JUMP, Command.DO_JUMP_TAG})
