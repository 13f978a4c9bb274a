"""Explain why too few flights would keep the limits."""

import numpy as np

from ipoa_mission.centimeters import down, up
from ipoa_mission.errors import Remedy
from ipoa_mission.forecast.deviation.promise import Kept
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.changes import ChangeTrials
from ipoa_mission.routing.narrow import Narrow
from ipoa_mission.routing.planned_returns import or_else, why_not_planned
from ipoa_mission.scenario.path_limits import place_names
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle

OPPOSITE = -0.5  # cosine between the directions to both sides of a gap


def refusal(nearest: Attempt, trials: ChangeTrials) -> NoPath:
    promise = nearest.promise
    if nearest.short:
        helps, hint, remedies = _try_changes("", trials)
        words = f"a path exists, but {why_not_planned(nearest.forecast)}; {helps}"
        return NoPath(words, hint=f"{hint}; {or_else(nearest.forecast)}", remedies=remedies)
    tightest = min(promise.forbidding, key=lambda kept: kept.slack)
    east, north, height = tightest.place
    where = f"at east {east:.1f}, north {north:.1f}, up {height:.1f} m{_leg(nearest, tightest)}"
    if tightest.limit == "obstacles":
        words = _gap(tightest, nearest.scenario.airspace)
    else:
        words = f"{tightest.to}, where {tightest.words(promise.confidence)}"
    return _with_help(f"{words}, {where}", ", or a via point that leads round", trials)


def narrow_refusal(narrow: Narrow, trials: ChangeTrials) -> NoPath:
    return _with_help(narrow.words(), "", trials)


def _with_help(words: str, round_it: str, trials: ChangeTrials) -> NoPath:
    who, chance = f"on {trials.scenario.vehicle.autopilot}", trials.scenario.safety.chance
    if chance is None:
        why = f"a path exists, but flights {who} would leave it"
    else:
        why = f"a path exists, but {100 * (1 - chance):g} % of flights {who} would not keep it"
    helps, hint, remedies = _try_changes(round_it, trials)
    return NoPath(f"{why}: {words}; {helps}", hint=hint, remedies=remedies)


def _leg(nearest: Attempt, tightest: Kept) -> str:
    at, curve = nearest.plan.via_at, nearest.plan.curve
    if not len(at):
        return ""
    along = np.linspace(0.0, 1.0, 2000)
    here = along[np.argmin(np.linalg.norm(curve.points(along) - np.array(tightest.place), axis=1))]
    names = place_names(nearest.scenario.places)
    leg = int(np.searchsorted(at, here))
    return f", on the leg from {names[leg]} to {names[leg + 1]}"


def _gap(tightest: Kept, airspace: Airspace) -> str:
    spot, needed = np.array(tightest.place), tightest.required + tightest.nominal - tightest.kept
    apart, other = _across(spot, tightest.to, needed, airspace)
    if other is not None and apart < 2 * needed:
        names = f"{tightest.to} and {other}"
        return f"the gap between {names} is {down(apart):.2f} m wide, and it needs {up(2 * needed):.2f} m"
    return f"{down(tightest.nominal):.2f} m from {tightest.to}, where it needs {up(needed):.2f} m"


def _across(spot: np.ndarray, name: str, needed: float, airspace: Airspace) -> tuple[float, str | None]:
    """Return the level width [m] to the opposite obstacle, and its name or None."""
    import shapely

    point = shapely.Point(spot[:2])
    bodies = [body for body, _, _ in airspace.near(spot[None], 4 * needed)]
    first = next((body for body in bodies if body.name == name), None)
    if first is None:
        return np.inf, None

    def towards(body: Obstacle) -> np.ndarray:
        line = shapely.shortest_line(point, body.plan)
        return np.asarray(np.diff(shapely.get_coordinates(line), axis=0)[0])

    ahead, best, found = towards(first), np.inf, None
    for body in bodies:
        aside = towards(body)
        cosine = float(aside @ ahead) / max(float(np.linalg.norm(aside) * np.linalg.norm(ahead)), 1e-9)
        width = float(shapely.distance(body.plan, first.plan))
        if body is not first and cosine <= OPPOSITE and width < best:
            best, found = width, body.name
    return best, found


def _try_changes(round_it: str, trials: ChangeTrials) -> tuple[str, str, tuple[Remedy, ...]]:
    """Return a description, a hint and the first change that helps."""
    tried = list[Remedy]()
    for change in trials.changes:
        if (found := trials.at(change)) is None:
            tried.append(change)
            continue
        kept = found.promise.clearance
        with_it = "" if kept is None else f" with {down(kept.kept):.2f} m kept"
        return f"{change} plans it{with_it}", f"{change}, which was tried; or leave a wider way", (change,)
    return (
        f"these changes did not help: {', '.join(map(str, tried))}",
        f"leave a wider way there, or a smaller safety_distance{round_it}",
        (),
    )
