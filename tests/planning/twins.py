"""The kernels in plain NumPy, name for name; they ask the airspace, not its grid."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, climb_angles, leg_lengths, turning_angles
from ipoa_mission.planning.obstacle_grid import LEAST, LEVER, Rules, Smoothing
from ipoa_mission.planning.problem import node_weights
from ipoa_mission.scenario.path_limits import Limits
from ipoa_mission.world.airspace import Airspace


def path_costs(paths: NDArray[np.float64], airspace: Airspace, rules: Rules, limits: Limits) -> Vector:
    """Return costs of paths (m, 3, n), those that break limits included, (m,)."""
    return np.array([_search_cost(path.T, airspace, rules, limits) for path in paths])


def _search_cost(nodes: Points, airspace: Airspace, rules: Rules, limits: Limits) -> float:
    legs, share = leg_lengths(nodes), node_weights(nodes, per_node=False)
    lower, upper = np.asarray(airspace.bounds.lower), np.asarray(airspace.bounds.upper)
    outside = np.maximum(np.maximum(lower - nodes, nodes - upper), 0.0)
    height = nodes[:, 2] - airspace.ground(nodes)
    broken = np.maximum(np.maximum(limits.required_height(nodes) - height, height - rules.ceiling), 0.0)
    if airspace.bounds.footprint is not None:
        broken += np.maximum(airspace.bounds.footprint.distance(nodes[:, :2]), 0.0)
    threat = np.zeros(len(nodes))
    for _, which, distance in airspace.near(nodes, max(rules.clearance, rules.d_safe + rules.radius)):
        broken[which] += np.maximum(rules.clearance - distance, 0.0)
        hull = distance - rules.radius
        threat[which] += np.where(hull < rules.d_safe, 1 / np.maximum(hull, LEAST), 0.0)
    depth = (
        np.maximum(-np.min(_slopes(nodes, rules.climb_slope, rules.descent_slope), axis=0), 0.0).sum()
        + outside.sum() * legs.mean()
        + share @ broken
    )
    cost = rules.length * legs.sum()
    if depth > 0:
        return float(cost + rules.collision + rules.depth * depth)
    cost += rules.turning * turning_angles(nodes).sum()
    cost += rules.climbing * np.abs(np.diff(climb_angles(nodes))).sum()
    return float(cost + rules.threat * threat @ node_weights(nodes, rules.per_node))


def path_model(
    nodes: Points, airspace: Airspace, rules: Rules, limits: Limits, smoothing: Smoothing, mean_leg: float
) -> float:
    """Return the smoothed cost; `mean_leg` is the mean leg, held fixed."""
    legs, share = leg_lengths(nodes), node_weights(nodes, per_node=False)
    angles = np.array([signed_turns(nodes), np.diff(climb_angles(nodes))])
    smooth = np.sqrt(angles**2 + smoothing.bend**2) - smoothing.bend
    value = rules.length * legs.sum() + rules.turning * smooth[0].sum() + rules.climbing * smooth[1].sum()
    value += 0.5 * smoothing.evenness / mean_leg * ((legs - mean_leg) ** 2).sum()
    below = _slopes(nodes, rules.climb_slope - smoothing.flatter, rules.descent_slope - smoothing.flatter)
    steep = below * LEVER / mean_leg
    height = nodes[:, 2] - airspace.ground(nodes)
    lower, upper = np.asarray(airspace.bounds.lower), np.asarray(airspace.bounds.upper)
    higher = replace(limits, height_above_ground=limits.height_above_ground + smoothing.above)  # but not in low zones
    slack = [
        *steep,
        height - higher.required_height(nodes),
        rules.ceiling - smoothing.above - height,
        *(np.minimum(nodes - lower, upper - nodes) - smoothing.aside).T,
    ]
    if airspace.bounds.footprint is not None:
        slack.append(-airspace.bounds.footprint.distance(nodes[:, :2]) - smoothing.aside)
    for obstacle in airspace.obstacles:
        distance = obstacle.distance(nodes)
        hull = distance - rules.radius
        threatened = hull < rules.d_safe
        free = np.where(threatened, np.inf, hull - rules.d_safe)
        slack.append(np.minimum(distance - rules.clearance, free) - smoothing.aside)
        threat = np.where(threatened, rules.threat / np.maximum(hull, LEAST), 0.0)
        value += threat.sum() if rules.per_node else threat @ share
    return float(value + smoothing.barrier * mean_leg * sum(_barrier(s, smoothing).sum() for s in slack))


def _barrier(slack: Vector, smoothing: Smoothing) -> Vector:
    """-log(t) less its Taylor series about 1 to the square; below the stiff distance, the series there."""
    t, stiff = slack / smoothing.reach, np.sqrt(smoothing.barrier / smoothing.stiffness) / smoothing.reach
    near = np.maximum(t, stiff)
    barrier = -np.log(near) + (near - 1) - (near - 1) ** 2 / 2
    slope, curvature = -1 / near + 1 - (near - 1), 1 / near**2 - 1
    return np.asarray(np.where(t < 1, barrier + slope * (t - near) + curvature * (t - near) ** 2 / 2, 0.0))


def slack_and_threat(
    points: Points, airspace: Airspace, rules: Rules, limits: Limits, reach: float
) -> tuple[Vector, Vector]:
    """Return for points (n, 3) the spare distance to everything solid [m], and the threat per meter."""
    height = points[:, 2] - airspace.ground(points)
    slack = np.minimum(height - limits.required_height(points), rules.ceiling - height)
    slack = np.minimum(slack, reach - rules.clearance)
    slack = np.minimum(slack, airspace.obstacle_distance(points) - rules.clearance)
    lower, upper = np.asarray(airspace.bounds.lower), np.asarray(airspace.bounds.upper)
    slack[((points < lower) | (points > upper)).any(axis=1)] = -np.inf
    if airspace.bounds.footprint is not None:
        slack = np.minimum(slack, -airspace.bounds.footprint.distance(points[:, :2]))
    threat = np.zeros(len(points))
    for _, which, distance in airspace.near(points, rules.d_safe + rules.radius):
        hull = distance - rules.radius
        threat[which] += np.where(hull < rules.d_safe, rules.threat / np.maximum(hull, LEAST), 0.0)
    return slack, threat


def lattice_costs(price: NDArray[np.float64], steps: NDArray[np.int64], lengths: Vector, source: int) -> Vector:
    """Return least costs between lattice nodes, by relaxing all steps."""
    cost = np.full(price.shape, np.inf)
    cost.ravel()[source] = 0.0
    while True:
        before = cost.copy()
        padded, dear = np.pad(cost, 1, constant_values=np.inf), np.pad(price, 1, constant_values=np.inf)
        for step, length in zip(steps, lengths, strict=True):
            behind = tuple(slice(1 - k, 1 - k + n) for k, n in zip(step, price.shape, strict=True))
            cost = np.minimum(cost, padded[behind] + length * (dear[behind] + price) / 2)
        if np.array_equal(cost, before):
            return cost.ravel()


def _slopes(nodes: Points, climb: float, descent: float) -> Points:
    """Return how much legs are below the greatest slopes, (2, n-1) [m]."""
    step = np.diff(nodes, axis=0)
    level = np.hypot(step[:, 0], step[:, 1])
    return np.array([climb * level - step[:, 2], descent * level + step[:, 2]])


def signed_turns(nodes: Points) -> Vector:
    """Left turns at inner nodes, (n-2,) [rad]."""
    step = np.diff(nodes[:, :2], axis=0)
    before, after = step[:-1], step[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(cross, (before * after).sum(axis=1)))
