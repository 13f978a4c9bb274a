"""Map a decision vector to control points and cost.

The cost is that of eqs. (4)-(10), with the threat integrated over arc length; `form = "nodes"` sums it as in the paper.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Matrix, Points, Vector, climb_angles, leg_lengths, polyline_length, turning_angles
from ipoa_mission.optimize.search import Box, Candidates, Costs
from ipoa_mission.planning.obstacle_grid import LEAST, UNLIMITED, ObstacleGrid, Rules, obstacle_grid_of
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.spline import DEGREE, Spline, basis, even_basis, knots_of
from ipoa_mission.scenario.path_limits import Limits

COST_STEP = 0.05  # integration step [m]
FULL_TURN_DEG = 360.0
STEPS_PER_SPAN = 16  # of the curve
ALL = slice(None)
MIN_SPANS_BETWEEN_VIA = 2.0
COMPARING_FACTOR = 4  # of nodes
BREACH_PENALTY = 1e6  # at least
ROUGH_STEEPNESS = 1.02  # on the greatest slope of a rough curve
GREATEST_LEG = 0.3  # for comparing curves [m]
MAX_NODES = 4000
LENIENCE = 0.1  # of a rough curve [m]
FULL_SIZE = 50.0  # of a route; lengths of a shorter one shrink [m]


@dataclass(frozen=True)
class CostTerms:
    length: float  # W1 [m]
    turning_deg: float  # of W2: the sum of turning angles
    climbing_deg: float  # of W2: the sum of changes in climb angle
    threat: float  # W3
    total: float


def path_cost(nodes: Points, task: PathTask) -> CostTerms:
    """Return the cost of nodes (n, 3): a sum, or a trapezoidal integral."""
    length = polyline_length(nodes)
    turning_deg = float(np.degrees(turning_angles(nodes).sum()))
    climbing_deg = float(np.degrees(np.abs(np.diff(climb_angles(nodes))).sum()))
    threat = float(threats(nodes, task) @ node_weights(nodes, task.cost.form == "nodes"))

    w1, w2, w3 = task.cost.omega
    turns = task.cost.a1 * turning_deg + task.cost.a2 * climbing_deg
    return CostTerms(length, turning_deg, climbing_deg, threat, w1 * length + w2 * turns + w3 * threat)


def curve_cost(curve: Spline, task: PathTask) -> CostTerms:
    """Return the cost of a curve: over `planning.samples` nodes, or an integral."""
    if task.cost.form == "nodes":
        return path_cost(curve.points(np.linspace(0.0, 1.0, task.planning.samples)), task)
    u = np.union1d(curve.parameters(_steps(curve)), np.linspace(0.0, 1.0, STEPS_PER_SPAN * curve.spans + 1))
    nodes = curve.points(u)
    velocity = curve.points(u, 1)
    between = curve.points((u[:-1] + u[1:]) / 2, 1)
    cost = path_cost(nodes, task)
    turned = FULL_TURN_DEG * _doublings(nodes, velocity, between)
    total = cost.total + task.cost.omega[1] * task.cost.a1 * turned
    return replace(cost, turning_deg=cost.turning_deg + turned, total=total) if turned else cost


def _doublings(nodes: Points, velocity: Points, between: Points) -> int:
    """Count doublings back within legs between `nodes` (k, 3); `between` (k-1, 3): mid-leg velocity."""
    legs = np.diff(nodes, axis=0)
    start, middle, end = (np.einsum("kj,kj->k", at, legs) for at in (velocity[:-1], between, velocity[1:]))
    slope = 4 * middle - 3 * start - end
    bend = 2 * (start - 2 * middle + end)
    lowest = np.clip(np.divide(-slope, 2 * bend, out=np.zeros_like(bend), where=bend > 0), 0.0, 1.0)
    back = np.minimum(np.minimum(start, end), start + (slope + bend * lowest) * lowest) < 0
    back_at = np.nonzero(back)[0]
    runs = np.split(back_at, np.nonzero(np.diff(back_at) > 1)[0] + 1) if len(back_at) else []
    turned = np.append(np.einsum("kj,kj->k", legs[:-1], legs[1:]) < 0, False)
    return sum(not turned[max(run[0] - 1, 0) : run[-1] + 1].any() for run in runs)


def even_cost(curve: Spline, task: PathTask) -> CostTerms:
    """Return the cost by equal steps only: too little where the curve turns within a step."""
    return path_cost(curve.sample(_steps(curve)), task) if task.cost.form != "nodes" else curve_cost(curve, task)


def _steps(curve: Spline) -> int:
    return int(np.clip(curve.length / COST_STEP, 1000, 8000))


def threats(nodes: Points, task: PathTask) -> Vector:
    """Return eq. (9)'s summand at each node (n,): lambda / d where the hull is within d_safe."""
    cost = task.cost
    radius = task.radius
    total = np.zeros(len(nodes))
    for _, near, distance in task.airspace.near(nodes, cost.d_safe + radius):
        hull = distance - radius
        total[near] += np.where(hull < cost.d_safe, cost.lambda_obs / np.maximum(hull, LEAST), 0.0)
    return total


def node_weights(nodes: Points, per_node: bool) -> Vector:
    """Return the weight of each node (n,): 1, or half the adjacent legs [m]."""
    if per_node:
        return np.ones(len(nodes))
    legs = leg_lengths(nodes)
    return np.asarray((np.append(0.0, legs) + np.append(legs, 0.0)) / 2)


def rules_of(task: PathTask) -> Rules:
    """Return limits and weights for the kernels."""
    cost = task.cost
    limits = task.limits
    direct = float(np.linalg.norm(task.places[-1] - task.places[0]))
    length, turning, threat = cost.omega
    return Rules(
        clearance=limits.obstacle_distance,
        height=limits.height_above_ground,
        ceiling=min(limits.ceiling_above_ground, UNLIMITED),
        climb_slope=_slope(limits.climb_angle),
        descent_slope=_slope(limits.descent_angle),
        radius=task.radius,
        d_safe=cost.d_safe,
        length=length,
        turning=float(np.degrees(turning * cost.a1)),
        climbing=float(np.degrees(turning * cost.a2)),
        threat=threat * cost.lambda_obs,
        per_node=cost.form == "nodes",
        collision=100.0 + 10.0 * direct,
        depth=10.0,
    )


def _slope(angle: float) -> float:
    return float(np.tan(angle)) if angle < np.pi / 2 else UNLIMITED


@dataclass(frozen=True, eq=False)
class Candidate:
    curve: Spline
    via_at: Vector


@dataclass(frozen=True, eq=False)
class Encoding:
    """Candidates x (m, D) in `box` map to control points origin + x @ matrix, (m, n, 3)."""

    origin: Points
    matrix: NDArray[np.float64]  # (D, n, 3)
    box: Box

    def curve(self, x: Vector) -> Spline:
        return Spline(self.origin + np.tensordot(x, self.matrix, 1))


@dataclass(frozen=True, eq=False)
class PreparedProblem:
    task: PathTask
    limits: Limits
    grid: ObstacleGrid
    rules: Rules
    nodes: int

    @property
    def scale(self) -> float:
        return min(polyline_length(self.task.places) / FULL_SIZE, 1.0)

    @property
    def climbs_limited(self) -> bool:
        return min(self.rules.climb_slope, self.rules.descent_slope) < UNLIMITED

    @property
    def region(self) -> tuple[Vector, Vector]:
        """Corners of the bounds, cut just above all obstacles and ground."""
        airspace, stops = self.task.airspace, self.task.places
        tops = [obstacle.bounds[1, 2] for obstacle in airspace.obstacles]
        above = 2 * max(self.limits.obstacle_distance, self.rules.d_safe)
        highest = max([*tops, float(self.grid.heights.max()), float(stops[:, 2].max())]) + above
        lower = np.array(airspace.bounds.lower, float)
        upper = np.array(airspace.bounds.upper, float)
        lowest = max(lower[2], float(self.grid.heights.min()) + min(self.limits.height_above_ground, 1.0))
        lower[2] = min(lowest, float(stops[:, 2].min()))
        upper[2] = min(upper[2], highest)
        return lower, upper

    def costs(self, encoding: Encoding) -> Callable[[Candidates], Costs]:
        """Return the cost function of a search: candidates (m, D) to costs (m,) of the changed part."""
        from ipoa_mission.planning._kernels import path_costs  # compiled, or loaded, on first use

        node_basis = even_basis(len(encoding.origin), self.nodes)
        changed = np.nonzero(node_basis @ np.abs(encoding.matrix).max(axis=(0, 2)))[0]
        node_basis = node_basis[max(changed[0] - 2, 0) : changed[-1] + 3]
        active = np.nonzero(node_basis.any(axis=0))[0]
        node_basis = np.ascontiguousarray(node_basis[:, active].T)
        start = _by_axis(encoding.origin[None, active])[0]
        span = _by_axis(encoding.matrix[:, active])

        def cost(x: Candidates) -> Costs:
            control = (x @ span + start).reshape(-1, len(active))
            return np.asarray(path_costs((control @ node_basis).reshape(len(x), 3, -1), self.grid, self.rules))

        return cost

    def slack_and_threat(self, points: Points) -> tuple[Vector, Vector]:
        """Return slack [m] and threat per meter of points (n, 3), (n,) each."""
        from ipoa_mission.planning._kernels import slack_and_threat

        return slack_and_threat(np.ascontiguousarray(points), self.grid, self.rules)  # type: ignore[no-any-return]

    def cost(self, candidate: Candidate) -> float:
        """Return the cost of one finely sampled curve; breaches below `LENIENCE` are forgiven."""
        from ipoa_mission.planning._kernels import path_costs

        nodes = candidate.curve.even_points(COMPARING_FACTOR * self.nodes)
        legs = leg_lengths(nodes)
        lenience = LENIENCE * self.scale
        longest = max(1.5 * self.limits.obstacle_distance, GREATEST_LEG * self.scale)
        if legs.max() > longest:  # skips a thin wall
            traveled = np.concatenate([[0.0], np.cumsum(legs)])
            even = np.linspace(0.0, traveled[-1], int(np.clip(traveled[-1] / longest, len(nodes), MAX_NODES)))
            nodes = np.column_stack([np.interp(even, traveled, nodes[:, k]) for k in range(3)])
        grid = self.grid._replace(lower=self.grid.lower - lenience, upper=self.grid.upper + lenience)
        rules = self.rules._replace(
            clearance=self.rules.clearance - lenience,
            height=self.rules.height - lenience,
            climb_slope=self.rules.climb_slope * ROUGH_STEEPNESS,
            descent_slope=self.rules.descent_slope * ROUGH_STEEPNESS,
            collision=BREACH_PENALTY,
        )
        return float(path_costs(np.ascontiguousarray(nodes.T)[None], grid, rules)[0])


def without_penalty(costs: Costs) -> Costs:
    return costs % BREACH_PENALTY  # costs without a breach are unchanged


def prepare(task: PathTask) -> PreparedProblem:
    limits = task.limits
    rules = rules_of(task)
    reach = max(limits.obstacle_distance, rules.d_safe + rules.radius) + 0.5
    return PreparedProblem(task, limits, obstacle_grid_of(task.airspace, limits, reach), rules, _nodes(task))


def follow(guide: Points, inner: int, task: PathTask, shares: Vector | None = None) -> Candidate:
    """Return a curve that follows a polyline (k, 3), evenly or by shares (k-1,) on its legs."""
    traveled = np.concatenate([[0.0], np.cumsum(leg_lengths(guide) if shares is None else shares)])
    stops = [0, *via_indices(guide, task.places[1:-1]), len(guide) - 1]
    legs = np.diff(traveled[stops]) / traveled[-1]
    least = min(MIN_SPANS_BETWEEN_VIA / (inner - 1), 0.5 / len(legs))  # else via points would share control points
    legs = np.maximum(legs, least)
    reached = np.concatenate([[0.0], np.cumsum(legs) / legs.sum()])
    progress = np.interp(traveled, traveled[stops], reached)
    control = np.column_stack([np.interp(_greville(inner + 2), progress, guide[:, k]) for k in range(3)])
    return pin_to_via(Candidate(Spline(control), reached[1:-1]), task)


def pin_to_via(candidate: Candidate, task: PathTask) -> Candidate:
    lift, project, _ = _pins(candidate, task)
    return Candidate(Spline(lift + project @ candidate.curve.control), candidate.via_at)


def refine(candidate: Candidate) -> Candidate:
    return Candidate(candidate.curve.refined(), candidate.via_at)


def null_space(candidate: Candidate, task: PathTask, part: slice = ALL) -> Matrix:
    """Return a basis (n, f) of the moves that keep ends and via points."""
    _, project, moved = _pins(candidate, task)
    return np.ascontiguousarray(project[:, np.setdiff1d(np.arange(1, len(project) - 1)[part], moved)])


def surround(name: str, around: Candidate, half_width: float, task: PathTask, part: slice = ALL) -> Encoding:
    """Return the search space `name`, `half_width` [m] in each direction, around a curve or a `part` of it.

    `absolute` varies control points within the bounds, `chord` their lateral and vertical offsets from the curve,
    `sine` amplitudes of sine waves of such offsets.
    """
    control = around.curve.control
    varied = np.arange(1, len(control) - 1)[part]
    n = len(control)
    inner = len(varied)
    if name == "absolute":
        lower, upper = np.asarray(task.airspace.bounds.lower), np.asarray(task.airspace.bounds.upper)
        origin = control.copy()
        box = Box(np.tile(lower, inner), np.tile(upper, inner))
        origin[varied] = 0.0
        matrix = np.zeros((inner, 3, n, 3))
        for k in range(3):
            matrix[np.arange(inner), k, varied, k] = 1.0
    else:
        shapes = np.eye(inner) if name == "chord" else _waves(inner)
        origin = control
        box = Box(np.full(2 * inner, -half_width), np.full(2 * inner, half_width))
        matrix = np.zeros((inner, 2, n, 3))
        matrix[:, :, varied] = np.einsum("mi,iak->maik", shapes, _axes(control)[part])
    lift, project, _ = _pins(around, task)
    moves = matrix.reshape(-1, n, 3)
    if len(task.places) > 2:
        moves = np.einsum("ij,djk->dik", project, moves)
    return Encoding(lift + project @ origin, moves, box)


def _pins(candidate: Candidate, task: PathTask) -> tuple[Points, Matrix, NDArray[np.intp]]:
    """Return the map lift + project @ control onto the via points, and the moved control points."""
    n = len(candidate.curve.control)
    via = task.places[1:-1]
    if not len(via):
        return np.zeros((n, 3)), np.eye(n), np.zeros(0, int)
    rows = basis(n, candidate.via_at)
    weight = rows.copy()
    moved = list[int]()
    weight[:, [0, -1]] = -1.0
    for row in weight:
        row[moved] = -1.0
        moved.append(int(np.argmax(row)))
    lift = np.zeros((n, len(via)))
    lift[moved] = np.linalg.inv(rows[:, moved])
    return lift @ via, np.eye(n) - lift @ rows, np.array(moved)


def _by_axis(points: NDArray[np.float64]) -> Matrix:
    """Reorder (m, n, 3) to (m, 3 n): all east, then north, then up."""
    return np.ascontiguousarray(points.transpose(0, 2, 1)).reshape(len(points), -1)


@lru_cache(maxsize=64)
def _greville(n: int) -> Vector:
    return np.lib.stride_tricks.sliding_window_view(knots_of(n)[1:-1], DEGREE).mean(axis=1)  # type: ignore[no-any-return]


def _axes(control: Points) -> NDArray[np.float64]:
    """Return lateral and upward unit vectors, (n - 2, 2, 3)."""
    ahead = control[2:] - control[:-2]
    level = np.hypot(ahead[:, 0], ahead[:, 1])
    steep = level <= 1e-6 * np.abs(ahead[:, 2])
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0], 0 * level]) / np.where(steep, 1.0, level)[:, None]
    aside[steep] = (1.0, 0.0, 0.0)
    return np.stack([aside, np.where(steep[:, None], (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))], axis=1)


def _waves(inner: int) -> Matrix:
    """Return sine modes sin(k pi t) / k, (modes, points)."""
    k = np.arange(1, inner + 1)[:, None]
    return np.asarray(np.sin(np.pi * k * _greville(inner + 2)[1:-1]) / k)


def via_indices(guide: Points, via: Points) -> list[int]:
    """Return ascending indices of inner points (n, 3) with the least sum of distances to places (m, 3)."""
    least = np.zeros(len(guide) - 2)
    sums = list[Vector]()
    for place in via:
        sums.append(np.linalg.norm(guide[1:-1] - place, axis=1) + least)
        least = np.append(np.inf, np.minimum.accumulate(sums[-1])[:-1])
    indices = list[int]()
    end = len(guide) - 2
    for distances in reversed(sums):
        end = int(np.argmin(distances[:end]))
        indices.append(1 + end)
    return indices[::-1]


def _nodes(task: PathTask) -> int:
    direct = float(np.linalg.norm(task.places[-1] - task.places[0]))
    if task.planning.planner == "paper":
        return task.planning.samples
    return int(np.clip(direct / max(2 * task.limits.obstacle_distance, 2.0), task.planning.samples, 600))
