"""Flight modes by the autopilots' own numbers and names, what a vehicle in each does by itself; versions modeled."""

import re
from collections.abc import Mapping

from ipoa_mission.autopilots.vehicle import Autopilot


def px4_mode(main: int, sub: int = 0) -> int:
    """HEARTBEAT.custom_mode of a PX4 main mode and sub mode."""
    return main << 16 | sub << 24


#: The mode in which a mission is flown.
MISSION_MODE: Mapping[Autopilot, int] = {Autopilot.ARDUPILOT: 3, Autopilot.PX4: px4_mode(4, 4)}
#: The mode in which a vehicle is armed for it: ArduCopter refuses to be armed in AUTO (AUTO_OPTIONS 0), and takes
#: GUIDED only with a position; PX4, armed in its mission mode, takes off at once.
ARMING_MODE: Mapping[Autopilot, int] = {Autopilot.ARDUPILOT: 4, Autopilot.PX4: px4_mode(4, 4)}
#: The mode that holds its place without a pilot: ArduCopter's LOITER would follow the throttle stick.
HOLD_MODE: Mapping[Autopilot, int] = {Autopilot.ARDUPILOT: 17, Autopilot.PX4: px4_mode(4, 3)}
RETURN_MODE: Mapping[Autopilot, int] = {Autopilot.ARDUPILOT: 6, Autopilot.PX4: px4_mode(4, 5)}
#: The modes in which it comes home: PX4 leaves its mission mode for them at an RTL item.
RETURN_MODES: Mapping[Autopilot, frozenset[int]] = {
    Autopilot.ARDUPILOT: frozenset({6, 21, 27}),
    Autopilot.PX4: frozenset({px4_mode(4, 5)}),
}
LAND_MODES: Mapping[Autopilot, frozenset[int]] = {
    Autopilot.ARDUPILOT: frozenset({9}),
    Autopilot.PX4: frozenset({px4_mode(4, 6)}),
}

_NAMES: Mapping[Autopilot, Mapping[int, str]] = {
    Autopilot.ARDUPILOT: {
        0: "STABILIZE",
        1: "ACRO",
        2: "ALT_HOLD",
        3: "AUTO",
        4: "GUIDED",
        5: "LOITER",
        6: "RTL",
        7: "CIRCLE",
        9: "LAND",
        16: "POSHOLD",
        17: "BRAKE",
        21: "SMART_RTL",
        27: "AUTO_RTL",
    },
    Autopilot.PX4: {
        px4_mode(1): "MANUAL",
        px4_mode(2): "ALTCTL",
        px4_mode(3): "POSCTL",
        px4_mode(4, 2): "AUTO.TAKEOFF",
        px4_mode(4, 3): "AUTO.LOITER",
        px4_mode(4, 4): "AUTO.MISSION",
        px4_mode(4, 5): "AUTO.RTL",
        px4_mode(4, 6): "AUTO.LAND",
        px4_mode(6): "OFFBOARD",
        px4_mode(7): "STABILIZED",
    },
}


def mode_name(autopilot: Autopilot, custom_mode: int) -> str:
    """The autopilot's name of HEARTBEAT.custom_mode, or its number."""
    return _NAMES[autopilot].get(custom_mode, f"mode {custom_mode}")


def does_next(autopilot: Autopilot, custom_mode: int) -> str:
    """What a flying vehicle in this mode does if nobody tells it otherwise."""
    if custom_mode == MISSION_MODE[autopilot]:
        return "it flies on with its mission"
    if custom_mode in RETURN_MODES[autopilot]:
        return "it returns home and lands"
    if custom_mode in LAND_MODES[autopilot]:
        return "it lands where it is"
    return "it stays in this mode"


def knows_mode(autopilot: Autopilot, custom_mode: int) -> bool:
    """Whether the autopilot has a mode of this number, as far as this table knows."""
    return custom_mode in _NAMES[autopilot]


#: The oldest version whose habits the models have, and its name.
OLDEST = {Autopilot.ARDUPILOT: ("ArduCopter", (4, 0)), Autopilot.PX4: ("PX4", (1, 13))}


def beyond_the_model(autopilot: Autopilot, version: str) -> str | None:
    """What to say of times that are estimated for a version; None where the model is of it.

    >>> beyond_the_model(Autopilot.PX4, "1.15.0-dev")
    >>> beyond_the_model(Autopilot.ARDUPILOT, "3.5.7")
    'flown by ArduCopter 3.5.7; the model is of 4.0 and later, and its times may be off'
    """
    name, oldest = OLDEST[autopilot]
    least = ".".join(map(str, oldest))
    numbers = re.match(r"(\d+)\.(\d+)", version)
    if numbers is None:
        return f"the log does not say which {name} flew it; the model is of {least} and later"
    if tuple(map(int, numbers.groups())) >= oldest:
        return None
    return f"flown by {name} {version}; the model is of {least} and later, and its times may be off"
