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


def with_room(task: ClearanceTask, tight: float, keep_gaps: bool = False, height_factor: float = 9.0) -> PathTask:
    """Return the path task with room for the deviation bound at `tight` tight places.

    Over steep ground the path is higher, by at most `height_factor` times the spare height of the lowest given place.
    """
    path, law, chance = task.path, task.law, task.chance
    if chance is None:
        return path
    deviation_bound, level = deviation_bound_of(law, chance), law.level.distance(chance / tight)
    airspace = path.airspace
    growth = np.full(len(airspace.obstacles), level)
    bodies = grown(path, path, growth, DeviationBound(level, deviation_bound.down, deviation_bound.up), keep_gaps)
    slope = _usual_slope(airspace) * deviation_bound.level
    higher = max(deviation_bound.down, min(deviation_bound.down + slope, height_factor * _spare_height(path)))
    world = Airspace(shrunk(airspace.bounds, path.places, deviation_bound), airspace.terrain, bodies)
    return problem_of(path).tightened(higher, deviation_bound.up + slope, world)


def _spare_height(path: PathTask) -> float:
    heights = path.places[:, 2] - path.airspace.ground(path.places)
    return float(heights.min()) - path.limits.height_above_ground


def grown(
    roomy: PathTask, task: PathTask, growth: Vector, shape: DeviationBound, keep_gaps: bool
) -> tuple[Obstacle, ...]:
    """Return obstacles grown by `growth` (n,) [m], or as in `roomy`."""
    bodies, distance = task.airspace.obstacles, task.limits.obstacle_distance
    spare = np.array([body.distance(task.places).min() for body in bodies])
    growth = np.clip(spare - distance - MIN_GROWTH, 0.0, growth)
    if keep_gaps and len(growth) > 1:
        _keep_gaps_open(growth, bodies, distance)
    return tuple(
        body.grown(by, by / shape.level * shape.up, by / shape.level * shape.down) if by >= MIN_GROWTH else wide
        for body, wide, by in zip(bodies, roomy.airspace.obstacles, growth.tolist(), strict=True)
    )


def _keep_gaps_open(growth: Vector, bodies: tuple[Obstacle, ...], distance: float) -> None:
    """Limit `growth` in place so that no sufficient gap closes."""
    outlines = np.array([body.plan for body in bodies])
    one, other = shapely.STRtree(outlines).query(outlines, "dwithin", 2 * (distance + float(growth.max())))
    pairs = one < other
    one, other = one[pairs], other[pairs]
    spare = (shapely.distance(outlines[one], outlines[other]) - 2 * distance) / 2 - MIN_GROWTH
    open_ = spare > 0
    for bodies_of in (one[open_], other[open_]):
        np.minimum.at(growth, bodies_of, spare[open_])


def shrunk(bounds: Bounds, fixed: Points, deviation_bound: DeviationBound) -> Bounds:
    """Return bounds with the deviation bound inside, except sides that a given place (k, 3) is nearer to."""
    lower, upper = np.array(bounds.lower), np.array(bounds.upper)
    near = (
        np.array([deviation_bound.level, deviation_bound.level, deviation_bound.down]),
        np.array([deviation_bound.level, deviation_bound.level, deviation_bound.up]),
    )
    lower += np.clip(fixed.min(axis=0) - lower - MIN_GROWTH, 0.0, near[0])
    upper -= np.clip(upper - fixed.max(axis=0) - MIN_GROWTH, 0.0, near[1])
    try:
        return Bounds(tuple(lower.tolist()), tuple(upper.tolist()), _narrower(bounds.footprint, fixed, deviation_bound))
    except BadInput:
        return bounds


def _narrower(footprint: Polygon | None, fixed: Points, deviation_bound: DeviationBound) -> Polygon | None:
    if footprint is None:
        return None
    shape = footprint.buffered(-deviation_bound.level)
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
