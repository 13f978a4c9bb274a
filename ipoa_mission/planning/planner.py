"""From a task to a plan: guess, search, polish, prove.

Short searches begin at different guesses, a straight line and the distinct ways through a coarse lattice, so that
they end in different passages between the obstacles; each result is polished to the nearest optimum. Then the best
curves, with twice the control points, are searched again piece by piece. The best of all are settled: polished until
their proof holds; and the best of these once more, with twice the control points again.
"""

from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from ipoa_mission.geometry import leg_lengths
from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.lattice import FINER, guesses
from ipoa_mission.planning.obstruction import NoPath, blockage, explain, not_found, refuse_closed, refuse_places
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.polish import FIRM, polish, settle
from ipoa_mission.planning.problem import UNSAFE, PreparedProblem, Trail, follow, pose, refine
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.search import Progress, Searcher, optimizer_of
from ipoa_mission.planning.spline import Spline

__all__ = ["NoPath", "plan_path"]

Proved: TypeAlias = tuple[Spline, Proof]

STRAIGHT = 3  # searches that begin at the straight line
SEARCHED, SHORTEST = 8, 4  # searches that begin at lattice ways, and how many of these are the lattice's best
WIDE, NARROW, LOCAL = 0.25, 0.08, 0.12  # widths of a search: round the straight line, a better guess, a piece
FEW = 100  # control points with which a curve may not be able to follow a way
MANY = 150  # control points that are enough
CLOSER = 4  # times as many let it
KEPT = 3  # curves that are searched again
ROUNDS = 40  # at most, of searches piece by piece
PIECE = 10  # control points that are then varied at a time
PILED_UP = 0.02  # as a share of the usual distance between control points
WANTED, TRIED = 2, 6  # curves that are settled and hold, and how many are tried for that


def plan_path(task: PathTask, seed: int = 0, progress: Progress = lambda done, words: None) -> Plan:
    """The best path that was found, proved to keep every limit; the same for the same task, seed and version.

    Raises:
        BadInput: the optimizer is unknown, or has no such setting; start and goal are the same place.
        NoPath: a given place breaks a limit, or no path was found that keeps them all; the message says which, where
            and by how much.
    """
    problem, planning = pose(task), task.planning
    refuse_places(problem)
    refuse_closed(problem)
    as_printed = planning.planner == "paper" or not planning.polish
    optimizer = optimizer_of(task, short=not as_printed)
    searcher = Searcher(problem, optimizer, np.random.default_rng(seed))
    with threadpool_limits(1, "blas"):  # on matrices this small threads only wait, and round by their number
        curves = [_search_once(searcher, progress)] if as_printed else _search_passages(searcher, progress)
    safe = [(curve_cost(curve, task), curve, proof) for curve, proof in curves if proof.holds]
    if not safe:
        nearest = max((proof for _, proof in curves), key=lambda proof: proof.worst.slack)
        raise explain(problem, nearest) if as_printed else not_found(nearest)
    cost, curve, proof = min(safe, key=lambda found: found[0].total)
    return Plan(curve, cost, proof, task.optimizer.name, seed, *searcher.history())


def _search_once(searcher: Searcher, progress: Progress) -> Proved:
    """As the paper does: one long search, and what it finds."""
    task = searcher.problem.task

    def tell(spent: int, best: float) -> None:
        progress(spent / (spent + 30_000), f"{spent} evaluations, cost {best:.1f}")

    straight = follow(task.places, task.planning.control_points, task)
    found = searcher.search(straight, 2 * WIDE, progress=tell)
    return found.curve, prove_curve(found.curve, task)


def _search_passages(searcher: Searcher, progress: Progress) -> list[Proved]:
    """A few settled curves; if none of them holds, the search begins anew with guesses from a finer lattice."""
    problem, proved = searcher.problem, list[tuple[Trail, Proof]]()
    for coarsest in range(len(FINER) - 1):
        for trail in _improve(_find_passages(searcher, coarsest, progress), searcher, progress)[:TRIED]:
            proved.append(_settle(trail, problem))
            if sum(proof.holds for _, proof in proved) == WANTED:
                break
        if safe := [trail for trail, proof in proved if proof.holds]:
            proved.append(_settle(_finer(min(safe, key=problem.cost)), problem, enough=1e-8))
            break
        if coarsest == 0 and (why := blockage(problem)) is not None:
            raise why
    return [(trail.curve, proof) for trail, proof in proved]


def _find_passages(searcher: Searcher, coarsest: int, progress: Progress) -> list[Trail]:
    """The best few curves, of those that a guess, or a search round one, was polished to."""
    problem = searcher.problem
    straight, *ways = guesses(problem, coarsest)
    trails, found = [straight.trail(problem)], [polish(straight.trail(problem), problem)]
    for way in ways:
        trails.append(way.trail(problem))
        found.append(polish(trails[-1], problem))
        if len(trails[-1].curve.control) < FEW and problem.cost(found[-1]) > UNSAFE:
            trails[-1] = refine(trails[-1])
            found[-1] = polish(trails[-1], problem)
    costs = [problem.cost(trail) for trail in found]
    best = 1 + np.argsort(costs[1:])
    promising = list(dict.fromkeys([*range(1, len(found))[:SHORTEST], *best.tolist()]))[:SEARCHED]
    if min(costs) > UNSAFE:
        found += [polish(way.trail(problem, CLOSER), problem, FIRM) for way in ways]
    starts = [(trails[0], WIDE)] * STRAIGHT + [(trails[i], NARROW) for i in promising]
    for i, (guess, width) in enumerate(starts):
        progress(0.5 * i / len(starts), f"passage {i + 1} of {len(starts)}")
        found.append(polish(searcher.search(guess, width), problem))
    return sorted(found, key=problem.cost)[:KEPT]


def _improve(trails: list[Trail], searcher: Searcher, progress: Progress) -> list[Trail]:
    """These curves with twice the control points and what became of them piece by piece, the best first."""
    problem, rng = searcher.problem, searcher.rng
    found = [(problem.cost(trail), trail) for trail in map(_finer, trails)]
    inner = max(len(trail.curve.control) for _, trail in found) - 2
    rounds = int(np.clip((inner - PIECE) // 4, 4, ROUNDS))
    for i in range(rounds):
        progress(0.5 + 0.4 * i / rounds, f"piece {i + 1} of {rounds}")
        base = found[int(rng.integers(min(2, len(found))))][1]
        first = int(rng.integers(max(len(base.curve.control) - 2 - PIECE, 0) + 1))
        piece = slice(first, first + PIECE)
        better = polish(searcher.search(base, LOCAL, piece), problem, part=piece)
        found.append((problem.cost(better), better))
        found.sort(key=lambda pair: pair[0])
    return [trail for _, trail in found]


def _settle(trail: Trail, problem: PreparedProblem, enough: float = 1e-7) -> tuple[Trail, Proof]:
    """The curve settled; where its control points piled up, the cheaper of it and one that has them evenly apart.

    Where they pile up a curve may turn a full circle within millimeters.
    """
    settled, proof = settle(trail, problem, enough)
    control, task = settled.curve.control, problem.task
    apart = leg_lengths(control)
    if apart.min() > PILED_UP * np.median(apart):
        return settled, proof
    even = follow(settled.curve.sample(4 * len(control)), len(control) - 2, task)
    even, even_proof = settle(even, problem, enough)
    cheaper = curve_cost(even.curve, task).total < curve_cost(settled.curve, task).total
    return (even, even_proof) if even_proof.holds and (cheaper or not proof.holds) else (settled, proof)


def _finer(trail: Trail) -> Trail:
    """The curve with twice the control points, unless it has enough."""
    return refine(trail) if len(trail.curve.control) < MANY else trail
