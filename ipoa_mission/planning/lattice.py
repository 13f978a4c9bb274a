"""Initial guesses: distinct routes through a coarse lattice.

Two runs of A* give the least cost of a route through each node; its local minima are other passages.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, arc_lengths, leg_lengths
from ipoa_mission.planning.gaps import gap_places
from ipoa_mission.planning.obstacle_grid import UNLIMITED, Nodes
from ipoa_mission.planning.problem import Candidate, PreparedProblem, follow, via_indices

STRIDES = np.array([step for step in np.ndindex(3, 3, 3) if step != (1, 1, 1)]) - 1
ROUNDING = 1e-9  # of costs, relative
#: Steps to all nodes in the cube of five around a node, nearest first.
CUBE: NDArray[np.int64] = np.array(sorted(np.ndindex(5, 5, 5), key=lambda at: sum((k - 2) ** 2 for k in at))[1:]) - 2
End = tuple[Vector, int | None]  # a place and its node


class LatticeStrategy(NamedTuple):
    nodes: int = 100_000
    max_nodes_per_side: int = 200
    max_levels: int = 60  # without limited climbs
    min_slope: float = 0.07  # flatter climbs would need too many levels
    refinements: tuple[float, ...] = (1.0, 2.0, 3.0)  # of the spacing, each if the one before has no route
    max_routes: int = 60
    max_routes_climbing: int = 8  # with limited climbs
    max_cost_ratio: float = 1.6  # of a route to the cheapest
    max_routes_beside: int = 8  # besides those through narrow gaps
    control_points_per_turn: int = 4
    max_control_points: int = 80


class LatticeDetails(NamedTuple):
    max_control_points: int = 500
    detour_radius: float = 20.0  # [m]
    least_price: float = 0.1  # per meter, that divides the price of turns
    detour_discount: float = 0.98  # against flying to and fro
    long_detour: float = 0.5  # of a climb's distance
    shortest_detour: float = 0.5  # [m]
    lift_slope_share: float = 0.97  # of the steepest
    samples_per_leg: int = 10
    gap_slack: float = 0.05  # that its neighbors lack, in steps
    widest_gap: float = 1.5  # beyond the required width, in steps
    centering_rounds: int = 6
    end_nodes: int = 64  # candidates to begin or end at
    end_samples: int = 8  # to each of them
    passage_shares: tuple[float, ...] = (0.25, 0.5, 0.75)  # of a route's cost
    passage_width: float = 0.04  # of such a share, to either side


DETAILS = LatticeDetails()
USUAL_LATTICE = LatticeStrategy()


@dataclass(frozen=True, eq=False)
class Lattice:
    """Nodes in steps of `spacing` (3,), at `places` (nx ny nz, 3).

    `slack` beyond the required clearance [m] and `price` per meter are (nx, ny, nz); the price of negative slack is
    infinite.
    """

    spacing: Vector
    places: Points
    slack: NDArray[np.float64]
    price: NDArray[np.float64]
    steepest: tuple[float, float]  # slopes of climb and descent
    detour_cost: float  # extra cost of a meter of detours against a straight meter
    strategy: LatticeStrategy

    def steps(self, backwards: bool = False) -> tuple[NDArray[np.int64], Vector]:
        """Return the steps (s, 3) and their lengths (s,) [m].

        A step that is too steep has the length of its detour. Height costs slightly less there: no route flies to and
        fro.
        """
        strides = STRIDES * self.spacing
        level = np.hypot(strides[:, 0], strides[:, 1])
        rise = strides[:, 2]
        climb_slope, descent_slope = self.steepest[::-1] if backwards else self.steepest
        needed = np.maximum(rise / climb_slope, -rise / descent_slope)
        too_steep = needed > (1 + 1e-6) * level
        lengths = np.hypot(np.where(too_steep, needed, level), rise) + self.detour_cost * needed
        return STRIDES, np.where(too_steep, DETAILS.detour_discount * lengths, lengths)


@dataclass(frozen=True, eq=False)
class Guess:
    """A polyline `guide` (k, 3), with `inner` control points evenly, or `shares` (k-1,) on each leg."""

    guide: Points
    shares: Vector | None
    inner: int

    def candidate(self, problem: PreparedProblem, closer: int = 1) -> Candidate:
        inner = self.inner if self.shares is None else round(float(self.shares.sum()))
        return follow(self.guide, min(closer * inner, DETAILS.max_control_points), problem.task, self.shares)


def guesses(problem: PreparedProblem, coarsest: int, strategy: LatticeStrategy = USUAL_LATTICE) -> list[Guess]:
    """Return the straight guess, then guesses along routes of `refinements[coarsest:]`."""
    straight = problem.task.places
    inner = max(problem.task.planning.control_points, 3, 5 * (len(straight) - 1))
    routes: list[Points] = []
    most = strategy.max_routes_climbing if problem.climbs_limited else strategy.max_routes
    for fineness in strategy.refinements[coarsest:]:
        lattice = lay_lattice(problem, fineness, strategy)
        routes = find_routes(lattice, problem, most)
        if routes:
            routes = _mend(routes, lattice, problem)
            break
    routes = routes or find_routes(lattice, problem, most, check_legs=False)
    tolerance = min(2 * lattice.spacing[0], max(lattice.spacing[0], problem.rules.d_safe))
    lines = [shapely.LineString(route[:, :2]) for route in routes]  # corners: Douglas and Peucker
    turns = max(shapely.get_num_points(shapely.simplify(lines, tolerance, preserve_topology=False)) - 2, default=0)
    inner = int(max(inner, min(4 + strategy.control_points_per_turn * turns, strategy.max_control_points)))
    return [
        Guess(straight, None, inner),
        *_climbing(routes, inner, problem, float(lattice.spacing[2]), both=coarsest > 0),
    ]


def _climbing(routes: list[Points], inner: int, problem: PreparedProblem, step: float, both: bool) -> Iterator[Guess]:
    """Yield guesses within slope limits; as steep as the route for a long detour, or `both`."""
    for route in routes:
        detour = np.inf
        if problem.climbs_limited:
            lifted, detour = lift_to_slopes(route, problem, step)
            if detour < DETAILS.long_detour:
                yield Guess(lifted, None, inner)
        if both or detour >= DETAILS.long_detour:
            shortened = _without_detours(route, problem)
            legs = leg_lengths(shortened)
            yield Guess(shortened, inner * legs / max(float(legs.sum()), DETAILS.shortest_detour), inner)


def lift_to_slopes(route: Points, problem: PreparedProblem, step: float) -> tuple[Points, float]:
    """Return the route (k, 3) lifted to keep the slope limits, and the longest detour it needs.

    A detour is a share of the distance of the climb; infinite if the lifted route is not free.
    """
    lifted = route.copy()
    longest = 0.0
    lift_climb_slope = DETAILS.lift_slope_share * problem.rules.climb_slope
    lift_descent_slope = DETAILS.lift_slope_share * problem.rules.descent_slope
    traveled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route[:, :2], axis=0).T))])
    for first, last in pairwise([0, *via_indices(route, problem.task.places[1:-1]), len(route) - 1]):
        along = traveled[first : last + 1] - traveled[first]
        height = route[first : last + 1, 2]
        climb, descent = lift_climb_slope * along, lift_descent_slope * along
        after = np.maximum.accumulate(height + descent) - descent  # no lower than a descent from behind
        before = np.maximum.accumulate((after - climb)[::-1])[::-1]  # and than a climb to what is ahead
        lifted[first + 1 : last, 2] = (before + climb)[1:-1]
        for missing, slope, within in (
            (before[0] - height[0], problem.rules.climb_slope, along[np.argmax(after - climb)]),
            (after[-1] - height[-1], problem.rules.descent_slope, along[-1] - along[np.argmax(height + descent)]),
        ):
            if missing > 2 * step:
                longest = max(longest, float(missing / slope / max(within, DETAILS.shortest_detour)))
    return lifted, longest if _free(lifted, problem) else np.inf


def _without_detours(route: Points, problem: PreparedProblem) -> Points:
    stops = {tuple(place) for place in problem.task.places}
    kept = np.ones(len(route), bool)
    for k in range(1, len(route) - 1):
        beside = tuple(route[k - 1]) in stops or tuple(route[k + 1]) in stops
        if beside and tuple(route[k]) not in stops and kept[k - 1]:
            kept[k] = not _free(route[[k - 1, k + 1]], problem)
    return route[kept]


def _free(route: Points, problem: PreparedProblem) -> bool:
    spots = np.vstack([route[1:-1], (route[1:] + route[:-1]) / 2])
    return bool((problem.slack_and_threat(spots)[0] >= -0.5 * problem.rules.clearance).all())


def lay_lattice(problem: PreparedProblem, fineness: float = 1.0, strategy: LatticeStrategy = USUAL_LATTICE) -> Lattice:
    """Return the lattice of a problem's region; nodes in narrow gaps are moved to their middle."""
    lower, upper = problem.region
    size = upper - lower
    steepest = (problem.rules.climb_slope, problem.rules.descent_slope)
    # cells are as flat as the flattest climb, so that one step up is flyable: rise = slope * pitch
    flattest = max(min(*steepest, 1.0), strategy.min_slope)
    area = size[0] * size[1]
    pitch = (area * size[2] / flattest / strategy.nodes) ** (1 / 3)
    is_upright = min(steepest) >= UNLIMITED  # cells may then be higher
    if is_upright:
        pitch = min(pitch, (area * strategy.max_levels / strategy.nodes) ** 0.5)
    pitch = max(pitch, size[:2].max() / strategy.max_nodes_per_side) / fineness
    count = np.ones(3, int)
    count[:2] += np.ceil(size[:2] / pitch).astype(int)
    rise = min(flattest * float((size[:2] / (count[:2] - 1)).min()), max(size[2] / 6, 0.5))
    if is_upright:
        rise = max(rise, size[2] / (strategy.max_levels * fineness))
    count[2] += int(np.ceil(size[2] / rise))
    spacing = size / (count - 1)
    indices = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = np.minimum(lower + spacing * indices, upper)
    slack, threat = problem.slack_and_threat(nodes)
    between = np.nonzero(_in_gaps(slack.reshape(count), spacing).ravel())[0]
    nodes[between] = _centered(nodes[between], spacing, problem, least=0.0)
    slack[between], threat[between] = problem.slack_and_threat(nodes[between])
    radius = min(DETAILS.detour_radius, float(size[:2].min()) / 4)
    detour_cost = problem.rules.turning / max(problem.rules.length, DETAILS.least_price) / radius
    _occupy_gaps(nodes, (slack, threat), lower, spacing, problem)
    price = np.where(slack >= 0, problem.rules.length + threat, np.inf)
    return Lattice(spacing, nodes, slack.reshape(count), price.reshape(count), steepest, detour_cost, strategy)


def find_routes(lattice: Lattice, problem: PreparedProblem, most: int, check_legs: bool = True) -> list[Points]:
    """Return up to `most` distinct routes (k, 3), cheapest first; thin obstacles are missed without `check_legs`."""
    places = problem.task.places
    ends = zip(places, (_end_node(lattice, problem, place) for place in places), strict=True)
    legs = list[list[Points]]()
    wanted = most
    for leg in pairwise(ends):
        legs.append(_leg_routes(lattice, problem, leg, wanted, check_legs))
        if not legs[-1]:
            return []
        wanted -= len(legs[-1]) - 1
    cheapest = [leg[0] for leg in legs]
    others = ([*cheapest[:i], other, *cheapest[i + 1 :]] for i, leg in enumerate(legs) for other in leg[1:])
    variants = [cheapest, *others]
    return [np.vstack([variant[0], *(route[1:] for route in variant[1:])]) for variant in variants[:most]]


def _in_gaps(slack: NDArray[np.float64], spacing: Vector) -> NDArray[np.bool_]:
    """Return nodes that may be in a gap between obstacles: too near, but farther than their neighbors' mean."""
    between = np.zeros(slack.shape, bool)
    for axis, step in enumerate(spacing):
        padded = np.pad(slack, [(int(k == axis),) * 2 for k in range(3)], mode="edge")
        before, after = (padded.take(range(k, k + slack.shape[axis]), axis) for k in (0, 2))
        between |= slack - (before + after) / 2 > DETAILS.gap_slack * step
    doubtful = (slack < 0) & (slack > -np.linalg.norm(spacing) / 2)
    return np.asarray(doubtful & ~_least_around(~(between & doubtful), 1))


def _centered(nodes: Points, spacing: Vector, problem: PreparedProblem, least: float = -np.inf) -> Points:
    from ipoa_mission.planning._kernels import centered

    closer = 3.0 ** np.arange(1, DETAILS.centering_rounds + 1)[:, None, None]
    offsets = np.vstack([np.zeros(3), STRIDES]) * spacing / closer
    return centered(nodes, offsets, (*problem.region, least), problem.grid, problem.rules)  # type: ignore[no-any-return]


def _mend(routes: list[Points], lattice: Lattice, problem: PreparedProblem) -> list[Points]:
    """Mend legs that cut an obstacle by extra points; add routes if the cheapest is not repairable."""
    mended = list[Points]()
    closed = list[Points]()
    for route in routes:
        points, cut = _blocked_samples(route, problem)
        points[cut] = _centered(points[cut], lattice.spacing, problem)
        kept = cut | (np.arange(len(points)) % DETAILS.samples_per_leg == 0)
        mended.append(points[kept])
        still = np.nonzero(_blocked_samples(mended[-1], problem)[1])[0] // DETAILS.samples_per_leg
        narrow = np.nonzero(kept)[0][still] // DETAILS.samples_per_leg
        closed.append(route[np.union1d(narrow, narrow + 1)])
    if not len(closed[0]):
        return mended
    nodes = np.ascontiguousarray(lattice.places).view("V24").ravel()  # 24-byte rows
    is_narrow = np.isin(nodes, np.vstack(closed).view("V24").ravel()).reshape(lattice.price.shape)
    price = np.where(is_narrow, np.inf, lattice.price)
    return mended + find_routes(replace(lattice, price=price), problem, lattice.strategy.max_routes_beside)


def _blocked_samples(route: Points, problem: PreparedProblem) -> tuple[Points, NDArray[np.bool_]]:
    shares = np.linspace(0.0, 1.0, DETAILS.samples_per_leg, endpoint=False)[:, None]
    points = np.vstack([(route[:-1, None] + shares * np.diff(route, axis=0)[:, None]).reshape(-1, 3), route[-1:]])
    return points, (problem.slack_and_threat(points)[0] < 0) & (np.arange(len(points)) % DETAILS.samples_per_leg > 0)


def _occupy_gaps(
    nodes: Points, slack_and_threat: tuple[Vector, Vector], lower: Vector, spacing: Vector, problem: PreparedProblem
) -> None:
    """Move nodes (n, 3), with their slack and threat, to narrow gaps in their cells."""
    slack, threat = slack_and_threat
    count = np.round((nodes[-1] - lower) / spacing).astype(int) + 1
    heights = lower[2] + spacing[2] * np.arange(count[2])
    widest = 2 * problem.limits.obstacle_distance + DETAILS.widest_gap * float(spacing[:2].max())
    for places in gap_places(problem, widest, float(spacing[:2].max()), heights):
        number = np.round((places - lower) / spacing).astype(int)
        inside = ((number >= 0) & (number < count)).all(axis=1)
        places = places[inside]
        node = np.ravel_multi_index(tuple(number[inside].T), tuple(count))
        new_slack, new_threat = problem.slack_and_threat(places)
        better = np.nonzero((new_slack >= 0) | (new_slack > slack[node]))[0]
        better = better[np.argsort(new_slack[better], kind="stable")]  # the last stays
        node = node[better]
        nodes[node] = places[better]
        slack[node] = new_slack[better]
        threat[node] = new_threat[better]


def _end_node(lattice: Lattice, problem: PreparedProblem, place: Vector) -> int | None:
    """Return the index of the nearest node with a clear leg to a place."""
    free = np.nonzero(np.isfinite(lattice.price.ravel()))[0]
    away = ((lattice.places[free] - place) ** 2).sum(axis=1)
    most = DETAILS.end_nodes
    few = np.argpartition(away, most)[:most] if len(free) > most else np.arange(len(free))
    few = free[few[np.argsort(away[few])]]
    shares = np.linspace(0.0, 1.0, DETAILS.end_samples)[:, None, None]
    legs = place + shares * (lattice.places[few] - place)
    slack = problem.slack_and_threat(legs.reshape(-1, 3))[0].reshape(DETAILS.end_samples, -1).min(axis=0)
    return int(few[np.argmax(slack >= min(slack.max(), 0.0))]) if len(few) else None


def _leg_routes(
    lattice: Lattice, problem: PreparedProblem, ends: tuple[End, End], most: int, check_legs: bool
) -> list[Points]:
    from ipoa_mission.planning._kernels import lattice_costs

    (start, source), (goal, target) = ends
    if source is None or target is None:
        return []
    checks = check_legs and float(np.linalg.norm(lattice.spacing)) > 2 * problem.limits.obstacle_distance
    nodes = Nodes(lattice.price, lattice.slack, lattice.places, lattice.spacing)
    ratio = lattice.strategy.max_cost_ratio * (1 + ROUNDING)
    cost_from, before = lattice_costs(
        nodes, lattice.steps(), checks, (source, target, ratio), problem.grid, problem.rules
    )
    if not np.isfinite(cost_from[target]):
        return []
    if most == 1:
        return [np.vstack([start, lattice.places[_trace(before, target)[::-1]], goal])]
    steps = lattice.steps(backwards=True)
    cost_to, after = lattice_costs(nodes, steps, checks, (target, source, ratio), problem.grid, problem.rules)
    routes = list[Points]()
    courses = np.empty((most, 24, 3))
    for node in [target, *_passages(cost_from, cost_to, lattice)]:
        passed = [*_trace(before, node)[::-1], *_trace(after, node)[1:]]
        points = np.vstack([start, lattice.places[passed], goal])
        traveled = arc_lengths(points)
        stations = np.linspace(0, traveled[-1], 24)
        course = np.column_stack([np.interp(stations, traveled, points[:, k]) for k in range(3)])
        apart = np.linalg.norm(course - courses[: len(routes)], axis=2).max(axis=1)
        if (apart > 4 * lattice.spacing[0]).all():
            courses[len(routes)] = course
            routes.append(points)
        if len(routes) == most:
            break
    return routes


def _passages(cost_from: Vector, cost_to: Vector, lattice: Lattice) -> Iterator[int]:
    """Yield nodes of distinct routes, cheapest first.

    A node's total is the cost from the start plus the cost to the goal. A passage is a local minimum of totals among
    nodes whose cost from the start is a quarter, half or three quarters of the total.
    """
    through = cost_from + cost_to
    best = through.min()
    is_known = np.isfinite(through) & (through > 0)
    share = np.divide(cost_from, through, out=np.zeros_like(through), where=is_known)
    chosen: list[tuple[float, int]] = []
    for middle in DETAILS.passage_shares:
        is_there = np.abs(share - middle) < DETAILS.passage_width
        is_there &= through < lattice.strategy.max_cost_ratio * best
        nodes = np.flatnonzero(is_there)
        costs = np.where(is_there, through, np.inf).reshape(lattice.price.shape)
        padded = np.pad(costs, 2, constant_values=np.inf)  # as far as the cube reaches
        strides = np.array([padded.shape[1] * padded.shape[2], padded.shape[2], 1])
        at = (np.column_stack(np.unravel_index(nodes, costs.shape)) + 2) @ strides
        least = through[nodes]
        for offset in (CUBE @ strides).tolist():
            kept = padded.take(at + offset) >= least
            nodes, at, least = nodes[kept], at[kept], least[kept]
        chosen += zip(least.tolist(), nodes.tolist(), strict=True)
    return (node for _, node in sorted(chosen))


def _least_around(values: NDArray[Any], reach: int) -> NDArray[Any]:
    """Return the least value in the cube around each node, up to `reach` steps away."""
    for axis, count in enumerate(values.shape):
        padded = np.pad(values, [(reach * (k == axis),) * 2 for k in range(3)], constant_values=np.inf)
        values = np.minimum.reduce([padded.take(range(k, k + count), axis) for k in range(2 * reach + 1)])
    return values


def _trace(before: NDArray[np.int64], node: int) -> list[int]:
    passed = []
    while node >= 0:
        passed.append(node)
        node = before.item(node)
    return passed
