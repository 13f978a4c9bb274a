"""Effect of ArduCopter's commands on the path (4.8.0-dev, ModeAuto::start_command; flown)."""

import math

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.way_known import EQUIPMENT, SIMPLE, WayKnown

#: Stored, and skipped.
SKIPPED_COMMANDS = frozenset(
    {Command.NAV_CONTINUE_AND_CHANGE_ALT, Command.NAV_ALTITUDE_WAIT, Command.NAV_SET_YAW_SPEED}
)
#: Cameras, mounts, relays, lights and similar (RC_Channel::AUX_FUNC).
QUIET_FUNCTIONS = frozenset({
    0, 9, 15, 19, 27, 28, 29, 30, 34, 35, 36, 44, 45, 66, 67, 78, 79, 94, 102, 113, 163, 164, 166, 167, 168, 169, 172,
    174, 175, 177, 185, 186, 212, 213, 214, 215, 216, 217,
})  # fmt: skip
PARACHUTE_RELEASE = 2  # of DO_PARACHUTE

WAY_KNOWN = WayKnown(
    flown=SIMPLE | {
        Command.NAV_SPLINE_WAYPOINT, Command.NAV_ARC_WAYPOINT, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TO_ALT,
        Command.NAV_PAYLOAD_PLACE, Command.NAV_VTOL_LAND, Command.NAV_VTOL_TAKEOFF,
    },
    still=EQUIPMENT | SKIPPED_COMMANDS | {
        Command.CONDITION_DELAY, Command.CONDITION_DISTANCE, Command.CONDITION_YAW, Command.DO_FENCE_ENABLE,
        Command.DO_GUIDED_LIMITS, Command.DO_SET_RESUME_REPEAT_DIST, Command.DO_GO_AROUND, Command.DO_PAUSE_CONTINUE,
        Command.DO_SET_REVERSE, Command.DO_INVERTED_FLIGHT, Command.DO_AUTOTUNE_ENABLE, Command.DO_ENGINE_CONTROL,
        Command.DO_VTOL_TRANSITION,
    },
    why={
        Command.NAV_GUIDED_ENABLE: "another computer controls the vehicle from here on",
        Command.NAV_SCRIPT_TIME: "a script controls the vehicle from here on",
        Command.NAV_ATTITUDE_TIME: "it holds an attitude for a time, which is not modeled",
        Command.DO_SET_HOME: "home changes: heights and returns refer to the new home",
        Command.DO_PARACHUTE: "a parachute may be released",
        Command.DO_AUX_FUNCTION: "a switch may change the mode or stop the motors",
    },
    unless={
        Command.NAV_GUIDED_ENABLE: lambda params: params[0] == 0.0,
        Command.DO_PARACHUTE: lambda params: math.isfinite(params[0]) and int(params[0]) != PARACHUTE_RELEASE,
        Command.DO_AUX_FUNCTION: lambda params: math.isfinite(params[0]) and int(params[0]) in QUIET_FUNCTIONS,
    },
)  # fmt: skip
