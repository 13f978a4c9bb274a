"""Cost of a path, eqs. (4)-(10): length, turns, and threat of near obstacles.

By default the threat is integrated over arc length; with `form = "nodes"` it is summed as in the paper, in degrees.
"""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.geometry import Points, Vector, climb_angles, leg_lengths, turning_angles
from ipoa_mission.planning.obstacle_grid import LEAST, UNLIMITED, Rules
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.spline import Spline

COST_STEP = 0.05  # integration step [m]
FULL_TURN_DEG = 360.0
STEPS_PER_SPAN = 16  # of the curve


@dataclass(frozen=True)
class CostTerms:
    length: float
    """W1 [m]."""
    turning_deg: float
    """Sum of the turning angles of W2."""
    climbing_deg: float
    """Sum of the changes in climb angle of W2."""
    threat: float
    """W3."""
    total: float


def path_cost(nodes: Points, task: PathTask) -> CostTerms:
    """Return the cost of nodes (n, 3): a sum, or a trapezoidal integral."""
    turning, climbing = turning_angles(nodes), np.diff(climb_angles(nodes))
    threat = float(threats(nodes, task) @ node_weights(nodes, task.cost.form == "nodes"))
    w1, w2, w3 = task.cost.omega
    length, turning_deg = float(leg_lengths(nodes).sum()), float(np.degrees(turning.sum()))
    climbing_deg = float(np.degrees(np.abs(climbing).sum()))
    turns = task.cost.a1 * turning_deg + task.cost.a2 * climbing_deg
    return CostTerms(length, turning_deg, climbing_deg, threat, w1 * length + w2 * turns + w3 * threat)


def curve_cost(curve: Spline, task: PathTask) -> CostTerms:
    """Return the cost of a curve: over `planning.samples` nodes, or an integral."""
    if task.cost.form == "nodes":
        return path_cost(curve.points(np.linspace(0.0, 1.0, task.planning.samples)), task)
    spans = np.linspace(0.0, 1.0, STEPS_PER_SPAN * curve.spans + 1)
    u = np.union1d(curve.parameters(_steps(curve)), spans)
    nodes, velocity, between = curve.points(u), curve.points(u, 1), curve.points((u[:-1] + u[1:]) / 2, 1)
    cost, turned = path_cost(nodes, task), FULL_TURN_DEG * _doublings(nodes, velocity, between)
    total = cost.total + task.cost.omega[1] * task.cost.a1 * turned
    return replace(cost, turning_deg=cost.turning_deg + turned, total=total) if turned else cost


def _doublings(nodes: Points, velocity: Points, between: Points) -> int:
    """Count how often a curve doubles back within legs between `nodes` (k, 3), against its `velocity`, a parabola.

    `between` (k-1, 3): velocity mid-leg.
    """
    legs = np.diff(nodes, axis=0)
    start, middle, end = (np.einsum("kj,kj->k", at, legs) for at in (velocity[:-1], between, velocity[1:]))
    slope, bend = 4 * middle - 3 * start - end, 2 * (start - 2 * middle + end)
    lowest = np.clip(np.divide(-slope, 2 * bend, out=np.zeros_like(bend), where=bend > 0), 0.0, 1.0)
    back = np.minimum(np.minimum(start, end), start + (slope + bend * lowest) * lowest) < 0
    back_at = np.nonzero(back)[0]
    runs = np.split(back_at, np.nonzero(np.diff(back_at) > 1)[0] + 1) if len(back_at) else []
    turned = np.append(np.einsum("kj,kj->k", legs[:-1], legs[1:]) < 0, False)
    return sum(not turned[max(run[0] - 1, 0) : run[-1] + 1].any() for run in runs)


def even_cost(curve: Spline, task: PathTask) -> CostTerms:
    """Return the cost by equal steps only: less where the curve turns within a step."""
    return path_cost(curve.sample(_steps(curve)), task) if task.cost.form != "nodes" else curve_cost(curve, task)


def _steps(curve: Spline) -> int:
    return int(np.clip(curve.length / COST_STEP, 1000, 8000))


def threats(nodes: Points, task: PathTask) -> Vector:
    """Return eq. (9)'s summand at each node (n,): lambda / d where the hull is within d_safe."""
    cost, radius = task.cost, task.radius
    total = np.zeros(len(nodes))
    for _, which, distance in task.airspace.near(nodes, cost.d_safe + radius):
        hull = distance - radius
        total[which] += np.where(hull < cost.d_safe, cost.lambda_obs / np.maximum(hull, LEAST), 0.0)
    return total


def node_weights(nodes: Points, per_node: bool) -> Vector:
    """Return the weight of each node (n,): 1, or half the adjacent legs [m]."""
    if per_node:
        return np.ones(len(nodes))
    legs = leg_lengths(nodes)
    return np.asarray((np.append(0.0, legs) + np.append(legs, 0.0)) / 2)


def rules_of(task: PathTask) -> Rules:
    """Return limits and weights for the kernels.

    A broken limit costs ten times the direct distance, and more with depth: a search can escape.
    """
    cost, limits, direct = task.cost, task.limits, float(np.linalg.norm(task.places[-1] - task.places[0]))
    length, turning, threat = cost.omega
    return Rules(
        clearance=limits.obstacle_distance,
        height=limits.height_above_ground,
        ceiling=min(limits.ceiling_above_ground, UNLIMITED),
        climb=_slope(limits.climb_angle),
        descent=_slope(limits.descent_angle),
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
