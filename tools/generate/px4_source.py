"""Read PX4's source (mavlink_mission): which mission items it takes and stores, and which params 1.18 refuses."""

import re
from collections.abc import Mapping
from typing import Any

from ipoa_mission.autopilot.commands import Command, command_name
from tools.generate.sources import Source, block, body, cases, listed, numbers

CODE, MASKS = "src/modules/mavlink/mavlink_mission.cpp", "src/modules/mavlink/mavlink_command_params.hpp"
NAMES = "src/modules/navigator/navigation.h"
FEASIBLE = "src/modules/navigator/MissionFeasibility/FeasibilityChecker.cpp"
MULTICOPTER = "VEHICLE_MC"
FRAMES = (0, 2, 3, 5, 6)


def facts(source: Source) -> dict[str, Any]:
    """Return a commit's table: read-back, frames, ROI modes, commands never flown, used params."""
    text, own = source.text(CODE), numbers(source.text(NAMES))
    parse, answer = (body(text, f"MavlinkMissionManager::{name}(") for name in _FUNCTIONS)
    placed, plain = (_taken(code, own) for code in _switches(parse, "mavlink_mission_item->command"))
    elsewhere = re.findall(r"nav_cmd == MAV_CMD_(NAV_\w+)", body(text, _HANDLER).partition("check_failed = true")[0])
    read_back = _taken(_switches(answer, "mission_item->nav_cmd")[-1], own)
    rows = {name: _placed_row(code, read_back.get(name, "")) for name, code in placed.items() if name not in elsewhere}
    flown = re.findall(
        r"!= (NAV_CMD_\w+)", body(source.text(FEASIBLE), "FeasibilityChecker::checkMissionItemValidity(")
    )
    renames = {"NAV_ROI": "DO_SET_ROI"} | _renamed(plain)
    names = {renames.get(name, name): name for name in (*rows, *plain)}
    return {
        "frames": listed(FRAMES),
        "placed": rows,
        "plain": {name: "ww....." if name == "DO_JUMP" else "......." for name in plain},
        "roi": {"placed": listed((0, 3)), "plain": listed((0, 1, 2))},
        "renames": renames,
        "never_flown": " ".join(sorted(names.keys() - {_name(word, own) for word in flown})),
    } | _used(source.text(MASKS))


_FUNCTIONS = ("parse_mavlink_mission_item", "format_mavlink_mission_item")
_HANDLER = "MavlinkMissionManager::handle_mission_item_both("  # lists the commands of other lists


def _switches(function: str, on: str) -> list[str]:
    return [block(function, match.end() - 1) for match in re.finditer(rf"switch \({re.escape(on)}\) \{{", function)]


def _taken(switch: str, own: Mapping[str, int]) -> dict[str, str]:
    return {_name(label, own): code for labels, code in cases(switch) for label in labels if label != "default"}


def _name(label: str, own: Mapping[str, int]) -> str:
    """Return MAVLink's name of a command that PX4 calls `label`, or by its own name."""
    return command_name(own[label]) if label in own else label.removeprefix("MAV_CMD_")


def _placed_row(code: str, answer: str) -> str:
    """Return seven letters for a command with a place: the member of each param, if a download reports it."""
    row = ["-"] * 4
    for member, value in re.findall(r"mission_item->(\w+)\s*=\s*([^;]+);", code):
        slot = re.search(r"mavlink_mission_item->param(\d)", value)
        back = slot and re.search(rf"mavlink_mission_item->param{slot[1]}\s*=\s*([^;]+);", answer)
        if slot and back and member in back[1]:
            row[int(slot[1]) - 1] = "b" if "> 0" in value else _LETTERS.get(member, ".")
    return "".join(row) + "dd."


_LETTERS = {"yaw": "y", "land_precision": "w"}


def _renamed(plain: Mapping[str, str]) -> dict[str, str]:
    """Return commands without a place that are stored under another number."""
    return {"CONDITION_DELAY": "NAV_DELAY"} if "NAV_CMD_DELAY" in plain.get("CONDITION_DELAY", "") else {}


def _used(text: str) -> dict[str, dict[str, str]]:
    """Return the usable params of each command on a multicopter; empty if all are."""
    if not text:
        return {}
    masks = {int(command): int(mask, 16) for command, mask in re.findall(r"\{\s*(\d+),\s*(0x\w\w),", text)}
    for command, types, mask in re.findall(r"\{\s*(\d+),\s*(VEHICLE[\w |]*),\s*(0x\w\w),", text):
        if MULTICOPTER in types:
            masks[int(command)] |= int(mask, 16)
    taken = {command: listed(n + 1 for n in range(7) if mask >> n & 1) for command, mask in masks.items()}
    names = {command: Command(command).name if command in set(Command) else str(command) for command in taken}
    return {"used": {names[command]: slots for command, slots in taken.items()}}
