"""PX4's mission from navigator_mission_item: each item when the flight reaches it.

An item may come in steps, as NAV_TAKEOFF and NAV_WAYPOINT. Places are in single precision: 0.4 m.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ipoa_mission.autopilot.commands import FLOWN_TO, TAKEOFFS, Command, Frame
from ipoa_mission.logs.logged import Begun
from ipoa_mission.mission.items import Item


def items_begun(topic: Any | None, result: Any | None) -> Iterator[tuple[float, Begun]]:
    """Return each item at its first time [s], steps joined."""
    if topic is None or result is None:
        return
    rounds = np.asarray(topic["instance_count"]) if "instance_count" in topic else np.zeros(len(topic["timestamp"]))
    for instance in np.unique(rounds):
        first_seen: dict[int, tuple[float, Item]] = {}
        for n in np.flatnonzero(rounds == instance):
            item, seq, time = (
                _item(topic, int(n)),
                int(topic["sequence_current"][n]),
                float(topic["timestamp"][n]) / 1e6,
            )
            if item.command:
                since, before = first_seen.get(seq, (time, item))
                first_seen[seq] = since, _joined(before, item)
        for seq, (time, item) in first_seen.items():
            total = _total(result, time)
            if seq < total:
                yield time, Begun(seq, total, item)


def _joined(before: Item, item: Item) -> Item:
    if before.command in TAKEOFFS and item.command == Command.NAV_WAYPOINT:
        place = (item.latitude_deg, item.longitude_deg, item.altitude)
        return Item(before.command, item.frame, before.params, *place)
    return before if item.command == Command.NAV_WAYPOINT else item


def _item(topic: Any, n: int) -> Item:
    command = int(topic["nav_cmd"][n])
    hold, radius, third, yaw, latitude, longitude, altitude = (
        float(topic[name][n])
        for name in ("time_inside", "acceptance_radius", "loiter_radius", "yaw", "latitude", "longitude", "altitude")
    )
    if command not in FLOWN_TO:
        return Item(command, Frame.MISSION, (hold, radius, third, math.nan))
    frame = Frame.GLOBAL_RELATIVE_ALT if topic["altitude_is_relative"][n] else Frame.GLOBAL
    return Item(command, frame, (hold, radius, third, math.degrees(yaw)), latitude, longitude, altitude)


def _total(result: Any, time: float) -> int:
    at = np.searchsorted(np.asarray(result["timestamp"], float) / 1e6, time, side="right")
    return int(result["seq_total"][min(max(int(at), 0), len(result["seq_total"]) - 1)])
