"""A reference optimum: the best of everything that is known to find good paths, given far more time than a planner has.

Starts are the straight line, the ways through lattices finer than the planner's, and the ways through lattices whose
prices were shaken, which lead through other passages. Round each CMA-ES searches sine modes of several numbers of
control points; what it finds is polished. Of the best few CMA-ES varies every control point once more, on the exact
cost and not on the smooth one, and they are polished anew with twice and four times the control points and hardly
anything rounded off. Only proved paths count.
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from ipoa_mission.geometry import Points, polyline_length
from ipoa_mission.optimize.search import Candidates, Costs
from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.lattice import lay, ways
from ipoa_mission.planning.polish import STAGE_5, STAGE_6, polish, settle
from ipoa_mission.planning.problem import Candidate, Encoding, PreparedProblem, follow, prepare, refine, surround
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.scenario import Scenario

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cma

INNER = (6, 8, 12, 18)
SHAKEN = 0.25  # standard deviation of the logarithm of a shaken price
APART = 0.02  # of the length: starts that are nearer to each other than this are one
KEPT = 4
#: Stages that go on where the planner's polish ends: hardly anything is rounded off.
CLOSER = STAGE_6._replace(reach=0.01, wall=3e-5, stiffness=1e6)
SHARP = (STAGE_5, STAGE_6, CLOSER, CLOSER._replace(reach=0.003, wall=3e-6))


def reference(scenario: Scenario, seed: int, starts: int, given: list[Points]) -> tuple[float, Candidate]:
    """The best proved path of `starts` searches, and of the polylines given, polished; its cost and itself."""
    rng = np.random.default_rng(seed)
    close = scenario.planning.model_copy(update={"samples": max(scenario.planning.samples, 200)})
    problem = prepare(scenario.model_copy(update={"planning": close}))
    stretch = problem.task.planning.control_points
    rough: list[Candidate] = []
    for k, guide in enumerate(_guides(problem, starts, rng)):
        inner = int(INNER[k % len(INNER)] * max(1.0, polyline_length(guide) / (12.5 * stretch) / 2))
        rough += _search(problem, guide, min(inner, 60), rng)
    rough += [polish(follow(guide, min(4 * INNER[1], 60), scenario), problem) for guide in given]
    rough.sort(key=problem.cost)
    found = [_finish(candidate, problem, rng) for candidate in _distinct(rough)[:KEPT]]
    proved = [(cost, candidate) for cost, candidate in found if prove_curve(candidate.curve, scenario).holds]
    return min(proved, key=lambda each: each[0])


def _guides(problem: PreparedProblem, count: int, rng: np.random.Generator) -> Iterator[Points]:
    """Polylines from start to goal: the straight one, lattice ways, and lattice ways at shaken prices."""
    yield problem.task.places
    known: list[Points] = []
    lattices = [lay(problem, fineness) for fineness in (1.0, 1.5)]
    for k in range(3 * count):
        lattice = lattices[k % len(lattices)]
        if k >= len(lattices):
            noise = gaussian_filter(rng.standard_normal(lattice.price.shape), rng.uniform(1.5, 5))
            lattice = replace(lattice, price=lattice.price * np.exp(SHAKEN * noise / noise.std()))
        for way in ways(lattice, problem, 8):
            if all(_gap(way, other) > APART * polyline_length(way) for other in known):
                known.append(way)
                yield way
                if len(known) >= count:
                    return


def _search(problem: PreparedProblem, guide: Points, inner: int, rng: np.random.Generator) -> list[Candidate]:
    candidate = follow(guide, inner, problem.task)
    encoding = surround("sine", candidate, 0.25 * polyline_length(guide), problem.task)
    sought = Candidate(encoding.curve(_cma(problem.costs(encoding), encoding, 0.03, 4000, rng)), candidate.via_at)
    return [polish(each, problem) for each in (candidate, sought)]


def _finish(candidate: Candidate, problem: PreparedProblem, rng: np.random.Generator) -> tuple[float, Candidate]:
    """Settled, sharpened and twice doubled, every control point varied once; the best proved curve on the way."""
    found = [settle(candidate, problem)[0]]
    found.append(_vary(found[0], problem, rng))
    for start in found[:2]:
        sharp = start
        for _ in range(3):
            sharp = polish(sharp, problem, SHARP, steps=60, finer=4)
            found.append(sharp)
            if len(sharp.curve.control) > 90:
                break
            sharp = refine(sharp)
    proved = [each for each in found if prove_curve(each.curve, problem.task).holds]
    costs = [curve_cost(each.curve, problem.task).total for each in proved]
    return min(zip(costs, proved, strict=True), key=lambda each: each[0], default=(np.inf, candidate))


def _vary(candidate: Candidate, problem: PreparedProblem, rng: np.random.Generator) -> Candidate:
    encoding = surround("chord", candidate, 1.0, problem.task)
    return Candidate(encoding.curve(_cma(problem.costs(encoding), encoding, 0.01, 10_000, rng)), candidate.via_at)


def _cma(
    cost: Callable[[Candidates], Costs], encoding: Encoding, sigma: float, evaluations: int, rng: np.random.Generator
) -> np.ndarray:
    """The best candidate that CMA-ES finds from the origin; `sigma` is a share of the width of the box."""
    width = encoding.box.upper - encoding.box.lower
    options = {"verbose": -9, "maxfevals": evaluations, "seed": int(rng.integers(1, 2**31)), "tolfun": 1e-4}
    if len(width) > 60:
        options["CMA_diagonal"] = True
    strategy = cma.CMAEvolutionStrategy(np.zeros(len(width)), sigma, options)
    best, least = np.zeros(len(width)), float(cost(np.zeros((1, len(width))))[0])
    while not strategy.stop():
        asked = strategy.ask()
        costs = cost(np.array(asked) * width)
        strategy.tell(asked, costs.tolist())
        k = int(np.argmin(costs))
        if costs[k] < least:
            best, least = np.asarray(asked[k]) * width, float(costs[k])
    return best


def _distinct(candidates: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for candidate in candidates:
        points = candidate.curve.sample(50)
        if all(_gap(points, other.curve.sample(50)) > APART / 4 * candidate.curve.length for other in kept):
            kept.append(candidate)
    return kept


def _gap(a: Points, b: Points) -> float:
    """The greatest distance between points at the same share of two polylines."""
    return float(np.linalg.norm(_even(a) - _even(b), axis=1).max())


def _even(points: Points) -> Points:
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    traveled = np.concatenate([[0.0], np.cumsum(legs)])
    at = np.linspace(0, traveled[-1], 50)
    return np.column_stack([np.interp(at, traveled, points[:, k]) for k in range(3)])
