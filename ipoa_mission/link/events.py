"""PX4's EVENT numbers: component id and lower 24 bits of the name's FNV-1a hash.

These are the names of PX4's feasibility check of a multicopter's mission.
"""

import struct


def event_number(name: str) -> int:
    value = 0x811C9DC5
    for byte in name.encode():
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return 1 << 24 | value & 0xFFFFFF  # of the autopilot


#: Words and memory layout of the arguments, by event number. Ground stations load the words from a metadata file.
_MISSION_EVENTS = {
    event_number(f"navigator_mis_{name}"): entry
    for name, entry in {
        "takeoff_missing": ("a take-off item is required", "<"),
        "land_missing": ("a landing item is required", "<"),
        "takeoff_or_land_missing": ("a take-off or a landing item is missing", "<"),
        "add_land_or_rm_to": ("there is a take-off but no landing", "<"),
        "add_to_or_rm_land": ("there is a landing but no take-off", "<"),
        "takeoff_too_low": ("the take-off is too low: at least {0:.1f} m is required", "<f"),
        "takeoff_not_first": ("the take-off is not the first item with a position", "<"),
        "starts_w_landing": ("the mission begins with a landing", "<"),
        "starts_w_landing2": ("the mission begins with a landing", "<"),
        "unsup_cmd": ("item {0} has command {1}, which this vehicle cannot fly", "<HH"),
        "act_index": ("actuator {0} is out of bounds", "<I"),
        "act_range": ("actuator value {0} is out of bounds", "<I"),
        "first_wp_too_far": ("the first waypoint is {0} m away, and {1} m is the most", "<II"),
        "wp_dist_too_far": ("two waypoints are {0} m apart, and {1} m is the most", "<II"),
        "wp_gate_too_close": ("a waypoint and a gate are too close", "<"),
        "no_home_rel_alt": ("the vehicle has no home, but altitudes are relative to it", "<"),
    }.items()
}


def mission_event(name: str, *values: float) -> tuple[int, bytes]:
    number = event_number(f"navigator_mis_{name}")
    return number, struct.pack(_MISSION_EVENTS[number][1], *values)


def words_of(number: int, arguments: bytes) -> str | None:
    """MAVLink cuts zeros off `arguments`."""
    if number not in _MISSION_EVENTS:
        return None
    words, layout = _MISSION_EVENTS[number]
    size = struct.calcsize(layout)
    return words.format(*struct.unpack(layout, arguments[:size].ljust(size, b"\0")))
