from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

import numpy as np
import shapely

from ipoa_mission.maps.feature import Corners


def sound_polygons(rings_of: Sequence[Any], to_degrees: Callable[[Corners], Corners]) -> list[Any]:
    """Build many polygons at once; None needs a separate check.

    That is: no rings, one whose first three corners are not all different, or corners not on Earth.
    """
    made: list[Any] = [None] * len(rings_of)
    taken = [i for i, rings in enumerate(rings_of) if _looks_sound(rings)]
    rings = [ring for i in taken for ring in rings_of[i]]
    if not rings:
        return made
    try:
        of_position = set(map(len, chain.from_iterable(rings)))  # some may have a height
        numbers = np.fromiter(chain.from_iterable(chain.from_iterable(rings)), float)
    except (TypeError, ValueError, KeyError, OverflowError):
        return made
    if len(of_position) != 1 or min(of_position) < 2:
        return made
    corners = numbers.reshape(-1, min(of_position))[:, :2]
    if not np.isfinite(corners).all():
        return made
    corners = to_degrees(corners)
    lengths = np.array([len(ring) for ring in rings])
    first = np.cumsum(lengths) - lengths
    a, b, c = corners[first], corners[first + 1], corners[first + 2]
    sound = (a != b).any(axis=1) & (b != c).any(axis=1) & (a != c).any(axis=1)
    sound &= np.logical_and.reduceat((np.abs(corners) <= (360.0, 90.0)).all(axis=1), first)
    owner = np.repeat(np.arange(len(taken)), [len(rings_of[i]) for i in taken])
    whole = np.bincount(owner[~sound], minlength=len(taken)) == 0
    kept = whole[owner]
    of_ring = np.repeat(np.arange(int(kept.sum())), lengths[kept])
    lines = shapely.linearrings(corners[np.repeat(kept, lengths)], indices=of_ring)
    number = np.cumsum(whole) - 1
    polygons = shapely.polygons(lines, indices=number[owner[kept]])
    for i, polygon in zip(np.flatnonzero(whole).tolist(), polygons.tolist(), strict=True):
        made[taken[i]] = polygon
    return made


def _looks_sound(rings: Any) -> bool:
    return isinstance(rings, list) and bool(rings) and all(isinstance(ring, list) and len(ring) > 2 for ring in rings)
