import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.scenario.place_sections import FenceSection
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.obstacles import Obstacle, RoundZone, Zone

HOME = shapely.Point(0.0, 0.0)
SEGMENTS = 16  # per quarter circle


def allowed_area(fences: Sequence[FenceSection], frame: LocalFrame) -> Any | None:
    """Return the intersection of inclusions, which also satisfies PX4's union. Raises BadInput."""
    shapes = [_shape(fence, frame, f"fence[{i}]") for i, fence in enumerate(fences) if fence.inclusion]
    if not shapes:
        return None
    common = shapely.intersection_all(shapes)
    if common.geom_type != "Polygon" or common.is_empty:
        raise BadInput("expected inclusions that have one area in common", code="fence-empty", place="fence")
    if (distance := common.distance(HOME)) > 0:
        words = f"expected home inside of it, not {distance:.1f} m outside"
        raise BadInput(words, code="home-outside-fence", place="fence")
    return common


def forbidden(fences: Sequence[FenceSection], frame: LocalFrame, base: float, top: float) -> tuple[Obstacle, ...]:
    """Return the exclusions. Raises BadInput."""
    obstacles: list[Obstacle] = []
    for i, fence in enumerate(fences):
        if fence.inclusion:
            continue
        name = f"fence[{i}]"
        shape = _shape(fence, frame, name)
        if shape.contains(HOME):
            raise BadInput("expected home outside of an exclusion", code="home-outside-fence", place=name)
        if fence.center is not None and fence.radius is not None:
            obstacles.append(RoundZone(name, *fence.center.east_north(frame), fence.radius, base, top))
        else:
            corners = shapely.get_coordinates(shape.exterior)[:-1]
            obstacles.append(Zone(name, tuple((float(x), float(y)) for x, y in corners), (), base, top))
    return tuple(obstacles)


def _shape(fence: FenceSection, frame: LocalFrame, name: str) -> Any:
    if fence.center is not None and fence.radius is not None:
        return shapely.Point(fence.center.east_north(frame)).buffer(fence.radius, quad_segs=SEGMENTS)
    corners = np.array(fence.polygon or fence.polygon_geodetic)
    if fence.polygon_geodetic is not None:
        latitude, longitude = corners.T
        corners = frame.to_local(latitude, longitude, np.full(len(corners), frame.home.altitude))[:, :2]
    shape = shapely.Polygon(corners)
    if not shape.is_valid or math.isclose(shape.area, 0.0):
        reason = shapely.is_valid_reason(shape).split("[")[0].lower()
        raise InvalidRing(f"expected a polygon with an inside, not with a {reason}", place=name)
    return shape
