from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field

from ipoa_mission.autopilot.commands import Command

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
#: Labels and jumps.
MARKS = frozenset({
    Command.DO_JUMP, Command.JUMP_TAG, Command.DO_JUMP_TAG, Command.DO_LAND_START, Command.DO_RETURN_PATH_START,
})  # fmt: skip
SIMPLE = frozenset({
    Command.NAV_WAYPOINT, Command.NAV_LOITER_UNLIM, Command.NAV_LOITER_TIME, Command.NAV_RETURN_TO_LAUNCH,
    Command.NAV_LAND, Command.NAV_TAKEOFF, Command.NAV_DELAY, Command.DO_CHANGE_SPEED,
})  # fmt: skip


@dataclass(frozen=True)
class WayKnown:
    """Commands by effect; all others make the path unknown."""

    flown: Set[int] = SIMPLE
    still: Set[int] = EQUIPMENT
    """Without effect."""
    why: Mapping[int, str] = field(default_factory=dict)
    unless: Mapping[int, Callable[[Sequence[float]], bool]] = field(default_factory=dict)
    """Predicates on params without effect."""

    def why_unknown(self, command: int, params: Sequence[float]) -> str | None:
        if command in self.flown or command in self.still or command in MARKS:
            return None
        if command in self.unless and self.unless[command](params):
            return None
        return self.why.get(command, "its path is not modeled")
