"""A quick, unsearched path for interactive editing."""

from typing import NamedTuple

from threadpoolctl import threadpool_limits

from ipoa_mission.planning.lattice import Guess, find_routes, lay_lattice
from ipoa_mission.planning.obstruction import refuse_places
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.polish import polish, polish_until_proved
from ipoa_mission.planning.problem import PreparedProblem, prepare
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.spline import Spline

FIRST_FINENESS = 0.4  # as shares of the planner's first one
SECOND_FINENESS = 0.7
MAX_ROUTES = 4  # besides the straight one
MAX_PROVED = 2  # before one is chosen
CONTROL_POINTS = 24


class Sketch(NamedTuple):
    curve: Spline
    proof: Proof
    others: tuple[Spline, ...]


def sketch_path(task: PathTask) -> Sketch:
    """Return the best of a few routes, deterministic for a task, usually in some tens of milliseconds.

    If its proof does not hold, this quick look found no route within limits; one may exist all the same.

    Raises:
        NoPath: a given place breaks a limit.
        BadInput: start and goal are the same place.
    """
    problem = prepare(task)
    refuse_places(problem)
    with threadpool_limits(1, "blas"):
        candidates = [polish(guess.candidate(problem), problem) for guess in _guesses(problem)]
        best = sorted(candidates, key=problem.cost)
        first = best[0]
        for candidate in best[:MAX_PROVED]:
            if (proof := prove_curve(candidate.curve, task)).is_proved:
                first = candidate
                break
        else:
            candidate, proof = polish_until_proved(first, problem)
    return Sketch(candidate.curve, proof, tuple(other.curve for other in best if other is not first))


def _guesses(problem: PreparedProblem) -> list[Guess]:
    straight = problem.task.places
    inner = max(CONTROL_POINTS, 5 * (len(straight) - 1))
    for fineness in (FIRST_FINENESS, SECOND_FINENESS):
        if routes := find_routes(lay_lattice(problem, fineness), problem, MAX_ROUTES):
            return [Guess(straight, None, inner), *(Guess(route, None, inner) for route in routes)]
    return [Guess(straight, None, inner)]
