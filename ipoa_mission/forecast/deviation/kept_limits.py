"""Compute what the deviation bound leaves of ground, ceiling and bounds, and enlarge a scene by it for planning."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import shapely
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.deviation.law import DeviationLaw, law_of
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.geometry import Points, Vector, as_place, leg_lengths
from ipoa_mission.planning.path_problem import PathTask, place_names, problem_of
from ipoa_mission.planning.proof import Check, prove_heights
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace, Bounds, Clearance
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.polygon import Polygon, rings_of


@dataclass(frozen=True, eq=False)
class TightPlace:
    """A given place, and the distance with a lower guarantee [m]."""

    name: str
    place: Vector
    reach: float


def tight_places(task: PathTask, spare: float) -> tuple[TightPlace, ...]:
    if not task.airspace.obstacles:
        return ()
    places = task.places
    missing = task.limits.obstacle_distance + spare - task.airspace.obstacle_distance(places)
    return tuple(
        TightPlace(name, place, 5.0 + 2.0 * float(less))  # [m] to turn, and two meters flown for each meter away
        for name, place, less in zip(place_names(places), places, missing, strict=True)
        if less > 0
    )


def round_places(points: Points, tight: tuple[TightPlace, ...]) -> NDArray[np.intp]:
    """Return the index of the place near each piece of points (n, 3), (n-1,); -1: none."""
    at = np.full(len(points) - 1, -1)
    middles = (points[:-1] + points[1:]) / 2
    for n, near in enumerate(tight):
        at[np.linalg.norm(middles - near.place, axis=1) <= near.reach] = n
    return at


def runs(points: Points, chosen: NDArray[np.bool_]) -> Iterator[Points]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    for first, last in edges.reshape(-1, 2).tolist():
        yield points[first : last + 1]


@dataclass(frozen=True, eq=False)
class ClearanceTask:
    """`chance`: to fall short of a limit; None: without a bound."""

    path: PathTask
    law: DeviationLaw
    chance: float | None


def clearance_task(scenario: Scenario, autopilot: Autopilot | None = None) -> ClearanceTask:
    """Return the scenario's limits, and the deviation law of its vehicle or of `autopilot` in its wind."""
    law = law_of(autopilot or scenario.vehicle.autopilot, scenario.wind.strongest)
    return ClearanceTask(scenario, law, scenario.safety.chance)


@dataclass(frozen=True)
class DeviationBound:
    lateral: float
    down: float
    up: float

    def wider(self, by: float) -> "DeviationBound":
        return DeviationBound(self.lateral + by, self.down + by, self.up + by)

    @property
    def below(self) -> Vector:
        return np.array([self.lateral, self.lateral, self.down])

    @property
    def above(self) -> Vector:
        return np.array([self.lateral, self.lateral, self.up])


NO_DEVIATION = DeviationBound(0.0, 0.0, 0.0)
Stretch: TypeAlias = tuple[Points, DeviationBound]


def deviation_bound_of(law: DeviationLaw, chance: float) -> DeviationBound:
    """Return the bound that a straight flight exceeds at each limit with at most this probability."""
    side = 0.25  # of the probability; the rest is for the heights
    heights = (1 - side) * chance
    return DeviationBound(law.lateral_bound(side * chance), law.lowest.distance(heights), law.highest.distance(heights))


def limits_kept(path: Points, task: PathTask, bound: DeviationBound) -> Iterator[Check]:
    higher = problem_of(task).tightened(bound.down)
    least = task.limits.height_above_ground
    for check in prove_heights(_swept(path, task.airspace, bound), higher):
        if check.limit == "ceiling":
            yield replace(check, nearest=check.nearest.minus(-bound.up))
        elif check.limit == "ground" and check.required >= least + bound.down:
            yield replace(check, nearest=check.nearest.minus(bound.down), required=least)
    if (bounds := _bounds_kept(path, task, bound)) is not None:
        yield bounds


def _swept(path: Points, airspace: Airspace, bound: DeviationBound) -> Points:
    """Return the path, and over uneven ground one line to and fro along it and eight parallels."""
    if airspace.terrain.steepness == 0 or bound.lateral == 0:
        return path
    lines = [path]
    for turn in [2 * math.pi * side / 8 for side in range(8)]:
        lines.append(path + bound.lateral * np.array([math.cos(turn), math.sin(turn), 0.0]))
    lines[1::2] = [line[::-1] for line in lines[1::2]]
    return np.vstack(lines)


def least_slacks(stretches: list[Stretch], task: PathTask) -> dict[str, Vector]:
    """Return lower bounds of each limit's slack as in `limits_kept`, (n,) [m]."""
    if len(stretches) == 1:
        return {"any": np.zeros(1)}
    airspace = task.airspace
    points = np.vstack([path for path, _ in stretches])
    firsts = _firsts([path for path, _ in stretches])
    lateral, down, up = np.array([(bound.lateral, bound.down, bound.up) for _, bound in stretches]).T
    steepness = airspace.terrain.steepness
    thinning_error = 2 * THINNING_TOLERANCE
    aside = thinning_error + float(leg_lengths(points).max()) / 2  # from the points
    uneven = thinning_error + steepness * (lateral + aside)
    heights = points[:, 2] - airspace.ground(points)
    low = np.minimum.reduceat(heights, firsts) - uneven
    high = np.maximum.reduceat(heights, firsts) + uneven
    if steepness > 0:
        rough = thinning_error * (1 + steepness)
        near = np.flatnonzero(low <= heights.min() + rough)  # others cannot be the lowest
        legs = [sliding_window_view(_swept(stretches[n][0], airspace, stretches[n][1]), 2, axis=0) for n in near]
        starts, ends = np.moveaxis(np.vstack(legs), 2, 0)
        exact = airspace.terrain.legs_height(starts, ends, float(heights.min()) + 2 * rough)
        low[near] = np.maximum(low[near], np.minimum.reduceat(exact, _firsts(legs)) - rough)
    bounds = airspace.bounds
    inside = np.minimum.reduceat(
        np.minimum(points - np.asarray(bounds.lower), np.asarray(bounds.upper) - points), firsts
    )
    inside -= np.column_stack([lateral, lateral, np.maximum(down, up)]) + thinning_error
    if bounds.footprint is not None:
        away = np.maximum.reduceat(bounds.footprint.distance(points[:, :2]), firsts)
        inside = np.column_stack([inside, -away - lateral - aside])
    return {
        "ground": low - down - task.limits.height_above_ground,
        "ceiling": task.limits.ceiling_above_ground - high - up,
        "bounds": inside.min(axis=1),
    }


def _firsts(parts: list[Points]) -> NDArray[np.intp]:
    return np.cumsum([0, *map(len, parts[:-1])])


def _bounds_kept(path: Points, task: PathTask, bound: DeviationBound) -> Check | None:
    bounds = task.airspace.bounds
    fixed = np.vstack([np.zeros(3), task.places])
    fixed = fixed[_inside(fixed, task, bound).min(axis=1) < 0]
    near_place = 15.0  # of the path around a place near to a limit [m]
    away = np.linalg.norm(path[:, None, :2] - fixed[None, :, :2], axis=2).min(axis=1, initial=np.inf) > near_place
    if not away.any():
        return None
    margins = _inside(path[away], task, bound)
    spot, side = np.unravel_index(int(np.argmin(margins)), margins.shape)
    place = path[away][spot]
    sides = ("west", "south", "lower", "east", "north", "upper")
    least = float(margins[spot, side])
    nearest = f"the {sides[side]} bound"
    if bounds.footprint is not None:
        edge = shapely.boundary(bounds.footprint.shape)
        line = shapely.LineString(path[:, :2])
        line = line.difference(shapely.union_all(shapely.buffer(shapely.points(fixed[:, :2]), near_place)))
        if not line.is_empty and (margin := float(shapely.distance(line, edge)) - bound.lateral) < least:
            near = np.array(shapely.shortest_line(line, edge).coords[0])
            least = margin
            nearest = "the flight area"
            place = path[np.argmin(np.linalg.norm(path[:, :2] - near, axis=1))]
    return Check("bounds", Clearance(least, as_place(place), nearest), 0.0)


def _inside(points: Points, task: PathTask, bound: DeviationBound) -> Points:
    bounds = task.airspace.bounds
    lower = points - np.asarray(bounds.lower) - bound.below
    return np.hstack([lower, np.asarray(bounds.upper) - points - bound.above])


MIN_GROWTH = 0.01  # [m]


def with_margins(
    task: ClearanceTask, sharing: float, keep_gaps: bool = False, height_factor: float = 9.0, spares_places: bool = True
) -> PathTask:
    """Return the path task with room for the deviation bound, or `spares_places` for what room given places leave.

    `sharing`: how many places share the chance of exceeding it; less gives smaller margins. Over steep ground
    the path is higher, by at most `height_factor` times the spare height of the lowest given place.
    """
    path, law, chance = task.path, task.law, task.chance
    if chance is None:
        return path
    bound = deviation_bound_of(law, chance)
    lateral = law.lateral.distance(chance / sharing)
    airspace = path.airspace
    if spares_places:
        growth = np.full(len(airspace.obstacles), lateral)
        bodies = grown(path, path, growth, DeviationBound(lateral, bound.down, bound.up), keep_gaps)
    else:
        bodies = tuple(body.grown(lateral, bound.up, bound.down) for body in airspace.obstacles)
    slope = _usual_slope(airspace) * bound.lateral
    heights = path.places[:, 2] - path.airspace.ground(path.places)
    spare = float(heights.min()) - path.limits.height_above_ground
    higher = max(bound.down, min(bound.down + slope, height_factor * spare))
    world = Airspace(shrunk(airspace.bounds, path.places, bound), airspace.terrain, bodies)
    return problem_of(path).tightened(higher, bound.up + slope, world)


def grown(
    enlarged: PathTask, task: PathTask, growth: Vector, shape: DeviationBound, keep_gaps: bool
) -> tuple[Obstacle, ...]:
    """Return obstacles grown by at most `growth` (n,) [m], so that given places stay clear; or as in `enlarged`.

    For planning only: an obstacle near to one place grows less everywhere, and one without an upright column by the
    lateral bound alone.
    """
    bodies = task.airspace.obstacles
    distance = task.limits.obstacle_distance
    spare = np.array([body.distance(task.places).min() for body in bodies])
    growth = np.clip(spare - distance - MIN_GROWTH, 0.0, growth)
    if keep_gaps and len(growth) > 1:
        _keep_gaps_open(growth, bodies, distance)
    larger = list(enlarged.airspace.obstacles)
    for n, (body, by) in enumerate(zip(bodies, growth.tolist(), strict=True)):
        below = above = by
        if body.column is not None:  # flights are too high under a body, too low over it
            below = by / shape.lateral * shape.up
            above = by / shape.lateral * shape.down
        if by >= MIN_GROWTH:
            larger[n] = body.grown(by, below, above)
    return tuple(larger)


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
    shape = footprint.buffered(-bound.lateral)
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
