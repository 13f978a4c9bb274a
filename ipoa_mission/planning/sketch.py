"""A first path at once, for who is still moving things about: the ways through a thin lattice, polished, not searched.

It is proved like any other, but nobody looked for a better one: `plan_path` does.
"""

from dataclasses import dataclass

from threadpoolctl import threadpool_limits

from ipoa_mission.planning.lattice import Guess, lay, ways
from ipoa_mission.planning.obstruction import refuse_places
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.polish import polish, settle
from ipoa_mission.planning.problem import PreparedProblem, prepare
from ipoa_mission.planning.proof import Proof, prove_curve
from ipoa_mission.planning.spline import Spline

THINNEST, THIN = 0.4, 0.7  # how fine the lattices are, as shares of the planner's first one
WAYS = 4  # ways that are looked at, the straight one aside
TRIED = 2  # curves that are proved before one is polished until its proof holds
CONTROL = 24  # control points of a sketch


@dataclass(frozen=True)
class Sketch:
    """A path, what it keeps of the limits, and other ways round that were looked at, the better ones first."""

    curve: Spline
    proof: Proof
    others: tuple[Spline, ...]


def sketch_path(task: PathTask) -> Sketch:
    """The best of a few ways; the same for the same task. Mostly some tens of milliseconds, whatever the world holds.

    Its proof may not hold: then this quick look found no way that keeps all limits, and one may be there all the same.

    Raises:
        NoPath: a given place breaks a limit.
        BadInput: start and goal are the same place.
    """
    problem = prepare(task)
    refuse_places(problem)
    with threadpool_limits(1, "blas"):
        trails = [polish(guess.trail(problem), problem) for guess in _guesses(problem)]
        best = sorted(trails, key=problem.cost)
        first = best[0]
        for trail in best[:TRIED]:
            if (proof := prove_curve(trail.curve, task)).holds:
                first = trail
                break
        else:
            trail, proof = settle(first, problem)
    return Sketch(trail.curve, proof, tuple(other.curve for other in best if other is not first))


def _guesses(problem: PreparedProblem) -> list[Guess]:
    straight = problem.task.places
    inner = max(CONTROL, 5 * (len(straight) - 1))
    for fineness in (THINNEST, THIN):
        if routes := ways(lay(problem, fineness), problem, WAYS):
            return [Guess(straight, None, inner), *(Guess(way, None, inner) for way in routes)]
    return [Guess(straight, None, inner)]
