from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.maps.wires import raise_span
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.polygon import rings_of

LEAST_HEIGHT = 0.1  # [m]


class Standing(NamedTuple):
    """`shape` is east, north [m]; `reach` widens a point or line.

    It reaches from `foot` above the lowest ground under it to `height` above the highest, or above home if `over_home`.
    """

    name: str
    shape: Any
    reach: float
    foot: float
    height: float
    over_home: bool = False
    hangs: bool = False  # a span between supports
    called: str = ""  # for messages


def raise_buildings(standing: Sequence[Standing], ground: Ground) -> tuple[Obstacle, ...]:
    hanging = [prism for s in standing if s.hangs for prism in _span(s, ground)]
    standing = [s for s in standing if not s.hangs]
    if not standing:
        return tuple(hanging)
    outlines = [_outline(s) for s in standing]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest, highest = np.minimum.reduceat(heights, first), np.maximum.reduceat(heights, first)
    raised = (
        _obstacle(
            s, float(low) + s.foot, max(s.height if s.over_home else float(high) + s.height, float(low) + LEAST_HEIGHT)
        )
        for s, low, high in zip(standing, lowest, highest, strict=True)
    )
    return (*raised, *hanging)


def _span(s: Standing, ground: Ground) -> Iterator[Obstacle]:
    return raise_span(s.called or s.name, s.shape, s.reach, s.height, ground)


def _outline(s: Standing) -> NDArray[np.float64]:
    corners = shapely.get_coordinates(s.shape)
    if s.reach > 0:
        around = s.reach * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        return np.asarray((corners[:, None, :] + around).reshape(-1, 2))
    return np.vstack([corners, shapely.get_coordinates(s.shape.centroid)])


def _obstacle(s: Standing, base: float, top: float) -> Obstacle:
    name = s.called or s.name
    if s.shape.geom_type == "Point":
        return Cylinder(name, float(s.shape.x), float(s.shape.y), s.reach, base, top)
    shape = s.shape.buffer(s.reach, cap_style="square", join_style="mitre") if s.reach > 0 else s.shape
    return Prism(name, *rings_of(shape), base, top)
