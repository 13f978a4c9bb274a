"""Find the quickest waypoints along a curve for its autopilot."""

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np

from ipoa_mission.forecast.deviation.kept_limits import clearance_task
from ipoa_mission.forecast.deviation.room import with_room
from ipoa_mission.geometry import Points, leg_lengths
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.plan import Plan
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import VISITED
from ipoa_mission.routing.candidates import NEAREST, candidates
from ipoa_mission.routing.route import push_clear
from ipoa_mission.scenario import Scenario


@dataclass(frozen=True)
class RouteSearch:
    starts: int = 2  # routes to improve
    most_behind: float = 1.06  # of the second start's time to the first's
    trials: int = 60
    legs: int = 2000  # in all trials
    patience: int = 25  # trials without gain
    step_shares: tuple[float, ...] = (0.5, 0.2)  # of the tolerance
    least_gain_s: float = 0.1
    equal_share: float = 0.005  # of the time, of equally quick routes
    most_overrun: float = 0.5  # [m]


SEARCH = RouteSearch()
TIGHT_PLACES = 0.5  # if no route fits without extra room


def fastest_route(plan: Plan, scenario: Scenario) -> Attempt | None:
    """Return the quickest route within `route.tolerance` and every limit.

    Among equally quick routes, prefer the fewest missed waypoints, then the greatest margin.
    """
    drawn = [Attempt(plan, route, scenario) for route in candidates(plan.curve, scenario)]
    quickest = _quickest(drawn, scenario) or _quickest(drawn, with_room(clearance_task(scenario), TIGHT_PLACES))
    improved = list(dict.fromkeys(ready for attempt in quickest for ready in (attempt, _improve(attempt))))
    if len(improved) < 2:
        return improved[0] if improved else None
    ends = [attempt.flown for attempt in improved]
    equal = (1 + SEARCH.equal_share) * min(end.seconds + end.late for end in ends)
    ranks = [(end.seconds + end.late > equal, round(end.missed, 2), -end.slack, n) for n, end in enumerate(ends)]
    return improved[min(ranks)[-1]]


def _quickest(drawn: list[Attempt], roomy: PathTask) -> list[Attempt]:
    """Return the quickest valid routes with different numbers of waypoints; clear as few as possible."""
    waiting = [(attempt.sketched.seconds, n, False, attempt) for n, attempt in enumerate(drawn)]
    heapify(waiting)
    cleared, fit = dict[bytes, Points](), dict[tuple[int, bool], Attempt]()
    while waiting and len(fit) < SEARCH.starts:
        seconds, n, is_clear, attempt = heappop(waiting)
        if fit and seconds > SEARCH.most_behind * min(other.sketched.seconds for other in fit.values()):
            break
        points = attempt.route.points
        kind, place = (len(points), attempt.route.spline), points.tobytes()
        if kind in fit:
            continue
        if is_clear:
            if _is_fit(attempt):
                fit[kind] = attempt
            continue
        if place not in cleared:
            cleared[place] = push_clear(points, roomy)
        if leg_lengths(cleared[place]).min() >= NEAREST:
            clear = attempt if (cleared[place] == points).all() else attempt.along(cleared[place])
            heappush(waiting, (clear.sketched.seconds, n, True, clear))
    return list(fit.values())


def _is_fit(attempt: Attempt) -> bool:
    flown = attempt.sketched
    return (
        flown.overrun <= SEARCH.most_overrun
        and flown.deviation <= attempt.scenario.route.tolerance
        and attempt.proof.holds
        and flown.keeps_limits
    )


def _improve(attempt: Attempt) -> Attempt:
    scenario, tried = attempt.scenario, set[bytes]()
    trials = min(SEARCH.trials, SEARCH.legs // len(attempt.route.points))
    for share in SEARCH.step_shares:
        step, at, in_vain = share * scenario.route.tolerance, 0, 0
        changes = [*_changes(attempt.route.points, step, scenario.via_points, tried)]
        while len(tried) < trials and in_vain < min(SEARCH.patience, len(changes)):
            candidate = attempt.along(changes[at % len(changes)])
            tried.add(candidate.route.points.tobytes())
            if candidate.sketched.seconds < attempt.sketched.seconds - SEARCH.least_gain_s and _is_fit(candidate):
                attempt, in_vain = candidate, 0
                changes = [*_changes(attempt.route.points, step, scenario.via_points, tried)]
            else:
                at, in_vain = at + 1, in_vain + 1
    return attempt


def _changes(points: Points, step: float, via: Points, tried: set[bytes]) -> Iterator[Points]:
    """Yield the waypoints with one removed or moved by `step` [m]."""
    free = [i for i in range(1, len(points) - 1) if (np.linalg.norm(via - points[i], axis=1) > VISITED).all()]
    for i in free:
        if (without := np.delete(points, i, axis=0)).tobytes() not in tried:
            yield without
    for i in free:
        ahead = points[i + 1, :2] - points[i - 1, :2]
        ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
        for move in ((-ahead[1], ahead[0], 0.0), (ahead[1], -ahead[0], 0.0), (*ahead, 0.0), (*-ahead, 0.0)):
            moved = points.copy()
            moved[i] += step * np.array(move)
            if leg_lengths(moved).min() >= NEAREST:
                yield moved
