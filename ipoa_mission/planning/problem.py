"""The path as a point in a search space: how a decision vector becomes control points, and what it costs.

All encodings are linear, so nodes of a whole generation of candidates are one matrix product. In `chord` and `sine`
the origin of the space is a path that is good already (a straight line if nothing better is known): pelicans move by
multiplying coordinates, which draws them towards the origin.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, leg_lengths
from ipoa_mission.optimize.search import Box, Candidates, Costs
from ipoa_mission.planning.cost import rules_of
from ipoa_mission.planning.obstacle_grid import STEEP, ObstacleGrid, Rules, obstacle_grid_of
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.spline import DEGREE, Spline, basis, even_basis
from ipoa_mission.scenario.path_limits import Limits

Matrix: TypeAlias = NDArray[np.float64]
ALL = slice(None)
MIN_SPANS_BETWEEN_VIA = 2.0  # spans of the spline between two via points, at least
COMPARING_FACTOR = 4  # times as many nodes when curves are compared
UNSAFE = 1e6  # a curve that costs more than this breaks a limit
ROUGH_STEEPNESS = 1.02  # how much steeper than allowed a rough curve may be
NARROW, MOST = 0.3, 4000  # curves are compared by legs as short as this [m], if so many are enough
LENIENCE = 0.1  # what a rough curve may break a limit by; the fine polish mends it [m]
FULL_SIZE = 50.0  # on a shorter way over all places, what is given in meters is smaller in proportion [m]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A curve, and the parameters (k,) at which it passes the via points."""

    curve: Spline
    via_at: Vector


@dataclass(frozen=True, eq=False)
class Encoding:
    """A search space: candidates x (m, D) in `box` stand for control points origin + x @ matrix, (m, n, 3)."""

    origin: Points  # (n, 3)
    matrix: Matrix  # (D, n, 3)
    box: Box
    via_at: Vector

    def curve(self, x: Vector) -> Spline:
        """The curve of one candidate (D,)."""
        return Spline(self.origin + np.tensordot(x, self.matrix, 1))


@dataclass(frozen=True, eq=False)
class PreparedProblem:
    """A path problem made ready for many evaluations; `nodes` is the number at which the search looks at a curve."""

    task: PathTask
    limits: Limits
    chart: ObstacleGrid
    rules: Rules
    nodes: int

    @property
    def scale(self) -> float:
        """What is usual in meters counts so many times in this scene: 1, or less where all is small."""
        return min(float(leg_lengths(self.task.places).sum()) / FULL_SIZE, 1.0)

    @property
    def climbs_limited(self) -> bool:
        """Whether climb or descent are limited."""
        return min(self.rules.climb, self.rules.descent) < STEEP

    def costs(self, encoding: Encoding) -> Callable[[Candidates], Costs]:
        """The cost function of a search: candidates (m, D) to costs (m,) of that part of the path which they change."""
        from ipoa_mission.planning._kernels import path_costs  # compiled, or loaded, when the first path is planned

        look = even_basis(len(encoding.origin), self.nodes)
        changed = np.nonzero(look @ np.abs(encoding.matrix).max(axis=(0, 2)))[0]
        look = look[max(changed[0] - 2, 0) : changed[-1] + 3]  # legs and angles at the rim change too
        some = np.nonzero(look.any(axis=0))[0]
        look = np.ascontiguousarray(look[:, some].T)
        start, span = _by_axis(encoding.origin[None, some])[0], _by_axis(encoding.matrix[:, some])

        def cost(x: Candidates) -> Costs:
            control = (x @ span + start).reshape(-1, len(some))
            return np.asarray(path_costs((control @ look).reshape(len(x), 3, -1), self.chart, self.rules))

        return cost

    def survey(self, points: Points) -> tuple[Vector, Vector]:
        """What points (n, 3) have more than is required of everything solid [m], and the threat there a meter, (n,)."""
        from ipoa_mission.planning._kernels import survey

        return survey(np.ascontiguousarray(points), self.chart, self.rules)  # type: ignore[no-any-return]

    def cost(self, trail: Candidate) -> float:
        """The cost of one curve, looked at closely, forgiven a limit broken a little: to compare rough curves by."""
        from ipoa_mission.planning._kernels import path_costs

        nodes = trail.curve.points(np.linspace(0.0, 1.0, COMPARING_FACTOR * self.nodes))
        legs = leg_lengths(nodes)
        lenience = LENIENCE * self.scale
        longest = max(1.5 * self.limits.obstacle_distance, NARROW * self.scale)
        if legs.max() > longest:  # lest it skip a thin wall
            traveled = np.concatenate([[0.0], np.cumsum(legs)])
            even = np.linspace(0.0, traveled[-1], int(np.clip(traveled[-1] / longest, len(nodes), MOST)))
            nodes = np.column_stack([np.interp(even, traveled, nodes[:, k]) for k in range(3)])
        chart = self.chart._replace(lower=self.chart.lower - lenience, upper=self.chart.upper + lenience)
        rules = self.rules._replace(
            clearance=self.rules.clearance - lenience,
            height=self.rules.height - lenience,
            climb=self.rules.climb * ROUGH_STEEPNESS,
            descent=self.rules.descent * ROUGH_STEEPNESS,
            collision=UNSAFE,
        )
        return float(path_costs(np.ascontiguousarray(nodes.T)[None], chart, rules)[0])


def prepare(task: PathTask) -> PreparedProblem:
    """The problem that a task poses, made ready."""
    limits, rules = task.limits, rules_of(task)
    reach = max(limits.obstacle_distance, rules.d_safe + rules.radius) + 0.5
    return PreparedProblem(task, limits, obstacle_grid_of(task.airspace, limits, reach), rules, _nodes(task))


def follow(guide: Points, inner: int, task: PathTask, shares: Vector | None = None) -> Candidate:
    """A curve with `inner` control points between its ends that follows a polyline (k, 3) over all via points.

    They are evenly apart along it, or as many on each leg as its share (k-1,) of the sum.
    """
    traveled = np.concatenate([[0.0], np.cumsum(leg_lengths(guide) if shares is None else shares)])
    stops = [0, *corners(guide, task.places[1:-1]), len(guide) - 1]
    legs = np.diff(traveled[stops]) / traveled[-1]
    least = min(MIN_SPANS_BETWEEN_VIA / (inner - 1), 0.5 / len(legs))  # or via points would share control points
    legs = np.maximum(legs, least)
    reached = np.concatenate([[0.0], np.cumsum(legs) / legs.sum()])
    progress = np.interp(traveled, traveled[stops], reached)
    control = np.column_stack([np.interp(_greville(inner + 2), progress, guide[:, k]) for k in range(3)])
    return pinned(Candidate(Spline(control), reached[1:-1]), task)


def pinned(trail: Candidate, task: PathTask) -> Candidate:
    """The curve put right so that it passes the via points exactly: the control point nearest to each gives way."""
    lift, project, _ = _pins(trail, task)
    return Candidate(Spline(lift + project @ trail.curve.control), trail.via_at)


def refine(trail: Candidate) -> Candidate:
    """The same curve with twice as many spans."""
    return Candidate(trail.curve.refined(), trail.via_at)


def null_space(trail: Candidate, task: PathTask, part: slice = ALL) -> Matrix:
    """How a part of the inner control points may move if ends and via points stay: a basis of those ways, (n, f)."""
    _, project, moved = _pins(trail, task)
    varied = np.setdiff1d(np.arange(1, len(project) - 1)[part], moved)
    return np.ascontiguousarray(project[:, varied])


def encode(name: str, guide: Points, inner: int, spread: float, task: PathTask) -> Encoding:
    """The search space `name` round a polyline (k, 3), with `inner` control points between the ends."""
    return surround(name, follow(guide, inner, task), spread, task)


def surround(name: str, around: Candidate, spread: float, task: PathTask, part: slice = ALL) -> Encoding:
    """The search space `name`, `spread` [m] wide in each direction round a curve, or round a part of it.

    `absolute` varies the control points themselves within the bounds, and has no use for the curve; `chord` varies
    their offsets aside and upwards from it; `sine` the amplitudes of sine waves of such offsets, the k-th scaled by
    1 / k. `part` says which of the inner control points are varied.
    """
    control = around.curve.control
    varied = np.arange(1, len(control) - 1)[part]
    n, inner = len(control), len(varied)
    if name == "absolute":
        lower, upper = np.asarray(task.airspace.bounds.lower), np.asarray(task.airspace.bounds.upper)
        origin, box = control.copy(), Box(np.tile(lower, inner), np.tile(upper, inner))
        origin[varied] = 0.0
        matrix = np.zeros((inner, 3, n, 3))
        for k in range(3):
            matrix[np.arange(inner), k, varied, k] = 1.0
    else:
        shapes = np.eye(inner) if name == "chord" else _waves(inner)
        origin, box = control, Box(np.full(2 * inner, -spread), np.full(2 * inner, spread))
        matrix = np.zeros((inner, 2, n, 3))
        matrix[:, :, varied] = np.einsum("mi,iak->maik", shapes, _axes(control)[part])
    lift, project, _ = _pins(around, task)
    matrix = np.einsum("ij,djk->dik", project, matrix.reshape(-1, n, 3))
    return Encoding(lift + project @ origin, matrix, box, around.via_at)


def _pins(trail: Candidate, task: PathTask) -> tuple[Points, Matrix, NDArray[np.intp]]:
    """The map control -> lift + project @ control that puts via points right, and which control points give way."""
    n, via = len(trail.curve.control), task.places[1:-1]
    if not len(via):
        return np.zeros((n, 3)), np.eye(n), np.zeros(0, int)
    rows = basis(n, trail.via_at)
    weight, moved = rows.copy(), list[int]()
    weight[:, [0, -1]] = -1.0
    for row in weight:  # the inner control point with the most say, no two the same
        row[moved] = -1.0
        moved.append(int(np.argmax(row)))
    lift = np.zeros((n, len(via)))
    lift[moved] = np.linalg.inv(rows[:, moved])
    return lift @ via, np.eye(n) - lift @ rows, np.array(moved)


def _by_axis(points: Matrix) -> Matrix:
    """(m, n, 3) as (m, 3 n): all east, then all north, then all up."""
    return np.ascontiguousarray(points.transpose(0, 2, 1)).reshape(len(points), -1)


def _greville(n: int) -> Vector:
    """The progress at which each control point has its say: these make a straight guide a straight, even curve."""
    knots = np.concatenate([np.zeros(DEGREE), np.linspace(0.0, 1.0, n - DEGREE + 1), np.ones(DEGREE)])
    return np.array([knots[i + 1 : i + 1 + DEGREE].mean() for i in range(n)])


def _axes(control: Points) -> Matrix:
    """Unit vectors aside and upwards at each inner control point, (n - 2, 2, 3); level ones where the way is steep."""
    ahead = control[2:] - control[:-2]
    level = np.hypot(ahead[:, 0], ahead[:, 1])
    steep = level <= 1e-6 * np.abs(ahead[:, 2])
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0], 0 * level]) / np.where(steep, 1.0, level)[:, None]
    aside[steep] = (1.0, 0.0, 0.0)
    upwards = np.where(steep[:, None], (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return np.stack([aside, upwards], axis=1)


def _waves(inner: int) -> Matrix:
    """Sine modes at the inner control points: sin(k pi t) / k for k = 1, 2, ..., (modes, points)."""
    k = np.arange(1, inner + 1)[:, None]
    return np.asarray(np.sin(np.pi * k * _greville(inner + 2)[1:-1]) / k)


def corners(guide: Points, via: Points) -> list[int]:
    """At which corners a guide passes the via points, in order."""
    corners, after = list[int](), 1
    for place in via:
        after += int(np.argmin(np.linalg.norm(guide[after:-1] - place, axis=1)))
        corners.append(after)
        after += 1
    return corners


def _nodes(task: PathTask) -> int:
    direct = float(np.linalg.norm(task.places[-1] - task.places[0]))
    if task.planning.planner == "paper":
        return task.planning.samples
    return int(np.clip(direct / max(2 * task.limits.obstacle_distance, 2.0), task.planning.samples, 600))
