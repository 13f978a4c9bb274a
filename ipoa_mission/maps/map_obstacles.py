import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector
from ipoa_mission.ground import Ground
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.polygon import rings_of


class MapObstacle(NamedTuple):
    """`shape` is east, north [m]; `reach` widens a point or line.

    It reaches from `foot` above the lowest ground under it to `height` above the highest, at least to `least_top` above
    home.
    """

    name: str
    shape: Any
    reach: float
    foot: float
    height: float
    least_top: float = -math.inf
    hangs: bool = False  # a span between supports
    called: str = ""  # for messages


def raise_obstacles(obstacles: Sequence[MapObstacle], ground: Ground) -> tuple[Obstacle, ...]:
    hanging = [wall for each in obstacles if each.hangs for wall in raise_span(each, ground)]
    upright = [each for each in obstacles if not each.hangs]
    if not upright:
        return tuple(hanging)
    outlines = [_outline(each) for each in upright]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest = np.minimum.reduceat(heights, first).tolist()
    highest = np.maximum.reduceat(heights, first).tolist()
    raised = list[Obstacle]()
    for each, low, high in zip(upright, lowest, highest, strict=True):
        top = max(high + each.height, each.least_top, low + 0.1)  # at least 0.1 m high
        raised.append(_upright(each, low + each.foot, top))
    return (*raised, *hanging)


def _outline(obstacle: MapObstacle) -> NDArray[np.float64]:
    corners = shapely.get_coordinates(obstacle.shape)
    if obstacle.reach > 0:
        around = obstacle.reach * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        return np.asarray((corners[:, None, :] + around).reshape(-1, 2))
    return np.vstack([corners, shapely.get_coordinates(obstacle.shape.centroid)])


def _upright(obstacle: MapObstacle, base: float, top: float) -> Obstacle:
    name = obstacle.called or obstacle.name
    shape = obstacle.shape
    reach = obstacle.reach
    if shape.geom_type == "Point":
        return Cylinder(name, float(shape.x), float(shape.y), reach, base, top)
    if reach > 0:
        shape = shape.buffer(reach, cap_style="square", join_style="mitre")
    return Prism(name, *rings_of(shape), base, top)


def raise_span(obstacle: MapObstacle, ground: Callable[[NDArray[np.float64]], Vector]) -> Iterator[Prism]:
    """Yield walls under a span: several if its top rises or falls."""
    name = obstacle.called or obstacle.name
    span = obstacle.shape
    reach = obstacle.reach
    begin, end = shapely.get_coordinates(span)
    count = max(math.ceil(span.length / 8.0), 2)  # the ground is sampled every 8 m
    share = np.linspace(0.0, 1.0, count + 1)
    along = begin + share[:, None] * (end - begin)
    aside = reach * np.array([end[1] - begin[1], begin[0] - end[0]]) / span.length
    heights = ground(np.vstack([along - aside, along, along + aside])).reshape(3, -1)
    low = heights.min(axis=0)
    high = heights.max(axis=0)
    sagging = np.maximum(high, high[0] + share * (high[-1] - high[0])) + obstacle.height
    top = np.maximum(sagging, obstacle.least_top)
    # A piece's top rises or falls by at most 5 m, if that leaves pieces of 20 m or more.
    pieces = int(np.clip(math.ceil(float(np.ptp(top)) / 5.0), 1, max(span.length // 20.0, 1)))
    cuts = np.unique(np.round(np.linspace(0, count, min(pieces, count) + 1)).astype(int))
    for first, last in pairwise(cuts.tolist()):
        piece = slice(first, last + 1)
        outline = shapely.LineString(along[[first, last]]).buffer(reach, cap_style="square")
        yield Prism(name, *rings_of(outline), float(low[piece].min()), float(top[piece].max()))
