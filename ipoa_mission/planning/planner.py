"""From a task to a plan: guess, search, polish, prove.

Short searches begin at different guesses, a straight line and the distinct ways through a coarse lattice, so that they
end in different passages between the obstacles; each result is polished to the nearest optimum. Then the best curves,
with twice the control points, are searched again piece by piece, and a long one kicked. The best of all are settled:
polished until their proof holds; and the best of these once more, with twice the control points again.
"""

from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from ipoa_mission.optimize.search import Optimizer
from ipoa_mission.planning.cost import CostTerms, curve_cost, even_cost
from ipoa_mission.planning.lattice import guesses
from ipoa_mission.planning.obstruction import NoPath, blockage, not_found, refuse_closed, refuse_places
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.perturb import perturbed
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.polish import FIRM, ROUGH, polish, settle
from ipoa_mission.planning.problem import UNSAFE, Candidate, PreparedProblem, follow, prepare, refine
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.searcher import Searcher, optimizer_of
from ipoa_mission.planning.spline import Spline
from ipoa_mission.planning.strategy import SearchStrategy, strategy_for
from ipoa_mission.progress import Progress, silent

__all__ = ["NoPath", "move_aside", "plan_path"]

Settled: TypeAlias = tuple[Candidate, Proof, CostTerms]


def plan_path(
    task: PathTask,
    *,
    seed: int = 0,
    progress: Progress = silent,
    strategy: SearchStrategy | None = None,
    optimizer: Optimizer | None = None,
) -> Plan:
    """Find the best path that keeps every limit; the same for the same task, seed and version.

    Args:
        task: a scenario, or a `PathProblem`.
        seed: what the random numbers begin with.
        progress: told the share done and some words.
        strategy: how hard to look; left out, by the number of places to pass. It is of this package and may change with
            it.
        optimizer: one of your own instead of the task's.

    Returns:
        The curve, proved to keep the limits, what it costs, and how it was found.

    Raises:
        BadInput: the optimizer is unknown, or has no such setting; start and goal are the same place.
        NoPath: a given place breaks a limit, or no path was found that keeps them all; the message says which, where
            and by how much.

    Example:
        >>> from ipoa_mission import plan_path, read_scenario
        >>> plan = plan_path(read_scenario("missions/sitl.toml"), seed=7)
        >>> plan.proof.holds, plan.optimizer
        (True, 'ipoa')
    """
    problem, planning = prepare(task), task.planning
    refuse_places(problem)
    refuse_closed(problem)
    as_printed = planning.planner == "paper" or not planning.polish
    search = optimizer or optimizer_of(task, short=not as_printed)
    effort = strategy or strategy_for(len(task.places) - 1)
    searcher = Searcher(problem, search, np.random.default_rng(seed), effort)
    with threadpool_limits(1, "blas"):  # on matrices this small threads only wait, and round by their number
        curves = [_search_once(searcher, progress)] if as_printed else _search_passages(searcher, progress)
    safe = [proved for proved in curves if proved[1].holds]
    if not safe:
        nearest = max((proof for _, proof, _ in curves), key=lambda proof: proof.worst.slack)
        raise (blockage(problem) if as_printed else None) or not_found(nearest)
    trail, proof, cost = min(safe, key=lambda proved: proved[2].total)
    name = task.optimizer.name if optimizer is None else type(optimizer).__name__
    return Plan(trail.curve, cost, proof, name, seed, *searcher.history(), trail.via_at)


def move_aside(plan: Plan, task: PathTask) -> Spline | None:
    """The plan's curve, moved to where it keeps the limits of another task, one that asks for more room.

    None if it cannot where it is: another way round may.
    """
    problem = prepare(task)
    with threadpool_limits(1, "blas"):
        near = polish(Candidate(plan.curve, plan.via_at), problem, FIRM)
        trail, proof = settle(near, problem, enough=1e-5, finer=1, attempts=2)
    return trail.curve if proof.holds else None


def _search_once(searcher: Searcher, progress: Progress) -> Settled:
    """As the paper does: one long search, and what it finds."""
    task = searcher.problem.task
    straight = follow(task.places, task.planning.control_points, task)
    searched = searcher.search(straight, 2 * searcher.strategy.straight_width, progress=progress)
    return searched, prove_curve(searched.curve, task), curve_cost(searched.curve, task)


def _search_passages(searcher: Searcher, progress: Progress) -> list[Settled]:
    """A few settled curves; if none of them holds, the search begins anew with guesses from a finer lattice."""
    problem, strategy, proved = searcher.problem, searcher.strategy, list[Settled]()
    for coarsest in range(len(strategy.lattice.refinements) - 1):
        improved = _improve(_find_passages(searcher, coarsest, progress), searcher, progress)
        for trail in improved[: strategy.max_settled]:
            proved.append(_settle(trail, searcher))
            enough = 1 if proved[0][1].holds else strategy.settled
            if sum(proof.holds for _, proof, _ in proved) == enough:
                break
        if safe := [trail for trail, proof, _ in proved if proof.holds]:
            best = min(safe, key=problem.cost)
            if (finer := _finer(best, strategy)) is not best:
                proved.append(_settle(finer, searcher, enough=1e-8))
            break
        if coarsest == 0 and (why := blockage(problem)) is not None:
            raise why
    return proved


def _find_passages(searcher: Searcher, coarsest: int, progress: Progress) -> list[Candidate]:
    """The best few curves, of those that a guess, or a search round one, was polished to."""
    problem, strategy = searcher.problem, searcher.strategy
    straight, *ways = guesses(problem, coarsest, strategy.lattice)
    trails, polished = [straight.trail(problem)], [polish(straight.trail(problem), problem)]
    for way in ways:
        trails.append(way.trail(problem))
        polished.append(_approach(trails[-1], problem))
        if len(trails[-1].curve.control) < strategy.coarse_control_points and problem.cost(polished[-1]) > UNSAFE:
            trails[-1] = refine(trails[-1])
            polished[-1] = _approach(trails[-1], problem)
    costs = [problem.cost(trail) for trail in polished]
    best = 1 + np.argsort(costs[1:])
    cheapest = range(1, len(polished))[: strategy.cheapest_starts]
    promising = list(dict.fromkeys([*cheapest, *best.tolist()]))[: strategy.lattice_starts]
    if min(costs) > UNSAFE:
        polished += [polish(way.trail(problem, strategy.closer_factor), problem, FIRM) for way in ways]
    starts = [(trails[0], strategy.straight_width)] * strategy.straight_starts
    starts += [(trails[i], strategy.lattice_width) for i in promising]
    for i, (guess, width) in enumerate(starts):
        progress(0.5 * i / len(starts), f"passage {i + 1} of {len(starts)}")
        polished.append(polish(searcher.search(guess, width), problem))
    return sorted(polished, key=problem.cost)[: strategy.max_improved]


def _approach(trail: Candidate, problem: PreparedProblem) -> Candidate:
    """A guess polished roughly; where climbs are limited until it keeps all limits, for what is cut must be climbed."""
    return settle(trail, problem, 5e-6, ROUGH, finer=1)[0] if problem.climbs_limited else polish(trail, problem)


def _improve(trails: list[Candidate], searcher: Searcher, progress: Progress) -> list[Candidate]:
    """These curves with twice the control points and what became of them piece by piece, the best first."""
    problem, rng, strategy = searcher.problem, searcher.rng, searcher.strategy
    improved = [(problem.cost(trail), trail) for trail in (_finer(trail, strategy) for trail in trails)]
    inner = max(len(trail.curve.control) for _, trail in improved) - 2
    rounds = int(np.clip((inner - strategy.piece) // 4, 4, strategy.max_rounds))
    for i in range(rounds):
        progress(0.5 + 0.4 * i / rounds, f"refining part {i + 1} of {rounds} of the path")
        base = improved[int(rng.integers(min(2, len(improved))))][1]
        first = int(rng.integers(max(len(base.curve.control) - 2 - strategy.piece, 0) + 1))
        piece = slice(first, first + strategy.piece)
        better = polish(searcher.search(base, strategy.piece_width, piece), problem, part=piece)
        improved.append((problem.cost(better), better))
        improved.sort(key=lambda pair: pair[0])
    trails = [trail for _, trail in improved]
    return [*perturbed(trails[0], problem, strategy), *trails]


def _settle(trail: Candidate, searcher: Searcher, enough: float = 1e-7) -> Settled:
    """The curve settled; if control points that piled up hide a loop of it, once more with them evenly apart."""
    problem, task = searcher.problem, searcher.problem.task
    settled, proof = settle(trail, problem, enough)
    cost = curve_cost(settled.curve, task)
    if cost.total <= searcher.strategy.hidden_loop * even_cost(settled.curve, task).total:
        return settled, proof, cost
    count = len(settled.curve.control)
    even, even_proof = settle(follow(settled.curve.sample(4 * count), count - 2, task), problem, enough)
    even_terms = curve_cost(even.curve, task)
    is_better = even_proof.holds and (even_terms.total < cost.total or not proof.holds)
    return (even, even_proof, even_terms) if is_better else (settled, proof, cost)


def _finer(trail: Candidate, strategy: SearchStrategy) -> Candidate:
    return refine(trail) if len(trail.curve.control) < strategy.enough_control_points else trail
