"""Read ArduCopter's source (AP_Mission): which mission items it takes, and what it stores of them."""

import re
from collections.abc import Mapping
from typing import Any

from tools.generate.sources import Source, body, cases, listed, preprocessed

CODE, HEADER = "libraries/AP_Mission/AP_Mission.cpp", "libraries/AP_Mission/AP_Mission.h"
FALSE = "APM_BUILD_ArduPlane"  # all else is built in by default
_DECODE, _ENCODE = "AP_Mission::mavlink_int_to_mission_cmd(", "AP_Mission::mission_cmd_to_mavlink_int("
_FRAMES = (0, 2, 3, 5, 6, 10, 11)
SLOTS = {"param1": 1, "param2": 2, "param3": 3, "param4": 4, "x": 5, "y": 6, "z": 7}

#: Code with several assignments, read by hand: letters, and the words that identify the code.
BY_HAND: Mapping[str, tuple[str, str]] = {
    "NAV_LOITER_UNLIM": ("--w-", "fabsf loiter_ccw"),
    "NAV_LOITER_TURNS": ("t-rb", "256 type_specific_bits HIGHBYTE LOWBYTE loiter_ccw loiter_xtrack"),
    "NAV_LOITER_TIME": ("w-sb", "loiter_ccw loiter_xtrack"),
    "NAV_LOITER_TO_ALT": ("-w-b", "fabsf loiter_ccw loiter_xtrack"),
    "NAV_LAND": ("w--s", "is_negative loiter_ccw"),
    "NAV_ARC_WAYPOINT": ("w---", "is_negative fabsf loiter_ccw"),
    "DO_ENGINE_CONTROL": ("bbc", "start_control cold_start height_delay_cm"),
    "NAV_SCRIPT_TIME": ("wwhhww-", "arg1.set arg1.get arg3"),
    "NAV_ATTITUDE_TIME": ("wwwww--", "constrain_float fabsf climb_rate"),
}


def facts(source: Source) -> dict[str, Any]:
    """Return a commit's table: read-back of commands with and without a place, frames, NaN params."""
    text = preprocessed(source.text(CODE), FALSE)
    types = _types(preprocessed(source.text(HEADER), FALSE))
    decode, encode = (_by_command(body(text, name)) for name in (_DECODE, _ENCODE))
    placed = set(re.findall(r"case MAV_CMD_(\w+):", body(text, "AP_Mission::stored_in_location(")))
    rows = {name: _row(name, code, encode.get(name, ""), types) for name, code in decode.items()}
    refused = [name for name, code in decode.items() if re.search(r"param1 < 0 \|\| packet\.param1 > UINT16_MAX", code)]
    resets = "Option::DONT_ZERO_COUNTER" in text  # of a finished jump
    return {
        "frames": listed(_FRAMES),
        "placed": {name: row[:4] + "ddc" for name, row in rows.items() if name in placed},
        "plain": {name: row for name, row in rows.items() if name not in placed},
        "nan": _nan(body(text, "AP_Mission::sanity_check_params(")),
        **({"sixteen_bits": " ".join(refused)} if refused else {}),
        **({"resets_jumps": True} if resets else {}),
    }


def _by_command(function: str) -> dict[str, str]:
    code_by_command: dict[str, str] = {}
    for labels, code in cases(body(function, "switch (cmd.id)")):
        for label in labels:
            if label.startswith("MAV_CMD_") and "UNSUPPORTED" not in code.partition("break")[0]:
                code_by_command[label.removeprefix("MAV_CMD_")] = code
    return code_by_command


def _types(header: str) -> dict[str, str]:
    """Return the type of each member of the command's content, as `content.jump.target`; `p1` too."""
    structs = {
        name: {field: kind for kind, field in re.findall(r"(\w+)\s+(\w+);", fields)}
        for name, fields in re.findall(r"struct PACKED (\w+) \{(.*?)\};", header, re.DOTALL)
    }
    types = {"p1": "uint16_t"}
    for kind, member in re.findall(r"(\w+)\s+(\w+);", body(header, "union Content")):
        types |= {f"content.{member}.{field}": type_ for field, type_ in structs.get(kind, {}).items()}
    return types


def _row(name: str, decode: str, encode: str, types: Mapping[str, str]) -> str:
    """Return seven letters of a read-back.

    Raises:
        SystemExit: the code is unknown, or differs from the code read by hand.
    """
    if name in BY_HAND:
        by_hand, words = BY_HAND[name]
        if missing := [word for word in words.split() if word not in decode + encode]:
            raise SystemExit(f"{name}: expected {missing} in its code: read it again")
        return by_hand.ljust(7, "-")
    row = ["-"] * 7
    for slot, value in re.findall(r"packet\.(\w+)\s*=\s*([^;]+);", encode):
        if field := re.search(r"cmd\.(p1|content\.\w+\.\w+)", value):
            kept = re.search(rf"cmd\.{re.escape(field[1])}\s*=\s*([^;]+);", decode)
            if kept is None or f"packet.{slot}" not in kept[1]:
                raise SystemExit(f"{name}: expected {slot} to be kept in {field[1]}")
            row[SLOTS[slot] - 1] = _letter(types[field[1]], kept[1])
    return "".join(row)


def _letter(kind: str, kept: str) -> str:
    if kind == "float":
        return "."
    return "c" if re.search(r"\*\s*100\b", kept) else "b" if kind == "bool" else "w"


def _nan(function: str) -> dict[str, str]:
    """Return the params of each command that may be NaN."""
    taken: dict[str, str] = {}
    for labels, code in cases(body(function, "switch (packet.command)")):
        bits = listed(int(bit) + 1 for bit in re.findall(r"1 << (\d)", code))
        if "~" in code:
            taken |= {label.removeprefix("MAV_CMD_"): bits for label in labels}
    return taken
