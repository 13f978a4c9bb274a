"""Surfaces cut into flat polygons, which is what a picture is made of."""

from itertools import pairwise

import numpy as np
import shapely

from ipoa_mission.geometry import Points
from ipoa_mission.world.polygon import Plane

CIRCLE = 32  # corners of a drawn circle


def circle(x: float, y: float, radius: float) -> Plane:
    """A circle round (x, y) as a ring, (32, 2)."""
    turn = np.arange(CIRCLE) * 2 * np.pi / CIRCLE
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


def raised(ring: Plane, up: float) -> Points:
    """A ring (n, 2) at a height, (n, 3)."""
    return np.column_stack([ring, np.full(len(ring), up)])


def roof(rings: tuple[Plane, ...], top: float, size: float) -> list[Points]:
    """A flat roof on rings, the outer one first, in tiles of up to `size` [m]."""
    return [raised(part, top) for part in _diced(rings, size)]


def walls(ring: Plane, base: float, top: float, size: float) -> list[Points]:
    """The walls over a ring (n, 2) in tiles of up to `size` [m]."""
    tiles = []
    for a, b in pairwise(np.vstack([ring, ring[:1]])):
        along = a + np.linspace(0, 1, _pieces(float(np.linalg.norm(b - a)), size) + 1)[:, None] * (b - a)
        for low, high in pairwise(np.linspace(base, top, _pieces(top - base, size) + 1)):
            tiles += [np.array([(*p, low), (*q, low), (*q, high), (*p, high)]) for p, q in pairwise(along)]
    return tiles


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
