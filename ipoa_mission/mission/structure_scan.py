"""Lay out structure scans as QGroundControl does, which does not store their waypoints."""

import math

import numpy as np

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Item, camera_trigger, waypoint
from ipoa_mission.mission.json_node import Node
from ipoa_mission.world.frame import Geodetic, SphericalPlane

MOST_LAYERS = 200
LATERAL_YAW = 90.0  # [deg], relative to the next waypoint
SHORTEST_SIDE = 1e-3  # [m]


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
    top, bottom = (node[name].length() for name in ("StructureHeight", "ScanBottomAlt"))
    if not (ratio := (top - bottom) / height) <= MOST_LAYERS:
        raise node["StructureHeight"].wrong(f"a structure of at most {MOST_LAYERS} layers")
    layers = max(math.ceil(ratio), 1)
    descends = node["StartFromTop"].flag()
    first = top - height / 2 if descends else bottom + height / 2
    entrance, pitch = node["EntranceAltitude"].length(), node["GimbalPitch"].number("degrees")
    spacing = camera["AdjustedFootprintSide"].length()
    places = _round(node["polygon"], camera["DistanceToSurface"].length())
    aim = Item(Command.DO_SET_ROI_WPNEXT_OFFSET, Frame.MISSION, (0.0, 0.0, 0.0, 0.0), pitch, 0.0, LATERAL_YAW)
    items = [waypoint(places[0], entrance), aim]
    for n in range(layers):
        up = first + n * (-height if descends else height)
        begin, *others = (waypoint(place, up) for place in (*places, places[0]))
        items += [begin, camera_trigger(spacing), *others, camera_trigger(0.0, at_once=False)]
    node.note(f"it holds no waypoints: {layers} rounds are laid out as QGroundControl does")
    items += [Item(Command.DO_SET_ROI_NONE, Frame.MISSION), waypoint(places[0], entrance)]
    return items, max(top - bottom, 0.0)


def _round(polygon: Node, distance: float) -> list[Geodetic]:
    """Clockwise from the polygon's first corner."""
    from shapely import Polygon  # slow to import

    corners = polygon.corners(3)
    about = SphericalPlane(*corners[0].tolist())
    plane = about.to_plane(*corners.T)
    if _area(plane) > 0:
        plane = plane[::-1]
    forth = np.roll(plane, -1, axis=0) - plane
    sides = np.linalg.norm(forth, axis=1)
    if not (sides > SHORTEST_SIDE).all() or _area(plane) == 0:
        raise polygon.wrong("a polygon with an area and distinct corners")
    forth /= sides[:, None]
    found = np.array([_corner(plane[n], forth[n - 1], forth[n], distance) for n in range(len(plane))])
    ahead = ((np.roll(found, -1, axis=0) - found) * forth).sum(axis=1)
    if not (np.isfinite(found).all() and (ahead > SHORTEST_SIDE).all() and Polygon(found).is_valid):
        words = f"expected a round with room for each side at {distance:g} m from the structure"
        raise BadInput(
            words, hint="give the structure fewer corners, or scan it from a shorter distance", place=polygon.where
        )
    latitude, longitude = about.to_geodetic(*found.T)
    return [Geodetic(float(lat), float(lon)) for lat, lon in zip(latitude, longitude, strict=True)]


def _area(plane: Points) -> float:
    """Twice the area [m^2], positive counter-clockwise."""
    x, y = plane.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _corner(corner: Points, into: Points, out: Points, distance: float) -> Points:
    """Return the corner of a clockwise polygon, its sides moved outwards by `distance` [m]."""
    left, next_left = np.array([-into[1], into[0]]), np.array([-out[1], out[0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(corner + distance * (left + next_left) / (1.0 + float(left @ next_left)))
