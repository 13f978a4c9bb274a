"""Enlarge a scene by the deviation bound while a path is planned."""

import numpy as np
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.deviation.kept_limits import ClearanceTask, DeviationBound, deviation_bound_of
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.path_problem import PathTask, problem_of
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.polygon import Polygon, rings_of

MIN_GROWTH = 0.01  # [m]


def with_margins(task: ClearanceTask, sharing: float, keep_gaps: bool = False, height_factor: float = 9.0) -> PathTask:
    """Return the path task with room for the deviation bound.

    `sharing`: how many places share the chance of exceeding it; less gives smaller margins. Over steep ground
    the path is higher, by at most `height_factor` times the spare height of the lowest given place.
    """
    path, law, chance = task.path, task.law, task.chance
    if chance is None:
        return path
    bound, level = deviation_bound_of(law, chance), law.level.distance(chance / sharing)
    airspace = path.airspace
    growth = np.full(len(airspace.obstacles), level)
    bodies = grown(path, path, growth, DeviationBound(level, bound.down, bound.up), keep_gaps)
    slope = _usual_slope(airspace) * bound.level
    heights = path.places[:, 2] - path.airspace.ground(path.places)
    spare = float(heights.min()) - path.limits.height_above_ground
    higher = max(bound.down, min(bound.down + slope, height_factor * spare))
    world = Airspace(shrunk(airspace.bounds, path.places, bound), airspace.terrain, bodies)
    return problem_of(path).tightened(higher, bound.up + slope, world)


def grown(
    enlarged: PathTask, task: PathTask, growth: Vector, shape: DeviationBound, keep_gaps: bool
) -> tuple[Obstacle, ...]:
    """Return obstacles grown by `growth` (n,) [m], or as in `enlarged`."""
    bodies, distance = task.airspace.obstacles, task.limits.obstacle_distance
    spare = np.array([body.distance(task.places).min() for body in bodies])
    growth = np.clip(spare - distance - MIN_GROWTH, 0.0, growth)
    if keep_gaps and len(growth) > 1:
        _keep_gaps_open(growth, bodies, distance)
    return tuple(
        body.grown(by, by / shape.level * shape.up, by / shape.level * shape.down) if by >= MIN_GROWTH else wide
        for body, wide, by in zip(bodies, enlarged.airspace.obstacles, growth.tolist(), strict=True)
    )


def _keep_gaps_open(growth: Vector, bodies: tuple[Obstacle, ...], distance: float) -> None:
    """Limit `growth` in place so that no sufficient gap closes."""
    outlines = np.array([body.horizontal_shape for body in bodies])
    pairs = shapely.STRtree(outlines).query(outlines, "dwithin", 2 * (distance + float(growth.max())))
    first, second = pairs[:, pairs[0] < pairs[1]]
    spare = (shapely.distance(outlines[first], outlines[second]) - 2 * distance) / 2 - MIN_GROWTH
    is_open = spare > 0
    for bodies_of in (first[is_open], second[is_open]):
        np.minimum.at(growth, bodies_of, spare[is_open])


def shrunk(bounds: Bounds, fixed: Points, bound: DeviationBound) -> Bounds:
    """Return bounds with the deviation bound inside, except sides that a given place (k, 3) is nearer to."""
    lower, upper = np.array(bounds.lower), np.array(bounds.upper)
    lower += np.clip(fixed.min(axis=0) - lower - MIN_GROWTH, 0.0, bound.below)
    upper -= np.clip(upper - fixed.max(axis=0) - MIN_GROWTH, 0.0, bound.above)
    try:
        return Bounds(tuple(lower.tolist()), tuple(upper.tolist()), _narrower(bounds.footprint, fixed, bound))
    except BadInput:
        return bounds


def _narrower(footprint: Polygon | None, fixed: Points, bound: DeviationBound) -> Polygon | None:
    if footprint is None:
        return None
    shape = footprint.buffered(-bound.level)
    if not isinstance(shape, shapely.Polygon) or not shape.covers(shapely.MultiPoint(fixed[:, :2])):
        return footprint
    return Polygon(*rings_of(shape))


def _usual_slope(airspace: Airspace) -> float:
    """Return the slope of the ground that one place in twenty exceeds [m/m]."""
    if airspace.terrain.steepness == 0:
        return 0.0
    lower, upper = airspace.bounds.lower, airspace.bounds.upper
    east, north = np.meshgrid(np.linspace(lower[0], upper[0], 40), np.linspace(lower[1], upper[1], 40))
    heights = airspace.ground(np.column_stack([east.ravel(), north.ravel()])).reshape(east.shape)
    along, across = np.gradient(heights, north[:, 0], east[0])
    return float(np.quantile(np.hypot(along, across), 0.95))
