"""The path as a point in a search space: how a decision vector becomes control points, and what it costs.

All encodings are linear, so nodes of a whole generation of candidates are one matrix product. In `chord` and `sine`
the origin of the space is a guide, a path that is good already (a straight line if nothing better is known): pelicans
move by multiplying coordinates, which draws them towards the origin.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, leg_lengths
from ipoa_mission.optimize.search import Box, Candidates, Costs
from ipoa_mission.planning.chart import Chart, Rules, chart_of
from ipoa_mission.planning.cost import rules_of
from ipoa_mission.planning.limits import Limits, limits_of
from ipoa_mission.planning.spline import DEGREE, Spline, basis, even_basis
from ipoa_mission.scenario import Scenario

Matrix: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Encoding:
    """A search space: candidates x (m, D) in `box` stand for control points origin + x @ matrix, (m, n, 3)."""

    origin: Matrix  # (n, 3)
    matrix: Matrix  # (D, n, 3)
    box: Box

    def curve(self, x: Vector) -> Spline:
        """The curve of one candidate (D,)."""
        return Spline(self.origin + np.tensordot(x, self.matrix, 1))


@dataclass(frozen=True, eq=False)
class PathProblem:
    """A scenario made ready for many evaluations; `nodes` is the number at which the search looks at a curve."""

    scenario: Scenario
    limits: Limits
    chart: Chart
    rules: Rules
    nodes: int

    def costs(self, encoding: Encoding) -> Callable[[Candidates], Costs]:
        """The cost function of a search: candidates (m, D) to costs (m,)."""
        from ipoa_mission.planning._kernels import path_costs  # compiled, or loaded, when the first path is planned

        look = np.ascontiguousarray(even_basis(len(encoding.origin), self.nodes).T)
        start, span = _by_axis(encoding.origin[None])[0], _by_axis(encoding.matrix)
        n = len(encoding.origin)

        def cost(x: Candidates) -> Costs:
            control = (x @ span + start).reshape(-1, n)
            return np.asarray(path_costs((control @ look).reshape(len(x), 3, -1), self.chart, self.rules))

        return cost


def pose(scenario: Scenario) -> PathProblem:
    """The problem that a scenario poses."""
    limits = limits_of(scenario)
    rules = rules_of(scenario, limits)
    reach = max(limits.obstacle_distance, rules.d_safe + rules.radius) + 0.5
    return PathProblem(scenario, limits, chart_of(scenario.airspace, limits, reach), rules, _nodes(scenario, limits))


def encode(name: str, guide: Points, inner: int, spread: float, scenario: Scenario) -> Encoding:
    """The search space `name` with `inner` control points between the ends of `guide` (k, 3), `spread` [m] wide.

    `absolute` varies the points themselves within the bounds, and has no use for the guide; `chord` varies their
    offsets aside and upwards from the guide; `sine` the amplitudes of sine waves of such offsets, the k-th scaled
    by 1 / k.
    """
    n = inner + 2
    if name == "absolute":
        lower, upper = np.asarray(scenario.airspace.bounds.lower), np.asarray(scenario.airspace.bounds.upper)
        origin = np.zeros((n, 3))
        origin[[0, -1]] = guide[[0, -1]]
        matrix = np.zeros((3 * inner, n, 3))
        matrix[:, 1:-1, :].reshape(3 * inner, -1)[:] = np.eye(3 * inner)
        return _through(Encoding(origin, matrix, Box(np.tile(lower, inner), np.tile(upper, inner))), guide, scenario)
    progress = _greville(n)
    origin, axes = _along(guide, progress)
    shapes = np.eye(inner) if name == "chord" else _waves(progress[1:-1])
    matrix = np.zeros((2 * inner, n, 3))
    matrix[:, 1:-1, :] = np.einsum("mi,iak->amik", shapes, axes[1:-1]).reshape(2 * inner, inner, 3)
    width = np.full(2 * inner, spread)
    return _through(Encoding(origin, matrix, Box(-width, width)), guide, scenario)


def pins(scenario: Scenario, guide: Points, n: int) -> tuple[Matrix, Matrix]:
    """How n control points are put right so that the curve passes the via points: control -> E + P @ control.

    At a via point's progress along the guide, the nearest control point gives way. E is (n, 3), P is (n, n).
    """
    via = scenario.via_points
    if not len(via):
        return np.zeros((n, 3)), np.eye(n)
    rows = basis(n, _progress(guide, via))
    moved = _distinct(rows)
    lift = np.zeros((n, len(via)))
    lift[moved] = np.linalg.inv(rows[:, moved])
    return lift @ via, np.eye(n) - lift @ rows


def guide_control(guide: Points, inner: int) -> Points:
    """Control points (inner + 2, 3) of a curve that follows a guide (k, 3)."""
    return _along(guide, _greville(inner + 2))[0]


def _through(encoding: Encoding, guide: Points, scenario: Scenario) -> Encoding:
    shift, project = pins(scenario, guide, len(encoding.origin))
    return Encoding(shift + project @ encoding.origin, np.einsum("ij,djk->dik", project, encoding.matrix), encoding.box)


def _by_axis(points: Matrix) -> Matrix:
    """(m, n, 3) as (m, 3 n): all east, then all north, then all up."""
    return np.ascontiguousarray(points.transpose(0, 2, 1)).reshape(len(points), -1)


def _greville(n: int) -> Vector:
    """The progress at which each control point has its say: these make a straight guide a straight, even curve."""
    knots = np.concatenate([np.zeros(DEGREE), np.linspace(0.0, 1.0, n - DEGREE + 1), np.ones(DEGREE)])
    return np.array([knots[i + 1 : i + 1 + DEGREE].mean() for i in range(n)])


def _along(guide: Points, progress: Vector) -> tuple[Points, Matrix]:
    """Points (n, 3) on a guide at the given shares of its length, and the axes aside and upwards there, (n, 2, 3)."""
    travelled = np.concatenate([[0.0], np.cumsum(leg_lengths(guide))])
    share = travelled / travelled[-1]
    points = np.column_stack([np.interp(progress, share, guide[:, k]) for k in range(3)])
    leg = np.clip(np.searchsorted(share, progress, side="right") - 1, 0, len(guide) - 2)
    ahead = np.diff(guide, axis=0)[leg] + 1e-9 * (guide[-1] - guide[0])
    level = np.hypot(ahead[:, 0], ahead[:, 1])
    steep = level < 1e-6 * np.linalg.norm(ahead, axis=1)
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(leg))]) / np.where(steep, 1.0, level)[:, None]
    aside[steep] = (1.0, 0.0, 0.0)
    upwards = np.tile([0.0, 0.0, 1.0], (len(leg), 1))
    upwards[steep] = (0.0, 1.0, 0.0)
    return points, np.stack([aside, upwards], axis=1)


def _waves(progress: Vector) -> Matrix:
    """The sine modes at some shares of the way: sin(k pi t) / k for k = 1, 2, ..., (modes, points)."""
    k = np.arange(1, len(progress) + 1)[:, None]
    return np.asarray(np.sin(np.pi * k * progress) / k)


def _progress(guide: Points, via: Points) -> Vector:
    """The share of a guide's length at which each via point lies; they are corners of it, in order."""
    travelled = np.concatenate([[0.0], np.cumsum(leg_lengths(guide))]) / leg_lengths(guide).sum()
    found, after = [], 1
    for place in via:
        after += int(np.argmin(np.linalg.norm(guide[after:-1] - place, axis=1)))
        found.append(travelled[after])
        after += 1
    return np.array(found)


def _distinct(rows: Matrix) -> NDArray[np.intp]:
    """For each via point the inner control point with the most say at it, no two the same."""
    weight, chosen = rows.copy(), list[int]()
    weight[:, [0, -1]] = -1.0
    for row in weight:
        row[chosen] = -1.0
        chosen.append(int(np.argmax(row)))
    return np.array(chosen)


def _nodes(scenario: Scenario, limits: Limits) -> int:
    direct = float(np.linalg.norm(scenario.goal_point - scenario.start_point))
    if scenario.planning.planner == "paper":
        return scenario.planning.samples
    return int(np.clip(direct / max(2 * limits.obstacle_distance, 2.0), scenario.planning.samples, 600))
