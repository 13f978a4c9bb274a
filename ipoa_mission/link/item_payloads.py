"""Lists as MISSION_ITEM_INT payloads, as in ArduPilot's mission file."""

import math
import struct
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import PLAIN_FRAME
from ipoa_mission.errors import BadInput
from ipoa_mission.link.wire import GLOBAL_FRAMES, INT32_MAX, coordinate, degrees, scale
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import Difference, compare, first_number

SINGLE_MAX = float(np.finfo(np.float32).max)
PAYLOAD = np.dtype(
    [
        ("params", "<f4", 4),
        ("x", "<i4"),
        ("y", "<i4"),
        ("z", "<f4"),
        ("seq", "<u2"),
        ("command", "<u2"),
        ("target", "u1", 2),
        ("frame", "u1"),
        ("current", "u1"),
        ("autocontinue", "u1"),
        ("mission_type", "u1"),
    ]
)
#: Scale of a coordinate by frame, and the frame without its `_INT`.
_SCALES = np.array([scale(frame) for frame in range(256)], float)
_PLAIN = np.array([PLAIN_FRAME.get(frame, frame) for frame in range(256)], np.uint8)

Payloads = NDArray[np.void]


def pack_items(items: Sequence[Item], kind: int, first: int = 1) -> Payloads:
    """Return payloads, shape (items,), for target (0, 0); BadInput, where they do not fit, counts from `first`."""
    packed = np.zeros(len(items), PAYLOAD)
    if not items:
        return packed
    if len(items) > 0xFFFF:
        raise BadInput(f"expected {0xFFFF} items at most, as many as MAVLink can count, not {len(items)}")
    if any(not (0 <= item.command <= 65535 and 0 <= item.frame <= 255) for item in items):
        _refuse(items, first)
    numbers = np.array([(*item.params, item.altitude, item.latitude_deg, item.longitude_deg) for item in items], float)
    packed["command"] = [item.command for item in items]
    packed["frame"] = [item.frame for item in items]
    packed["autocontinue"] = [item.autocontinue for item in items]
    packed["seq"] = np.arange(len(items))
    packed["mission_type"] = kind
    with np.errstate(over="ignore"):
        places = np.rint(numbers[:, 5:] * _SCALES[packed["frame"], None])
    places[np.isnan(places)] = 0.0
    too_large = (np.abs(numbers[:, :5]) > SINGLE_MAX) & np.isfinite(numbers[:, :5])
    if too_large.any() or not (np.abs(places) < INT32_MAX).all():
        _refuse(items, first)
    is_global = np.isin(packed["frame"], [*GLOBAL_FRAMES])
    places[np.isnan(numbers[:, 5:]) & is_global[:, None]] = INT32_MAX
    packed["params"], packed["z"] = numbers[:, :4], numbers[:, 4]
    packed["x"], packed["y"] = places[:, 0], places[:, 1]
    return packed


def _refuse(items: Sequence[Item], first: int) -> None:
    for seq, item in enumerate(items, first):
        numbers = {f"param{i}": value for i, value in enumerate(item.params, start=1)} | {"altitude": item.altitude}
        wrong = next((name for name, value in numbers.items() if SINGLE_MAX < abs(value) < math.inf), None)
        if wrong:
            words = f"expected a number that fits in single precision, not {numbers[wrong]:g}"
            raise BadInput(words, place=f"item {seq}: {wrong}")
        if not 0 <= item.command <= 65535:
            raise BadInput(f"expected a number from 0 to 65535, not {item.command}", place=f"item {seq}: command")
        if not 0 <= item.frame <= 255:
            raise BadInput(f"expected a number from 0 to 255, not {item.frame}", place=f"item {seq}: frame")
        try:
            coordinate(item.latitude_deg, item.frame)
            coordinate(item.longitude_deg, item.frame)
        except BadInput as error:
            raise error.at(f"item {seq}") from None


def unpack_items(data: bytes) -> tuple[Item, ...]:
    rows = struct.iter_unpack("<4f2if2H6B", data)  # the fields of PAYLOAD
    return tuple(
        Item(command, frame, (p1, p2, p3, p4), degrees(x, frame), degrees(y, frame), z, bool(autocontinue))
        for p1, p2, p3, p4, x, y, z, _, command, _, _, frame, _, autocontinue, _ in rows
    )


def as_items(stored: Sequence[Item | bytes]) -> tuple[Item, ...]:
    return tuple(item if isinstance(item, Item) else unpack_items(item)[0] for item in stored)


def first_difference(
    sent: Sequence[Item], packed: Payloads, stored: Sequence[Item | bytes], autopilot: Autopilot
) -> Difference | None:
    """Return the first difference beyond the firmware's known changes; `packed` are the payloads of `sent`."""
    if len(sent) != len(stored):
        return Difference(None, "number of items", str(len(sent)), str(len(stored)))
    payloads = [n for n, payload in enumerate(stored) if isinstance(payload, bytes)]
    got = np.frombuffer(b"".join(payload for payload in stored if isinstance(payload, bytes)), PAYLOAD)
    is_same = np.zeros(len(sent), bool)
    is_same[payloads] = _same(packed[payloads], got)
    # ArduPilot's home is recognized by index 0
    compared = [n for n in range(len(sent)) if n == 0 or not is_same[n]]
    difference = compare([sent[n] for n in compared], as_items([stored[n] for n in compared]), autopilot)
    if difference is None or difference.seq is None:
        return difference
    first = first_number(sent, autopilot)
    return replace(difference, seq=compared[difference.seq - first] + first)


def _same(packed: Payloads, stored: Payloads) -> NDArray[np.bool_]:
    """Bit by bit, NaN equal to NaN, frames without `_INT`; shape (items,)."""
    same = np.ones(len(packed), bool)
    for name in ("params", "z"):
        a, b = packed[name], stored[name]
        agree = (a == b) | (np.isnan(a) & np.isnan(b))
        same &= agree.all(axis=1) if agree.ndim == 2 else agree
    for name in ("x", "y", "command", "autocontinue"):
        same &= packed[name] == stored[name]
    same &= _PLAIN[packed["frame"]] == _PLAIN[stored["frame"]]
    return same
