import re
from collections.abc import Iterator, Mapping

from ipoa_mission.autopilot.commands import Command, short_name
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.link.definitions import params_in_words
from ipoa_mission.studio.mission_answers import ItemField, ItemKind

LONGEST = 32  # letters
HOLD, HEADING = ("Stay for", "s"), ("Heading there", "°, empty: its own")
#: Label and unit by command; other params are shown if not zero.
OURS: Mapping[int, Mapping[int, tuple[str, str]]] = {
    Command.NAV_WAYPOINT: {1: HOLD, 2: ("Acceptance radius", "m"), 4: HEADING},
    Command.NAV_SPLINE_WAYPOINT: {1: HOLD},
    Command.NAV_ARC_WAYPOINT: {1: ("Turn by", "°")},
    Command.NAV_LOITER_UNLIM: {3: ("Radius", "m"), 4: HEADING},
    Command.NAV_LOITER_TURNS: {1: ("Turns", ""), 3: ("Radius", "m")},
    Command.NAV_LOITER_TIME: {1: HOLD, 3: ("Radius", "m")},
    Command.NAV_RETURN_TO_LAUNCH: {},
    Command.NAV_LAND: {4: HEADING},
    Command.NAV_TAKEOFF: {4: HEADING},
    Command.NAV_DELAY: {1: ("Wait for", "s")},
    Command.CONDITION_DELAY: {1: ("Wait for", "s")},
    Command.CONDITION_DISTANCE: {1: ("Until within", "m")},
    Command.CONDITION_YAW: {
        1: ("Heading", "°"), 2: ("Turn at", "°/s"), 3: ("Direction, 1 or -1", ""), 4: ("Relative", "0 or 1")
    },
    Command.DO_JUMP: {1: ("To item", ""), 2: ("Repeats", "-1: for ever")},
    Command.JUMP_TAG: {1: ("Tag", "")},
    Command.DO_JUMP_TAG: {1: ("To tag", ""), 2: ("Repeats", "-1: for ever")},
    Command.DO_CHANGE_SPEED: {1: ("Kind, 1: over ground", ""), 2: ("Speed", "m/s"), 3: ("Throttle", "%, -1: as it is")},
    Command.DO_SET_SERVO: {1: ("Servo", ""), 2: ("Pulse", "µs")},
    Command.DO_SET_RELAY: {1: ("Relay", ""), 2: ("On", "0 or 1")},
    Command.DO_SET_ROI_LOCATION: {},
    Command.DO_MOUNT_CONTROL: {1: ("Pitch", "°"), 2: ("Roll", "°"), 3: ("Yaw", "°")},
    Command.DO_SET_CAM_TRIGG_DIST: {1: ("A photo every", "m, 0: no more"), 3: ("First at once", "0 or 1")},
    Command.DO_SET_CAM_TRIGG_INTERVAL: {1: ("A photo every", "ms")},
    Command.IMAGE_START_CAPTURE: {2: ("A photo every", "s"), 3: ("Photos", "0: no end")},
    Command.IMAGE_STOP_CAPTURE: {},
    Command.DO_GRIPPER: {1: ("Gripper", ""), 2: ("Hold", "0: let go, 1")},
}  # fmt: skip


def kinds_of(firmware: Firmware) -> tuple[ItemKind, ...]:
    """Return the firmware's mission commands, moving ones first."""
    lists = firmware.fence.keys() | firmware.rally.keys()
    taken = sorted((firmware.placed.keys() | firmware.plain.keys()) - lists)
    return tuple(kind_of(command, command in firmware.placed) for command in taken)


def kind_of(command: int, placed: bool) -> ItemKind:
    name = "take off" if command == Command.NAV_TAKEOFF else short_name(command)
    return ItemKind(command=command, name=name, placed=placed, fields=tuple(_fields(command, placed)))


def _fields(command: int, placed: bool) -> Iterator[ItemField]:
    ours, theirs = OURS.get(command), params_in_words(command)
    for number in range(1, 5 if placed else 8):
        label, unit = (ours or {}).get(number, ("", ""))
        if not label and ours is not None:
            continue
        if label or number in theirs:
            about = theirs.get(number, "")
            what = f"param{number}"
            yield ItemField.model_validate(
                {"what": what, "label": label or _shortened(about), "unit": unit, "about": about}
            )


def _shortened(words: str) -> str:
    first = re.split(r"[.,;:(]", words, maxsplit=1)[0].strip() or words
    if len(first) <= LONGEST:
        return first
    return first[:LONGEST].rsplit(" ", 1)[0] + " …"
