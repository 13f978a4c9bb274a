"""Plan a path for a task: guess, search, polish, search the best piece by piece, polish again, prove."""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from ipoa_mission.geometry import Vector, polyline_length
from ipoa_mission.optimize.registry import build_optimizer, optimizer_class
from ipoa_mission.optimize.search import SHORT_EVALUATIONS, Optimizer, minimize
from ipoa_mission.planning.lattice import USUAL_LATTICE, Guess, LatticeStrategy, find_routes, guesses, lay_lattice
from ipoa_mission.planning.obstruction import not_found, refuse_closed, refuse_places
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.polish import FINE_POLISH, FIRM_POLISH, ROUGH_POLISH, polish, polish_until_proved, stages
from ipoa_mission.planning.problem import (
    ALL,
    BREACH_PENALTY,
    Candidate,
    CostTerms,
    PreparedProblem,
    curve_cost,
    even_cost,
    follow,
    prepare,
    refine,
    surround,
    without_penalty,
)
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.spline import Spline
from ipoa_mission.progress import Progress, silent


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """A path that may be flown; made by `plan_path`.

    Attributes:
        curve: the path.
        cost: term by term.
        proof: its clearance from every limit.
        optimizer: the name of the search algorithm.
        seed: of the random numbers.
        evaluations: numbers of evaluated costs, (n,).
        history: best cost after each of these, (n,).
        via_at: the curve's parameters at the places to pass, (k,).
    """

    curve: Spline
    cost: CostTerms
    proof: Proof
    optimizer: str
    seed: int
    evaluations: NDArray[np.int64]
    history: NDArray[np.float64]
    via_at: Vector = field(default_factory=lambda: np.zeros(0))

    def judged_by(self, task: PathTask) -> "Plan":
        """Return the same path with cost and proof for another `task`."""
        return replace(self, cost=curve_cost(self.curve, task), proof=prove_curve(self.curve, task))

    def __repr__(self) -> str:
        cost = float(self.history[-1])
        count = int(self.evaluations[-1])
        return f"<Plan: {self.curve.length:.1f} m, cost {cost:.4f}, by {self.optimizer}, {count} evaluations>"


@dataclass(frozen=True)
class SearchStrategy:
    """Effort of the path search; a width is a share of the varied length."""

    lattice: LatticeStrategy = USUAL_LATTICE
    straight_width: float = 0.25
    lattice_starts: int = 2  # of the cheapest route, then the best polished
    lattice_width: float = 0.08
    max_behind: tuple[float, ...] = (0.08, 0.02)  # the best guess, after each stage
    min_rivals: int = 3
    coarse_control_points: int = 100  # fewer may not follow the route
    closer_factor: int = 4
    max_improved: int = 2  # piece by piece
    max_rounds: int = 4
    piece: int = 10
    piece_width: float = 0.12
    enough_control_points: int = 150
    few_control_points: int = 60  # of a polished curve
    hidden_loop: float = 1.001  # of cost to even-step cost
    enough_proved: int = 2  # if the best of all is not valid
    max_polished: int = 6


USUAL = SearchStrategy()
MANY_LEGS = SearchStrategy(
    lattice=LatticeStrategy(nodes=30_000, max_routes=8, max_routes_climbing=4),
    lattice_starts=1,
    max_improved=1,
    max_rounds=12,
)
MOST_PLACES = 6  # of the usual strategy
threads = cache(ThreadpoolController)  # takes 5 ms


@dataclass
class Searcher:
    """Successive searches with one stream of random numbers; `best`: least costs after `spent` evaluations."""

    problem: PreparedProblem
    optimizer: Optimizer
    rng: np.random.Generator
    strategy: SearchStrategy
    budget: int | None = None
    spent: list[int] = field(default_factory=list)
    best: list[float] = field(default_factory=list)

    def search(self, around: Candidate, width: float, part: slice = ALL, progress: Progress = silent) -> Candidate:
        """Return the best curve found around one, or around a `part` of it, within a `width` (a share)."""
        task = self.problem.task
        half_width = width * polyline_length(around.curve.control[1:-1][part])
        name = task.planning.encoding or ("absolute" if task.planning.planner == "paper" else "sine")
        encoding = surround(name, around, half_width, task, part)
        costs = self.problem.costs(encoding)
        optimum = minimize(costs, encoding.box, self.optimizer, self.rng, budget=self.budget, progress=progress)
        spent, best = (self.spent[-1], self.best[-1]) if self.spent else (0, np.inf)
        self.spent += [spent + int(evaluations) for evaluations in optimum.evaluations]
        candidate = Candidate(encoding.curve(optimum.x), around.via_at)
        if part == ALL:
            self.best += [min(best, float(cost)) for cost in optimum.history]
        else:
            self.best += [best] * (len(optimum.history) - 1) + [min(best, self.problem.cost(candidate))]
        return candidate


def is_as_printed(task: PathTask) -> bool:
    """Return whether one search makes the path, as in the paper."""
    return task.planning.planner == "paper" or not task.planning.polish


def optimizer_of(task: PathTask, short: bool) -> tuple[Optimizer, int | None]:
    """Return the optimizer, if `short` with `short_settings`, and its budget; raise BadInput for unknown names."""
    name = task.optimizer.name
    settings = task.optimizer.settings
    defaults = getattr(optimizer_class(name), "short_settings", None) if short else {}
    budget = SHORT_EVALUATIONS if defaults is None and not settings else None
    return build_optimizer(name, (defaults or {}) | settings), budget


class ProvedCurve(NamedTuple):
    candidate: Candidate
    proof: Proof
    cost: CostTerms


def plan_path(
    task: PathTask,
    *,
    seed: int = 0,
    progress: Progress = silent,
    strategy: SearchStrategy | None = None,
    optimizer: Optimizer | None = None,
) -> Plan:
    """Find the best path that keeps every limit; deterministic for task, seed and version.

    Args:
        task: a scenario, or a `PathProblem`.
        seed: of the random numbers.
        progress: called with the share done and a description.
        strategy: search effort. Internal, may change with any version.
        optimizer: replaces the task's optimizer.

    Returns:
        The curve, proved to keep the limits.

    Raises:
        BadInput: the optimizer is unknown, or has no such setting; start and goal are the same place.
        NoPath: a given place breaks a limit, or no path was found that keeps them all.

    Example:
        >>> from ipoa_mission import plan_path, read_scenario
        >>> plan = plan_path(read_scenario("missions/sitl.toml"), seed=7)
        >>> plan.proof.is_proved, plan.optimizer
        (True, 'ipoa')
    """
    problem = prepare(task)
    refuse_places(problem)
    refuse_closed(problem)
    as_printed = is_as_printed(task)
    search, budget = (optimizer, None) if optimizer else optimizer_of(task, short=not as_printed)
    effort = strategy or (USUAL if len(task.places) <= MOST_PLACES else MANY_LEGS)
    searcher = Searcher(problem, search, np.random.default_rng(seed), effort, budget)
    with threads().limit(limits=1, user_api="blas"):  # more threads wait, and round differently
        curves = [_search_once(searcher, progress)] if as_printed else _search_passages(searcher, progress)
    safe = [curve for curve in curves if curve.proof.is_proved]
    if not safe:
        raise not_found(max((curve.proof for curve in curves), key=lambda proof: proof.worst.slack))
    best, proof, cost = min(safe, key=lambda curve: curve.cost.total)
    name = task.optimizer.name if optimizer is None else type(optimizer).__name__
    return Plan(best.curve, cost, proof, name, seed, np.array(searcher.spent), np.array(searcher.best), best.via_at)


def move_aside(plan: Plan, task: PathTask) -> Spline | None:
    """Move a plan's curve until it keeps another task's limits; None if it cannot."""
    problem = prepare(task)
    with threads().limit(limits=1, user_api="blas"):
        rough = polish(Candidate(plan.curve, plan.via_at), problem, FIRM_POLISH)
        candidate, proof = polish_until_proved(rough, problem, replace(FINE_POLISH, enough=1e-5, finer=1), attempts=2)
    return candidate.curve if proof.is_proved else None


def _search_once(searcher: Searcher, progress: Progress) -> ProvedCurve:
    task = searcher.problem.task
    straight = follow(task.places, task.planning.control_points, task)
    searched = searcher.search(straight, 2 * searcher.strategy.straight_width, progress=progress)
    return ProvedCurve(searched, prove_curve(searched.curve, task), curve_cost(searched.curve, task))


def _search_passages(searcher: Searcher, progress: Progress) -> list[ProvedCurve]:
    strategy = searcher.strategy
    curves = list[ProvedCurve]()
    for coarsest in range(len(strategy.lattice.refinements) - 1):
        improved = _improve(_find_passages(searcher, coarsest, progress), searcher, progress)
        for candidate in improved[: strategy.max_polished]:
            curves.append(_polish_and_prove(candidate, searcher))
            enough = 1 if curves[0].proof.is_proved else strategy.enough_proved
            if sum(curve.proof.is_proved for curve in curves) == enough:
                break
        safe = [curve.candidate for curve in curves if curve.proof.is_proved]
        if safe:
            best = min(safe, key=searcher.problem.cost)
            if len(best.curve.control) < strategy.few_control_points:
                curves.append(_polish_and_prove(refine(best), searcher, enough=1e-8))
            break
    return curves


def _find_passages(searcher: Searcher, coarsest: int, progress: Progress) -> list[Candidate]:
    problem = searcher.problem
    strategy = searcher.strategy
    straight, *routes = guesses(problem, coarsest, strategy.lattice)
    candidates = [straight.candidate(problem)]
    polished = [polish(candidates[0], problem)]
    for candidate, rough in _rivals([route.candidate(problem) for route in routes], searcher):
        if len(candidate.curve.control) < strategy.coarse_control_points and problem.cost(rough) > BREACH_PENALTY:
            candidate = refine(candidate)
            rough = _approach(candidate, problem)
        candidates.append(candidate)
        polished.append(rough)

    costs = [problem.cost(candidate) for candidate in polished]
    cheapest_route = list(range(1, len(costs)))[:1]
    others = sorted(range(2, len(costs)), key=costs.__getitem__)
    promising = [*cheapest_route, *others][: strategy.lattice_starts]
    if min(costs) > BREACH_PENALTY:
        closer = (route.candidate(problem, strategy.closer_factor) for route in routes)
        polished += [polish(candidate, problem, FIRM_POLISH) for candidate in closer]

    starts = [(candidates[0], strategy.straight_width)]
    starts += [(candidates[i], strategy.lattice_width) for i in promising]
    for i, (guess, width) in enumerate(starts):
        progress(0.5 * i / len(starts), f"passage {i + 1} of {len(starts)}")
        polished.append(polish(searcher.search(guess, width), problem))
    return sorted(polished, key=problem.cost)[: strategy.max_improved]


def _rivals(candidates: list[Candidate], searcher: Searcher) -> list[tuple[Candidate, Candidate]]:
    """Return the candidates near the best after a rough polish, and the first, with their curves."""
    problem = searcher.problem
    strategy = searcher.strategy
    if problem.climbs_limited:
        return [(candidate, _approach(candidate, problem)) for candidate in candidates]
    running = [(candidate, stages(candidate, problem)) for candidate in candidates]
    for behind in strategy.max_behind:
        costs = np.array([problem.cost(next(steps)) for _, steps in running])
        is_near = without_penalty(costs) <= (1 + behind) * costs.min(initial=np.inf)
        is_near[:1] = True
        is_near[np.argsort(costs)[: strategy.min_rivals]] = True
        running = [running[n] for n in np.flatnonzero(is_near)]
    return [(candidate, list(steps)[-1]) for candidate, steps in running]


def _approach(candidate: Candidate, problem: PreparedProblem) -> Candidate:
    if not problem.climbs_limited:
        return polish(candidate, problem)
    return polish_until_proved(candidate, problem, replace(ROUGH_POLISH, steps=60))[0]


def _improve(candidates: list[Candidate], searcher: Searcher, progress: Progress) -> list[Candidate]:
    """Return all curves, searched again piece by piece, cheapest first."""
    problem = searcher.problem
    rng = searcher.rng
    strategy = searcher.strategy
    improved = list[tuple[float, Candidate]]()
    for candidate in candidates:
        is_coarse = len(candidate.curve.control) < strategy.enough_control_points
        finer = refine(candidate) if is_coarse else candidate
        improved.append((problem.cost(finer), finer))
    inner = max(len(candidate.curve.control) for _, candidate in improved) - 2
    rounds = int(np.clip((inner - strategy.piece) // 4, 4, strategy.max_rounds))
    for i in range(rounds):
        progress(0.5 + 0.4 * i / rounds, f"refining part {i + 1} of {rounds} of the path")
        base = improved[int(rng.integers(min(2, len(improved))))][1]
        first = int(rng.integers(max(len(base.curve.control) - 2 - strategy.piece, 0) + 1))
        piece = slice(first, first + strategy.piece)
        better = polish(searcher.search(base, strategy.piece_width, piece), problem, part=piece)
        improved.append((problem.cost(better), better))
        improved.sort(key=lambda pair: pair[0])
    return [candidate for _, candidate in improved]


def _polish_and_prove(candidate: Candidate, searcher: Searcher, enough: float = 1e-7) -> ProvedCurve:
    """Polish, and again evenly if clustered control points hide a loop."""
    task = searcher.problem.task

    def polished(rough: Candidate) -> ProvedCurve:
        fine, proof = polish_until_proved(rough, searcher.problem, replace(FINE_POLISH, enough=enough))
        return ProvedCurve(fine, proof, curve_cost(fine.curve, task))

    first = polished(candidate)
    curve = first.candidate.curve
    if first.cost.total <= searcher.strategy.hidden_loop * even_cost(curve, task).total:
        return first
    count = len(curve.control)
    even = polished(follow(curve.sample(4 * count), count - 2, task))
    is_cheaper = even.cost.total < first.cost.total or not first.proof.is_proved
    return even if even.proof.is_proved and is_cheaper else first


class Sketch(NamedTuple):
    """A path without search, for interactive editing."""

    curve: Spline
    proof: Proof
    others: tuple[Spline, ...]


def sketch_path(task: PathTask) -> Sketch:
    """Return the best of a few routes, deterministic for a task, in some tens of milliseconds.

    If its proof does not hold, another route may exist.

    Raises:
        NoPath: a given place breaks a limit.
        BadInput: start and goal are the same place.
    """
    problem = prepare(task)
    refuse_places(problem)
    with threads().limit(limits=1, user_api="blas"):
        candidates = [polish(guess.candidate(problem), problem) for guess in _sketched(problem)]
        best = sorted(candidates, key=problem.cost)
        tried = ((candidate, prove_curve(candidate.curve, task)) for candidate in best[:2])
        proved = next((pair for pair in tried if pair[1].is_proved), None)
        chosen = best[0] if proved is None else proved[0]
        drawn, proof = proved or polish_until_proved(chosen, problem)
    return Sketch(drawn.curve, proof, tuple(other.curve for other in best if other is not chosen))


def _sketched(problem: PreparedProblem) -> list[Guess]:
    straight = problem.task.places
    inner = max(24, 5 * (len(straight) - 1))
    for fineness in (0.4, 0.7):  # as shares of the planner's first one
        routes = find_routes(lay_lattice(problem, fineness), problem, most=4)
        if routes:
            break
    return [Guess(route, None, inner) for route in (straight, *routes)]
