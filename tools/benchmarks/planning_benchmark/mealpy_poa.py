"""Run mealpy's POA on one map in an interpreter with mealpy, its cost written in NumPy as by a user.

Reads the map as JSON from standard input, writes the best candidate, its cost, and CPU seconds. Imports nothing of
this package. Spheres and cylinders only, the paper's terrain; control points in absolute coordinates.
"""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from mealpy import FloatVar
from mealpy.swarm_based.POA import OriginalPOA

Candidate = np.ndarray[Any, np.dtype[np.float64]]


def user_cost(problem: dict[str, Any]) -> Callable[[Candidate], float]:
    start, goal = np.array(problem["start"]), np.array(problem["goal"])
    basis = np.array(problem["basis"])  # (nodes, control points)
    lower, upper = np.array(problem["lower"]), np.array(problem["upper"])
    spheres = np.array(problem["spheres"]).reshape(-1, 4)  # east, north, up, radius
    cylinders = np.array(problem["cylinders"]).reshape(-1, 5)  # east, north, radius, base, top
    land, peaks = problem["terrain"], np.array(problem["terrain"]["peaks"])  # height, east, north, a, b
    rules = problem["rules"]

    def ground(x: Candidate, y: Candidate) -> Candidate:
        r = np.hypot(x, y)
        rolling = np.sin(y + land["a"]) + land["b"] * np.sin(x) + land["c"] * np.cos(land["d"] * r)
        rolling += (land["e"] + land["g"]) * np.cos(y) + land["f"] * np.sin(land["f"] * r)
        bell = np.exp(
            -(((x[:, None] - peaks[:, 1]) / peaks[:, 3]) ** 2) - ((y[:, None] - peaks[:, 2]) / peaks[:, 4]) ** 2
        )
        return np.asarray(np.maximum(rolling, land["base"] + bell @ peaks[:, 0]))

    def cost(candidate: Candidate) -> float:
        nodes = basis @ np.vstack([start, candidate.reshape(-1, 3), goal])
        x, y, z = nodes.T
        step = np.diff(nodes, axis=0)
        leg = np.linalg.norm(step, axis=1)
        share = (np.append(0.0, leg) + np.append(leg, 0.0)) / 2
        length = leg.sum()
        to_spheres = np.linalg.norm(nodes[:, None] - spheres[:, :3], axis=2) - spheres[:, 3]
        aside = np.hypot(x[:, None] - cylinders[:, 0], y[:, None] - cylinders[:, 1]) - cylinders[:, 2]
        above = np.maximum(cylinders[:, 3] - z[:, None], z[:, None] - cylinders[:, 4])
        to_cylinders = np.where((aside > 0) & (above > 0), np.hypot(aside, above), np.maximum(aside, above))
        distance = np.hstack([to_spheres, to_cylinders])
        outside = (np.maximum(lower - nodes, 0) + np.maximum(nodes - upper, 0)).sum() * length / len(leg)
        depth = (share[:, None] * np.maximum(rules["clearance"] - distance, 0)).sum() + outside
        depth += (share * np.maximum(rules["height"] - (z - ground(x, y)), 0)).sum()
        if depth > 0:
            return float(rules["length"] * length + rules["collision"] + rules["depth"] * depth)
        hull = distance - rules["radius"]
        threat = (share[:, None] * np.where(hull < rules["d_safe"], 1 / np.maximum(hull, rules["least"]), 0)).sum()
        level = step[:, :2]
        cross = level[:-1, 0] * level[1:, 1] - level[:-1, 1] * level[1:, 0]
        turning = np.abs(np.arctan2(cross, (level[:-1] * level[1:]).sum(axis=1))).sum()
        climbing = np.abs(np.diff(np.arctan2(step[:, 2], np.linalg.norm(level, axis=1)))).sum()
        return float(
            rules["length"] * length
            + rules["turning"] * turning
            + rules["climbing"] * climbing
            + rules["threat"] * threat
        )

    return cost


if __name__ == "__main__":
    problem = json.load(sys.stdin)
    cost, evaluations = user_cost(problem), 0

    def counted(candidate: Candidate) -> float:
        global evaluations
        evaluations += 1
        return float(cost(candidate))

    count = len(problem["basis"][0]) - 2
    bounds = FloatVar(lb=problem["lower"] * count, ub=problem["upper"] * count)
    started = time.process_time()
    best = OriginalPOA(epoch=problem["iterations"], pop_size=problem["population"]).solve(
        {"bounds": bounds, "minmax": "min", "obj_func": counted, "log_to": None}, seed=1
    )
    seconds = time.process_time() - started
    json.dump(
        {
            "cost": float(best.target.fitness),
            "candidate": [float(v) for v in best.solution],
            "seconds": seconds,
            "evaluations": evaluations,
        },
        sys.stdout,
    )
