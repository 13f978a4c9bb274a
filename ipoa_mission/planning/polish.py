"""Polish: from a rough path to the nearest local optimum, by damped Gauss-Newton steps on a smoothed problem.

Absolute angles, the sudden end of the threat at d_safe and the limits are rounded off, at first generously, then less
and less; a limit is a stiff spring. What is left of a broken limit is mended by `aside` and `above`, a little more
clearance than is required.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.chart import Soft
from ipoa_mission.planning.problem import Matrix, PathProblem, Trail, freedom
from ipoa_mission.planning.spline import Spline, even_basis

NODES_PER_SPAN = 12
SOFTER, SOFT = Soft(0.02, 0.5, 1.0, 0.05, 0.0, 0.0), Soft(5e-3, 0.3, 10.0, 0.05, 0.01, 0.01)
HARD, HARDER = Soft(1e-3, 0.1, 100.0, 0.05, 0.01, 0.02), Soft(1e-4, 0.05, 1000.0, 0.05, 0.01, 0.02)
HARDEST = Soft(1e-5, 0.02, 10000.0, 0.05, 0.005, 0.02)
ROUGH = (SOFTER, SOFT, HARD, HARDER)
FINE = (HARD, HARDER, HARDEST)


def polish(trail: Trail, problem: PathProblem, stages: Sequence[Soft], steps: int = 15) -> Trail:
    """The curve after at most `steps` Gauss-Newton steps at each stage; its ends and its via points stay."""
    control, nodes = trail.curve.control, max(problem.nodes, NODES_PER_SPAN * trail.curve.spans)
    free = freedom(trail, problem.scenario)
    for soft in stages:
        control = _descend(control, nodes, problem, soft, free, steps)
    return Trail(Spline(control), trail.via_at)


def _descend(control: Points, nodes: int, problem: PathProblem, soft: Soft, free: Matrix, steps: int) -> Points:
    """Levenberg and Marquardt: the less damped the better the model has been right."""
    n = len(control)
    look, (first, window) = even_basis(n, nodes), _windows(n, nodes)
    spread = np.einsum("nf,ab->nafb", free, np.eye(3)).reshape(3 * n, -1)

    def model(control: Points) -> tuple[float, Vector, NDArray[np.float64]]:
        from ipoa_mission.planning._kernels import path_model

        value, gradient, hessian = path_model(look @ control, first, window, n, problem.chart, problem.rules, soft)
        return value, gradient @ spread, spread.T @ hessian @ spread

    value, gradient, hessian = model(control)
    damping = 1e-3
    for _ in range(steps):
        scale = np.diag(hessian)
        for _ in range(6):
            damped = hessian + np.diag(damping * scale + 1e-6 * scale.mean())
            trial = control + (spread @ np.linalg.solve(damped, -gradient)).reshape(n, 3)
            trial_value, trial_gradient, trial_hessian = model(trial)
            if trial_value < value:
                break
            damping = max(8 * damping, 1e-4)
        else:
            return control
        gain = value - trial_value
        control, value, gradient, hessian = trial, trial_value, trial_gradient, trial_hessian
        damping = max(damping / 5, 1e-7)
        if gain < 5e-6 * abs(value):
            return control
    return control


@lru_cache(maxsize=64)
def _windows(n: int, nodes: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """For each node the first of five control points that it and its neighbours depend on, and how, (nodes, 3, 5)."""
    look = even_basis(n, nodes)
    around = np.stack([look[np.clip(np.arange(nodes) + k, 0, nodes - 1)] for k in (-1, 0, 1)], axis=1)
    first = np.minimum(np.argmax(np.abs(around).max(axis=1) > 1e-14, axis=1), n - 5)
    window = around[np.arange(nodes)[:, None, None], np.arange(3)[:, None], first[:, None, None] + np.arange(5)]
    return first, np.ascontiguousarray(window)
