"""Surveys and corridor scans without their waypoints: these are laid out from the geometry, as QGroundControl does.

What its plan view lays out is a list of parallel transects in its plane about the first corner (`world.sphere`), flown
to and fro, longer by the turnaround distance at both ends; the camera is triggered by distance. A corridor that is
entered from its far end keeps the entries and exits of the near one: there the camera is off along the corridor.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipoa_mission.errors import NothingThere
from ipoa_mission.geometry import Points
from ipoa_mission.mission.commands import Command, Frame
from ipoa_mission.mission.document import Node
from ipoa_mission.mission.items import Item, camera_trigger
from ipoa_mission.mission.structure_scan import lay_out_structure
from ipoa_mission.world.sphere import SphericalPlane

LEAST_SPACING = 0.5  # transects nearer to each other are one in the middle [m]
TRANSECT_REACH = 2000.0  # the first transect would lie half of this, and of the polygon's width, from its middle [m]
MOST_TRANSECTS = 2000
SAME = 1e-6  # places nearer to each other are one [m]
STRAIGHT = 1e-9  # sine of a turn that is none
FRAMES = {1: Frame.GLOBAL_RELATIVE_ALT, 2: Frame.GLOBAL, 4: Frame.GLOBAL_TERRAIN_ALT}  # by DistanceMode
#: What needs more than the geometry: the ground, or a camera's own rules.
REFUSED = ("FollowTerrain", "HoverAndCapture", "Refly90Degrees")
TOP_RIGHT, BOTTOM_LEFT, BOTTOM_RIGHT = 1, 2, 3  # entryLocation, or EntryPoint; 0 is the top left


@dataclass(frozen=True)
class _Style:
    """What surveys and corridor scans have in common, in metres."""

    spacing: float
    trigger: float
    turnaround: float
    altitude: float
    frame: Frame
    in_turnaround: bool
    starts_at_entry: bool  # else the camera stops there, and starts at the end of a transect


def lay_out(node: Node) -> tuple[list[Item], float]:
    """The items of a complex item that holds none, and the height of what it scans from its side [m].

    Raises:
        BadInput: naming the place, where the geometry does not say enough.
    """
    name = node["complexItemType"].text()
    if name == "StructureScan":
        return lay_out_structure(node)
    if name not in ("survey", "CorridorScan") or node.get("TransectStyleComplexItem") is None:
        raise NothingThere(
            f'{node.where}: expected the waypoints of the complex item "{name}", but it holds none',
            hint="only surveys, corridor scans and structure scans can be laid out from their geometry",
        )
    starts_at_entry = _entry(node.get("EntryPoint")) not in (BOTTOM_LEFT, BOTTOM_RIGHT)
    style = _style(node["TransectStyleComplexItem"], starts_at_entry)
    corners = node["polygon" if name == "survey" else "polyline"].corners(3 if name == "survey" else 2)
    plane = SphericalPlane(*corners[0].tolist())
    places = plane.to_plane(*corners.T)
    transects = _survey(node, places, style) if name == "survey" else _corridor(node, places, style)
    flown = [transect if n % 2 == 0 else transect[::-1] for n, transect in enumerate(transects)]
    node.note(f"it holds no waypoints: {len(flown)} transects are laid out as QGroundControl does")
    if style.trigger > 0 and not starts_at_entry:
        node.note("it is entered from its far end: QGroundControl starts the camera where transects end")
    return list(_items(flown, style, plane)), 0.0


def _style(node: Node, starts_at_entry: bool) -> _Style:
    for key in REFUSED:
        if (unsupported := node.get(key)) is not None and unsupported.flag():
            raise unsupported.wrong("false in a scan that holds no waypoints", "save the plan with its waypoints")
    camera = node["CameraCalc"]
    mode = camera.get("DistanceMode")
    if mode is None:
        level = Frame.GLOBAL_RELATIVE_ALT if camera["DistanceToSurfaceRelative"].flag() else Frame.GLOBAL
    else:
        number = mode.whole("1, 2 or 4")
        if number not in FRAMES:
            raise mode.wrong("1 (above home), 2 (above sea level) or 4 (above the ground)")
        level = FRAMES[number]
    turnaround, trigger = node.get("TurnAroundDistance"), node.get("CameraTriggerInTurnAround")
    return _Style(
        spacing=camera["AdjustedFootprintSide"].length(),
        trigger=camera["AdjustedFootprintFrontal"].length(),
        turnaround=0.0 if turnaround is None else turnaround.length(),
        altitude=camera["DistanceToSurface"].number("an altitude in metres"),
        frame=level,
        in_turnaround=trigger is None or trigger.flag(),
        starts_at_entry=starts_at_entry,
    )


def _survey(node: Node, plane: Points, style: _Style) -> list[Points]:
    """The transects through a polygon, all in one direction, (k, 2) each."""
    angle = node["angle"].number("degrees")
    angle += -180.0 if angle > 90.0 else 180.0 if angle < -90.0 else 0.0
    along = np.array([math.sin(math.radians(angle)), math.cos(math.radians(angle))])
    across = np.array([along[1], -along[0]])
    low, high = plane.min(axis=0), plane.max(axis=0)
    middle, half = (low + high) / 2, (float((high - low).max()) + TRANSECT_REACH) / 2
    sides = (plane - middle) @ across
    spacing = style.spacing if style.spacing >= LEAST_SPACING else math.inf
    first, last = (math.ceil((sides.min() + half) / spacing), math.floor((sides.max() + half) / spacing))
    if last - first >= MOST_TRANSECTS:
        raise node.wrong(f"a survey of at most {MOST_TRANSECTS} transects")
    offsets = [] if math.isinf(spacing) else [n * spacing - half for n in range(first, last + 1)]
    transects = [line for offset in offsets if (line := _through(plane, middle, along, sides - offset)) is not None]
    if len(transects) < 2:
        transects = [line for line in [_through(plane, middle, along, sides)] if line is not None]
    if not transects:
        raise node["polygon"].wrong("a polygon with an area")
    forth = transects[0][1] - transects[0][0]
    transects = [line if (line[1] - line[0]) @ forth >= 0 else line[::-1] for line in transects]
    transects = _entered(transects, node.get("entryLocation"))
    alternate = node.get("flyAlternateTransects")
    if alternate is not None and alternate.flag():
        transects = transects[::2] + transects[1::2][::-1]
    return transects


def _through(plane: Points, middle: Points, along: Points, sides: Points) -> Points | None:
    """From the first to the farthest place where a line meets the polygon's edges, in their order, (2, 2).

    `sides` (n,) tell how far the corners lie on the right of the line.
    """
    met: list[float] = []
    ahead = (plane - middle) @ along
    for n in range(len(plane)):
        m = (n + 1) % len(plane)
        a, b = sides[n], sides[m]
        if a != b and min(a, b) <= 0.0 <= max(a, b):
            share = a / (a - b)
            place = float(ahead[n] + share * (ahead[m] - ahead[n]))
            met += [] if any(abs(place - other) < SAME for other in met) else [place]
    if len(met) < 2:
        return None
    ends = max(((a, b) for i, a in enumerate(met) for b in met[i + 1 :]), key=lambda pair: abs(pair[1] - pair[0]))
    level = plane[0] - along * ahead[0] - np.array([along[1], -along[0]]) * sides[0]
    return np.array([level + along * end for end in ends])


def _corridor(node: Node, plane: Points, style: _Style) -> list[Points]:
    """The transects along a polyline, from its left side to its right one, (k, 2) each."""
    width = node["CorridorWidth"].length()
    spacing = style.spacing if style.spacing >= LEAST_SPACING else math.inf
    count = max(math.ceil(width / spacing), 1) if width > 0 else 1
    if count > MOST_TRANSECTS:
        raise node["CorridorWidth"].wrong(f"a corridor of at most {MOST_TRANSECTS} transects")
    offsets = [0.0] if count == 1 else [width / 2 - (n + 0.5) * spacing for n in range(count)]
    if not (np.diff(plane, axis=0) != 0.0).any(axis=1).all():
        raise node["polyline"].wrong("a line whose corners differ")
    return _entered([_beside(plane, offset) for offset in offsets], node.get("EntryPoint"))


def _entry(node: Node | None) -> int:
    """The corner at which a scan is to begin."""
    return 0 if node is None else node.whole("0 to 3", 0, 3)


def _entered(transects: list[Points], entry: Node | None) -> list[Points]:
    """The same from the corner at which it is to begin."""
    corner = _entry(entry)
    if corner in (BOTTOM_LEFT, BOTTOM_RIGHT):
        transects = [line[::-1] for line in transects]
    return transects[::-1] if corner in (TOP_RIGHT, BOTTOM_RIGHT) else transects


def _beside(line: Points, offset: float) -> Points:
    """A polyline at a distance to the left of another, its legs met where they cross."""
    forth = np.diff(line, axis=0)
    forth /= np.linalg.norm(forth, axis=1)[:, None]
    left = np.column_stack([-forth[:, 1], forth[:, 0]])
    corners = [line[0] + offset * left[0]]
    for n in range(1, len(forth)):
        turn = float(forth[n - 1, 0] * forth[n, 1] - forth[n - 1, 1] * forth[n, 0])
        before, here = line[n - 1] + offset * left[n - 1], line[n] + offset * left[n]
        if abs(turn) < STRAIGHT:
            corners.append(here)
            continue
        reach = float((here - before)[0] * forth[n, 1] - (here - before)[1] * forth[n, 0]) / turn
        corners.append(before + reach * forth[n - 1])
    return np.array([*corners, line[-1] + offset * left[-1]])


def _items(transects: list[Points], style: _Style, plane: SphericalPlane) -> Iterator[Item]:
    """Waypoints, and the camera's trigger as it is set on the way."""
    always = style.in_turnaround and style.trigger > 0
    for n, transect in enumerate(transects):
        is_last = n == len(transects) - 1
        first, last = (_beyond(transect, style.turnaround), _beyond(transect[::-1], style.turnaround))
        if style.turnaround > 0:
            yield _waypoint(first, style, plane)
            if always and n == 0:
                yield camera_trigger(style.trigger)
        for k, place in enumerate(transect):
            yield _waypoint(place, style, plane)
            starts, stops = (k == 0, k == len(transect) - 1)[:: 1 if style.starts_at_entry else -1]
            if starts and style.trigger > 0:
                yield camera_trigger(style.trigger)
            elif stops and style.trigger > 0 and (not always or (is_last and k > 0 and style.turnaround <= 0)):
                yield camera_trigger(0.0)
        if style.turnaround > 0:
            yield _waypoint(last, style, plane)
            if always and is_last:
                yield camera_trigger(0.0)


def _beyond(transect: Points, distance: float) -> Points:
    """The place so far before the begin of a transect."""
    forth = transect[1] - transect[0]
    return np.asarray(transect[0] - distance * forth / max(float(np.linalg.norm(forth)), 1e-9))


def _waypoint(place: Points, style: _Style, plane: SphericalPlane) -> Item:
    latitude, longitude = plane.to_geodetic(place[:1], place[1:])
    params = (0.0, 0.0, 0.0, math.nan)
    return Item(Command.NAV_WAYPOINT, style.frame, params, float(latitude[0]), float(longitude[0]), style.altitude)
