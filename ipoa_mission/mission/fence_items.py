"""Geofence and rally points as items (mission types 1 and 2)."""

import math
from collections.abc import Sequence

from ipoa_mission.autopilot.commands import Command, Frame, command_name
from ipoa_mission.errors import MissionError
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item

#: Command: stay inside.
POLYGON = {Command.NAV_FENCE_POLYGON_VERTEX_INCLUSION: True, Command.NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False}
CIRCLE = {Command.NAV_FENCE_CIRCLE_INCLUSION: True, Command.NAV_FENCE_CIRCLE_EXCLUSION: False}


def fence_to_wire(fence: Sequence[FencePolygon | FenceCircle]) -> tuple[Item, ...]:
    return tuple(item for part in fence for item in _fence_part(part))


def fence_from_wire(items: Sequence[Item]) -> tuple[FencePolygon | FenceCircle, ...]:
    """Return the fence without ArduPilot's return point (5000)."""
    fence: list[FencePolygon | FenceCircle] = []
    at = 0
    while at < len(items):
        item = items[at]
        if item.command in POLYGON:
            count = int(item.params[0]) if math.isfinite(item.params[0]) else 0
            if count < 3:
                words = f"expected a polygon of 3 vertices or more, not {item.params[0]:g}"
                raise MissionError(words, code="fence-broken", place=f"fence item {at + 1}")
            ring = items[at : at + count]
            if len(ring) < count or any((v.command, v.params[0]) != (item.command, item.params[0]) for v in ring):
                words = f"expected a polygon of {count} vertices, but the list ends before"
                raise MissionError(words, code="fence-broken", place=f"fence item {at + 1}")
            vertices = tuple((v.latitude_deg, v.longitude_deg) for v in ring)
            fence.append(FencePolygon(vertices, POLYGON[Command(item.command)]))
            at += count
            continue
        if item.command in CIRCLE:
            center = (item.latitude_deg, item.longitude_deg)
            fence.append(FenceCircle(center, item.params[0], CIRCLE[Command(item.command)]))
        elif item.command != Command.NAV_FENCE_RETURN_POINT:
            words = f"expected a fence, not {command_name(item.command)}"
            raise MissionError(words, code="not-a-mission-item", place=f"fence item {at + 1}")
        at += 1
    return tuple(fence)


def rally_to_wire(rally: Sequence[Geodetic]) -> tuple[Item, ...]:
    kind = Command.NAV_RALLY_POINT, Frame.GLOBAL_RELATIVE_ALT, (0.0,) * 4
    return tuple(Item(*kind, place.latitude_deg, place.longitude_deg, place.altitude) for place in rally)


def rally_from_wire(items: Sequence[Item]) -> tuple[Geodetic, ...]:
    for at, item in enumerate(items, 1):
        if item.command != Command.NAV_RALLY_POINT:
            words = f"expected a rally point, not {command_name(item.command)}"
            raise MissionError(words, code="not-a-mission-item", place=f"rally item {at}")
    return tuple(Geodetic(item.latitude_deg, item.longitude_deg, item.altitude) for item in items)


def _fence_part(part: FencePolygon | FenceCircle) -> list[Item]:
    match part:
        case FencePolygon(vertices, inclusion):
            command = next(c for c, inside in POLYGON.items() if inside == inclusion)
            count = float(len(vertices))
            return [Item(command, Frame.GLOBAL, (count, 0.0, 0.0, 0.0), lat, lon) for lat, lon in vertices]
        case FenceCircle((lat, lon), radius, inclusion):
            command = next(c for c, inside in CIRCLE.items() if inside == inclusion)
            return [Item(command, Frame.GLOBAL, (radius, 0.0, 0.0, 0.0), lat, lon)]
