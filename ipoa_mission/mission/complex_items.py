"""QGroundControl's complex items (surveys, scans).

One is written back only with exactly its items in a row, and no jump into them. `lay_out` makes the waypoints of a
structure scan.
"""

import json
import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NoReturn

import numpy as np

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, SphericalPlane
from ipoa_mission.geometry import Plane, Vector
from ipoa_mission.mission.items import ComplexItem, Item, camera_trigger, waypoint
from ipoa_mission.mission.json_node import Node

TRANSECTS = "TransectStyleComplexItem"
ITEMS = "Items"
MAX_LAYERS = 200
MIN_SIDE = 1e-3  # [m]


def complex_item(items: Sequence[Item], document: Any) -> ComplexItem:
    kept = dict(document)
    has_items = isinstance(kept.get(TRANSECTS), dict) and ITEMS in kept[TRANSECTS]
    if has_items:
        kept[TRANSECTS] = {key: value for key, value in kept[TRANSECTS].items() if key != ITEMS}
    return ComplexItem(tuple(items), json.dumps(kept, sort_keys=True), has_items)


def complex_items_in(parts: Sequence[Node | None], items: Sequence[Item]) -> tuple[ComplexItem, ...]:
    groups: dict[str, tuple[Node, list[Item]]] = {}
    for part, item in zip(parts, items, strict=True):
        if part is not None:
            groups.setdefault(part.place, (part, []))[1].append(item)
    return tuple(complex_item(part_items, part.value) for part, part_items in groups.values())


def entries(items: Sequence[Item], complexes: Sequence[ComplexItem]) -> Iterator[tuple[range, ComplexItem | None]]:
    """Yield the index of each plain item, and the indices of each complex item's items."""
    targets = {int(item.params[0]) - 1 for item in items if item.command == Command.DO_JUMP}
    first = 0
    while first < len(items):
        of = next((each for each in complexes if _is_here(each, items, first, targets)), None)
        end = first + (1 if of is None else len(of.items))
        yield range(first, end), of
        first = end


def _is_here(part: ComplexItem, items: Sequence[Item], first: int, targets: set[int]) -> bool:
    end = first + len(part.items)
    if not part.items or items[first].command != part.items[0].command or end > len(items):
        return False
    is_same = repr(tuple(items[first:end])) == repr(part.items)  # repr: NaN equals NaN
    return is_same and targets.isdisjoint(range(first, end))


def as_document(part: ComplexItem, number: int, simple: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """`simple` are its items; the first is mission item `number`."""
    document: dict[str, Any] = json.loads(part.json_text, parse_constant=partial(_refuse_constant, number))
    if part.has_items:
        keys = ("autoContinue", "command", "frame", "params", "type")
        document[TRANSECTS][ITEMS] = [
            {key: item[key] for key in keys} | {"doJumpId": number + n} for n, item in enumerate(simple)
        ]
    return document


def _refuse_constant(number: int, name: str) -> NoReturn:
    raise BadInput(f"expected finite numbers, not {name}", place=f"complex item at item {number}")


def lay_out(node: Node) -> tuple[list[Item], float]:
    """Return the items and the height from bottom to top [m]."""
    name = node["complexItemType"].text()
    if name != "StructureScan":
        raise BadInput(
            f'expected the waypoints of the complex item "{name}", but it holds none',
            place=node.where,
            hint="open the plan in QGroundControl and save it to write the waypoints",
        )
    camera = node["CameraCalc"]
    layer = camera["AdjustedFootprintFrontal"]
    height = layer.length()
    if height <= 0:
        raise layer.wrong("more than 0 m, the height of a layer")
    top = node["StructureHeight"].length()
    bottom = node["ScanBottomAlt"].length()
    ratio = (top - bottom) / height
    if not ratio <= MAX_LAYERS:
        raise node["StructureHeight"].wrong(f"a structure of at most {MAX_LAYERS} layers")
    layers = max(math.ceil(ratio), 1)
    descends = node["StartFromTop"].flag()
    first = top - height / 2 if descends else bottom + height / 2
    entrance = node["EntranceAltitude"].length()
    pitch = node["GimbalPitch"].number("degrees")
    spacing = camera["AdjustedFootprintSide"].length()
    places = _round(node["polygon"], camera["DistanceToSurface"].length())
    lateral_yaw = 90.0  # [deg], relative to the next waypoint
    aim = Item(Command.DO_SET_ROI_WPNEXT_OFFSET, Frame.MISSION, (0.0, 0.0, 0.0, 0.0), pitch, 0.0, lateral_yaw)
    items = [waypoint(places[0], entrance), aim]
    for n in range(layers):
        up = first + n * (-height if descends else height)
        begin, *corners = (waypoint(place, up) for place in (*places, places[0]))
        items += [begin, camera_trigger(spacing), *corners, camera_trigger(0.0, at_once=False)]
    node.note(f"it holds no waypoints: {layers} rounds are laid out as QGroundControl does")
    items += [Item(Command.DO_SET_ROI_NONE, Frame.MISSION), waypoint(places[0], entrance)]
    return items, max(top - bottom, 0.0)


def _round(polygon: Node, distance: float) -> list[Geodetic]:
    """Return corners clockwise, from the polygon's first."""
    from shapely import Polygon  # slow to import

    places = [place.array(2, "numbers (latitude, longitude)") for place in polygon.array()]
    corners = np.array([[value.number("degrees") for value in place] for place in places]).reshape(-1, 2)
    if len(corners) < 3 or (np.abs(corners) > (90.0, 180.0)).any():
        raise polygon.wrong("3 corners or more, as latitude and longitude in degrees")
    if np.ptp(corners, axis=0).max() > 1.0:
        raise polygon.wrong("corners within a degree of each other")
    frame = SphericalPlane(*corners[0].tolist())
    plane = frame.to_plane(*corners.T)
    if _area(plane) > 0:
        plane = plane[::-1]
    forth = np.roll(plane, -1, axis=0) - plane
    sides = np.linalg.norm(forth, axis=1)
    if not (sides > MIN_SIDE).all() or _area(plane) == 0:
        raise polygon.wrong("a polygon with an area and distinct corners")
    forth /= sides[:, None]
    ring = np.array([_corner(plane[n], forth[n - 1], forth[n], distance) for n in range(len(plane))])
    ahead = ((np.roll(ring, -1, axis=0) - ring) * forth).sum(axis=1)
    if not (np.isfinite(ring).all() and (ahead > MIN_SIDE).all() and Polygon(ring).is_valid):
        words = f"expected a round with room for each side at {distance:g} m from the structure"
        hint = "give the structure fewer corners, or scan it from a shorter distance"
        raise BadInput(words, hint=hint, place=polygon.where)
    latitude, longitude = frame.to_geodetic(*ring.T)
    return [Geodetic(float(lat), float(lon)) for lat, lon in zip(latitude, longitude, strict=True)]


def _area(plane: Plane) -> float:
    """Return twice the area [m^2], positive counter-clockwise."""
    x, y = plane.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _corner(corner: Vector, into: Vector, out: Vector, distance: float) -> Vector:
    """Return the corner of a clockwise polygon, its sides moved outwards by `distance` [m]."""
    left = np.array([-into[1], into[0]])
    next_left = np.array([-out[1], out[0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(corner + distance * (left + next_left) / (1.0 + float(left @ next_left)))
