"""Obstacles and ground as polygons, which is what a picture is made of."""

from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere

CIRCLE = 32  # corners of a drawn circle

Plane = NDArray[np.float64]  # (n, 2) east, north [m]


def outline(obstacle: Obstacle) -> tuple[Plane, ...]:
    """Rings of the ground plan, each (n, 2) and open: the outer one, then the holes."""
    match obstacle:
        case Prism():
            return tuple(np.asarray(ring, float) for ring in (obstacle.outer, *obstacle.holes))
        case Cylinder():
            return (_circle(obstacle.east, obstacle.north, obstacle.radius),)
        case Sphere():
            return (_circle(*obstacle.center[:2], obstacle.radius),)
        case _:
            (e0, n0, _), (e1, n1, _) = obstacle.bounds
            return (np.array([(e0, n0), (e1, n0), (e1, n1), (e0, n1)]),)


def tiles(obstacle: Obstacle, size: float) -> list[Points]:
    """The surface without its underside as flat polygons (n, 3), cut so that few are larger than `size` [m].

    Small polygons can be painted from the far ones to the near ones without knowing which hides which.
    """
    if isinstance(obstacle, Sphere):
        return _facets(obstacle)
    base, top = obstacle.bounds[:, 2]
    rings = outline(obstacle)
    roof = [_raised(part, top) for part in _diced(rings, size)]
    return roof + [tile for ring in rings for tile in _walls(ring, base, top, size)]


def edges(obstacle: Obstacle) -> list[Points]:
    """The lines that a draughtsman would draw, each (n, 3): roof, foot and the corners between; none on a sphere."""
    if isinstance(obstacle, Sphere):
        return []
    base, top = obstacle.bounds[:, 2]
    rings = outline(obstacle)
    level = [_raised(np.vstack([ring, ring[:1]]), up) for ring in rings for up in (base, top)]
    if isinstance(obstacle, Cylinder):
        return level
    return level + [np.array([(e, n, base), (e, n, top)]) for ring in rings for e, n in ring]


def silhouette(obstacle: Obstacle, axis: int) -> Plane:
    """Its shadow on the upright plane through `axis` (0: east, 1: north) and up, (n, 2): what a front view shows."""
    if isinstance(obstacle, Sphere):
        return _circle(obstacle.center[axis], obstacle.center[2], obstacle.radius)
    (low, base), (high, top) = obstacle.bounds[:, [axis, 2]]
    return np.array([(low, base), (high, base), (high, top), (low, top)])


def ground_mesh(airspace: Airspace, across: int) -> tuple[Plane, Plane, Plane]:
    """East, north and height of the ground at the nodes of a grid over the bounds, each (rows, columns) [m].

    `across` cells on the longer side, and square ones.
    """
    return ground_mesh_over(airspace, airspace.bounds.lower[:2], airspace.bounds.upper[:2], across)


def ground_mesh_over(
    airspace: Airspace, lower: tuple[float, float], upper: tuple[float, float], across: int
) -> tuple[Plane, Plane, Plane]:
    """The same over another rectangle, from `lower` to `upper` (east, north)."""
    sides = np.subtract(upper, lower)
    counts = np.maximum(np.rint(sides / sides.max() * across), 1).astype(int) + 1
    east, north = np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts, strict=True)))
    up = airspace.ground(np.column_stack([east.ravel(), north.ravel()]))
    return east, north, up.reshape(east.shape)


def _circle(x: float, y: float, radius: float) -> Plane:
    turn = np.arange(CIRCLE) * 2 * np.pi / CIRCLE
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


def _raised(ring: Plane, up: float) -> Points:
    return np.column_stack([ring, np.full(len(ring), up)])


def _walls(ring: Plane, base: float, top: float, size: float) -> list[Points]:
    found = []
    for a, b in pairwise(np.vstack([ring, ring[:1]])):
        along = a + np.linspace(0, 1, _pieces(float(np.linalg.norm(b - a)), size) + 1)[:, None] * (b - a)
        for low, high in pairwise(np.linspace(base, top, _pieces(top - base, size) + 1)):
            found += [np.array([(*p, low), (*q, low), (*q, high), (*p, high)]) for p, q in pairwise(along)]
    return found


def _diced(rings: tuple[Plane, ...], size: float) -> list[Plane]:
    """A polygon with holes cut along a grid, each part one ring."""
    plan = shapely.Polygon(rings[0], rings[1:])
    (west, south), (east, north) = rings[0].min(axis=0), rings[0].max(axis=0)
    columns, rows = (np.linspace(a, b, _pieces(b - a, size) + 1) for a, b in ((west, east), (south, north)))
    cells = [shapely.box(w, s, e, n) for w, e in pairwise(columns) for s, n in pairwise(rows)]
    parts = shapely.get_parts(shapely.intersection(plan, cells))
    areas = [part for part in parts if isinstance(part, shapely.Polygon) and not part.is_empty]
    return [_keyholed(tuple(np.asarray(r.coords)[:-1] for r in (p.exterior, *p.interiors))) for p in areas]


def _pieces(length: float, size: float) -> int:
    return max(1, int(np.ceil(length / size)))


def _keyholed(rings: tuple[Plane, ...]) -> Plane:
    """One ring for a polygon with holes: the pen goes to each hole, round it, and back the same way.

    Outer ring counterclockwise and holes clockwise, so that a filling by winding number leaves the holes open too.
    """
    outer = _turned(rings[0], left=True)
    for hole in (_turned(ring, left=False) for ring in rings[1:]):
        gaps = np.linalg.norm(outer[:, None] - hole, axis=2)
        i, j = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
        outer = np.vstack([outer[: i + 1], hole[j:], hole[: j + 1], outer[i:]])
    return outer


def _turned(ring: Plane, left: bool) -> Plane:
    after = np.roll(ring, -1, axis=0)
    area = float((ring[:, 0] * after[:, 1] - after[:, 0] * ring[:, 1]).sum())
    return ring if (area > 0) == left else ring[::-1]


def _facets(sphere: Sphere) -> list[Points]:
    around = np.arange(CIRCLE + 1) * 2 * np.pi / CIRCLE
    height = np.linspace(-np.pi / 2, np.pi / 2, CIRCLE // 2 + 1)
    turn, rise = np.meshgrid(around, height)
    unit = np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=-1)
    nodes = np.asarray(sphere.center) + sphere.radius * unit
    return [nodes[[i, i, i + 1, i + 1], [j, j + 1, j + 1, j]] for i in range(len(height) - 1) for j in range(CIRCLE)]
