"""How much of a photo its neighbors show too: of the lines as they lie, not as they were asked for.

Counted on the highest ground that a photo shows, from the least height above it: all else is seen wider.
"""

from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
import shapely

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.tour import Swath, Tour

PARALLEL_DEG = 1.0
SAME_LINE = 0.05  # of the spacing: pieces that lie so near to each other, across, are of one line
MOST_PLACES = 20_000
ROUNDING = 1e-6  # [m]


@dataclass(frozen=True)
class Overlap:
    """The smallest overlaps, as shares of a photo; `side` is None where no line has a neighbor, `place` is of that."""

    front: float
    side: float | None
    place: tuple[float, float] | None


def least_overlap(tour: Tour, sight: Sight, free: Any) -> Overlap | None:
    """The smallest overlap of photos along the lines, and of those on neighboring ones; None without a camera.

    A line's neighbors are those beside it, up to a photo's width away, with nothing between but what is to be seen and
    may be flown over, `free`; where there is none the area ends, or there is a gap, which `coverage` tells.
    """
    if sight.trigger is None or not tour.swaths:
        return None
    apart = [sight.triggering(swath.length) for swath in tour.swaths]
    farthest = max((distance + 2 * sight.lag for distance, count in apart if count > 1), default=0.0)
    side, place = _beside(tour.swaths, sight, free)
    return Overlap(
        front=1.0 - farthest / sight.along,
        side=None if side is None else 1.0 - side / sight.across,
        place=place,
    )


def photo_places(swath: Swath, sight: Sight) -> Points:
    """Where photos are taken along a line, (n, 2); none without a camera."""
    distance, count = sight.triggering(swath.length)
    ahead = (swath.end - swath.begin) / max(swath.length, 1e-9)
    return np.asarray(swath.begin + np.arange(count)[:, None] * (distance + sight.lag) * ahead)


def _beside(swaths: tuple[Swath, ...], sight: Sight, free: Any) -> tuple[float | None, tuple[float, float] | None]:
    """The farthest that a neighboring line is, and from where."""
    begins, ends = (np.array([getattr(swath, what) for swath in swaths]) for what in ("begin", "end"))
    lengths = np.linalg.norm(ends - begins, axis=1)
    ahead = (ends - begins) / np.maximum(lengths, 1e-9)[:, None]
    places, line = _along(swaths, sight.spacing)
    nearest = np.zeros((2, len(places), 2))  # the way to it, on the left and on the right
    shortest = np.full((2, len(places)), np.inf)
    for n in np.flatnonzero(lengths > 0):
        away = places - begins[n]
        along, across = away @ ahead[n], away @ np.array([-ahead[n][1], ahead[n][0]])
        sense = ahead[line] @ ahead[n]
        is_beside = (along >= 0) & (along <= lengths[n]) & (np.abs(sense) > np.cos(np.radians(PARALLEL_DEG)))
        is_beside &= (np.abs(across) > SAME_LINE * sight.spacing) & (np.abs(across) < sight.across)
        left = across * np.sign(sense) < 0  # as seen from the place, along its own line
        for side, on_it in enumerate((is_beside & left, is_beside & ~left)):
            nearer = on_it & (np.abs(across) < shortest[side])
            shortest[side, nearer] = np.abs(across[nearer])
            nearest[side, nearer] = -across[nearer, None] * [-ahead[n][1], ahead[n][0]]
    far = (shortest > sight.spacing + ROUNDING) & np.isfinite(shortest)
    shapely.prepare(free)
    for side in (0, 1):
        at = np.flatnonzero(far[side])
        ways = shapely.linestrings(np.stack([places[at], places[at] + nearest[side, at]], axis=1))
        shortest[side, at[~shapely.covers(free, ways)]] = np.inf
    found = np.where(np.isfinite(shortest), shortest, -1.0).max(axis=0, initial=-1.0)
    if not len(found) or found.max() < 0:
        return None, None
    worst = int(found.argmax())
    east, north = places[worst].tolist()
    return float(found[worst]), (east, north)


def _along(swaths: tuple[Swath, ...], step: float) -> tuple[Points, Vector]:
    """Places along lines, and of which each is."""
    whole = sum(swath.length for swath in swaths)
    step = max(step, whole / MOST_PLACES)
    counts = [max(int(swath.length / step), 1) for swath in swaths]
    shares = (np.linspace(0.0, 1.0, count + 2)[1:-1, None] for count in counts)
    places = [swath.begin + share * (swath.end - swath.begin) for swath, share in zip(swaths, shares, strict=True)]
    numbers = np.fromiter(chain.from_iterable([n] * count for n, count in enumerate(counts)), int)
    return np.concatenate(places), numbers
