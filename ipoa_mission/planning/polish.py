"""Polish a path to the nearest local optimum, by damped Gauss-Newton steps on a smoothed problem.

Limits, and the end of the threat at d_safe, are logarithmic barriers (Fiacco and McCormick 1968). `aside`, `above` and
`flatter` mend breaches between nodes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ipoa_mission.geometry import Matrix, leg_lengths
from ipoa_mission.planning.obstacle_grid import ControlPointShifts, NodeBasis, PolishInputs, Smoothing
from ipoa_mission.planning.problem import ALL, Candidate, PreparedProblem, null_space
from ipoa_mission.planning.proof import Check, Proof, prove_curve
from ipoa_mission.planning.spline import Spline, even_basis


def shifts_along(directions: Matrix, band: int) -> ControlPointShifts:
    """Return shifts along `directions` (n, f), for a Hessian of band width `band` by all coordinates."""
    free = directions.shape[1]
    point, direction = np.nonzero(directions)
    starts = np.concatenate([[0], np.cumsum(np.bincount(point, minlength=len(directions)))])
    lowest = np.where(directions != 0.0, np.arange(free), free).min(axis=1, initial=free)
    highest = np.where(directions != 0.0, np.arange(free), -1).max(axis=1, initial=-1)
    lowest, highest = (np.add.outer(3 * index, np.arange(3)).ravel() for index in (lowest, highest))
    band_width = 0
    for below in range(min(band + 1, len(lowest))):
        rows = slice(below, None)
        columns = slice(len(lowest) - below)
        apart = np.maximum(highest[rows] - lowest[columns], highest[columns] - lowest[rows])
        band_width = max(band_width, int(apart.max()))
    return ControlPointShifts(
        3 * free, band_width, starts, np.ascontiguousarray(direction), directions[point, direction]
    )


NODES_PER_SPAN = 8
EARLY_GAIN = 1e-5  # of a step that ends an early stage
ATTEMPTS = 6
BAND = 14  # a term depends on five control points
HOPELESS_SLACK = {"m": -1.0, "deg": -10.0}  # that more room does not mend
CHANGE_REACH = 8  # in control points, with via points
STAGE_1 = Smoothing(bend=0.02, reach=0.5, barrier=0.3, stiffness=10.0, evenness=0.05, aside=0.0, above=0.0, flatter=0.0)
STAGE_2 = STAGE_1._replace(bend=5e-3, reach=0.3, barrier=0.1, stiffness=30.0, aside=0.01, above=0.01)
STAGE_3 = STAGE_2._replace(bend=1e-3, reach=0.2, barrier=0.03, stiffness=100.0, above=0.02, flatter=1e-3)
STAGE_4 = STAGE_3._replace(bend=1e-4, reach=0.1, barrier=0.01, stiffness=1e3, evenness=0.02)
STAGE_5 = STAGE_4._replace(bend=1e-5, reach=0.05, barrier=0.002, stiffness=1e4, evenness=0.01, aside=0.005)
STAGE_6 = STAGE_5._replace(bend=1e-6, reach=0.03, barrier=3e-4, stiffness=1e5, evenness=0.002, aside=0.003)


@dataclass(frozen=True)
class PolishSchedule:
    """Stages of up to `steps` Gauss-Newton steps, until one gains less than the share `enough`; nodes times `finer`."""

    stages: Sequence[Smoothing]
    steps: int = 8
    enough: float = 5e-6
    finer: int = 1


ROUGH_POLISH = PolishSchedule((STAGE_1, STAGE_2, STAGE_3))
FIRM_POLISH = PolishSchedule((STAGE_3, STAGE_4))
FINE_POLISH = PolishSchedule((STAGE_3, STAGE_4, STAGE_5, STAGE_6), steps=60, enough=1e-7, finer=2)


def polish(
    candidate: Candidate, problem: PreparedProblem, schedule: PolishSchedule = ROUGH_POLISH, part: slice = ALL
) -> Candidate:
    """Return the curve after all stages; of inner control points only `part` moves, and via points stay."""
    *_, polished = stages(candidate, problem, schedule, part)
    return polished


def stages(
    candidate: Candidate, problem: PreparedProblem, schedule: PolishSchedule = ROUGH_POLISH, part: slice = ALL
) -> Iterator[Candidate]:
    """Yield the curve after each stage."""
    from ipoa_mission.planning._path_model import minimize_path_model

    nodes = schedule.finer * max(problem.nodes, NODES_PER_SPAN * candidate.curve.spans)
    some, inputs = _prepare(candidate, problem, part, nodes)
    moved = np.ascontiguousarray(candidate.curve.control[some])
    signs = np.zeros((len(inputs.basis.first), 2))
    for k, smoothing in enumerate(schedule.stages, 1):
        enough = schedule.enough if k == len(schedule.stages) else max(schedule.enough, EARLY_GAIN)
        scaled = smoothing.scaled(problem.scale)
        moved, signs = minimize_path_model(
            moved, signs, inputs, problem.grid, problem.rules, scaled, schedule.steps, enough
        )
        control = candidate.curve.control.copy()
        control[some] = moved
        yield Candidate(Spline(control), candidate.via_at)


def polish_until_proved(
    candidate: Candidate, problem: PreparedProblem, schedule: PolishSchedule = FINE_POLISH, attempts: int = ATTEMPTS
) -> tuple[Candidate, Proof]:
    """Polish the curve until its proof holds, or nearly; return it unpolished if only that proof holds.

    With limited climbs it restarts for more room: else the curve would turn in circles.
    """
    rough = candidate
    more = {"aside": 0.0, "above": 0.0, "flatter": 0.0}
    remedies = {"obstacles": "aside", "bounds": "aside", "ground": "above", "ceiling": "above"}
    remedies |= {"climb": "flatter", "descent": "flatter"}
    for _ in range(attempts):
        wider = [
            one._replace(**{name: getattr(one, name) + by for name, by in more.items()}) for one in schedule.stages
        ]
        base = rough if problem.climbs_limited else candidate
        candidate = polish(base, problem, replace(schedule, stages=wider))
        proof = prove_curve(candidate.curve, problem.task)
        if proof.worst.slack >= 0 or any(check.slack < _hopeless(check, problem) for check in proof.checks):
            break
        for check in proof.checks:
            short = max(-1.2 * check.slack, 0.0)
            if check.unit == "deg":
                short = float(np.tan(np.radians(check.required)) - np.tan(np.radians(check.required - short)))
            more[remedies[check.limit]] += short
    if not proof.is_proved:
        unpolished = prove_curve(rough.curve, problem.task)
        if unpolished.is_proved:
            return rough, unpolished
    return candidate, proof


def _hopeless(check: Check, problem: PreparedProblem) -> float:
    """Return the slack that more room does not mend [m or degrees]."""
    ground = check.limit == "ground" and problem.climbs_limited
    return HOPELESS_SLACK[check.unit] * (1 + problem.task.airspace.terrain.steepness if ground else 1)


def _prepare(candidate: Candidate, problem: PreparedProblem, part: slice, nodes: int) -> tuple[slice, PolishInputs]:
    n = len(candidate.curve.control)
    varied = np.arange(1, n - 1)[part]
    low = max(int(varied[0]) - CHANGE_REACH, 0)
    high = min(int(varied[-1]) + CHANGE_REACH + 1, n)
    first, values = _node_basis(n, nodes)
    seen = slice(*np.searchsorted(first, (low, high - 4)))
    basis = NodeBasis(first[seen] - low, np.ascontiguousarray(values[:, :, seen]))
    shifts = shifts_along(null_space(candidate, problem.task, part)[low:high], BAND)
    mean_leg = float(leg_lengths(even_basis(n, nodes)[seen] @ candidate.curve.control).mean())
    return slice(low, high), PolishInputs(basis, shifts, mean_leg)


@lru_cache(maxsize=64)
def _node_basis(n: int, nodes: int) -> NodeBasis:
    node_basis = even_basis(n, nodes)
    around = np.stack([node_basis[np.clip(np.arange(nodes) + k, 0, nodes - 1)] for k in (-1, 0, 1)])
    first = np.minimum(np.argmax(np.abs(around).max(axis=0) > 1e-14, axis=1), n - 5)
    before, here, after = (part[np.arange(nodes), first + np.arange(5)[:, None]] for part in around)
    return NodeBasis(first, np.stack([here, here - before, after - here]))
