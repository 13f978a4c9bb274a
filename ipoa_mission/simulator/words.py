"""What ArduCopter calls the items of a mission when it tells that it begins one."""

from collections.abc import Mapping

from ipoa_mission.commands import Command

_NAMES: Mapping[int, str] = {
    Command.NAV_WAYPOINT: "WP",
    Command.NAV_SPLINE_WAYPOINT: "SplineWP",
    Command.NAV_RETURN_TO_LAUNCH: "RTL",
    Command.NAV_LOITER_UNLIM: "LoitUnlim",
    Command.NAV_LOITER_TIME: "LoitTime",
    Command.NAV_LOITER_TURNS: "LoitTurns",
    Command.NAV_LOITER_TO_ALT: "LoitAltitude",
    Command.NAV_TAKEOFF: "Takeoff",
    Command.NAV_LAND: "Land",
    Command.NAV_DELAY: "Delay",
    Command.NAV_PAYLOAD_PLACE: "PayloadPlace",
    Command.CONDITION_DELAY: "CondDelay",
    Command.CONDITION_DISTANCE: "CondDist",
    Command.CONDITION_YAW: "CondYaw",
    Command.DO_CHANGE_SPEED: "ChangeSpeed",
    Command.DO_SET_HOME: "SetHome",
    Command.DO_JUMP: "Jump",
}
#: Items whose end is told in words: places that are flown to.
SAID_WHEN_REACHED = frozenset(
    {
        Command.NAV_WAYPOINT,
        Command.NAV_SPLINE_WAYPOINT,
        Command.NAV_LOITER_TIME,
        Command.NAV_LOITER_TURNS,
        Command.NAV_LOITER_TO_ALT,
    }
)


def begun(seq: int, command: int) -> str:
    """The words with which item `seq` begins."""
    return f"Mission: {seq} {_NAMES.get(command, '?')}"
