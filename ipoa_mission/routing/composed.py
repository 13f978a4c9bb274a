"""Compose a route of approximations of one curve: wide legs where there is room, tight ones near obstacles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.centimeters import up
from ipoa_mission.forecast.deviation.clearance_guarantee import broken_limits
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, with_margins
from ipoa_mission.forecast.deviation.proximity import proximity_risks
from ipoa_mission.forecast.timing.track import pieces_of
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.resample import corridor, curve_samples, every, is_far
from ipoa_mission.routing.route import Route, push_clear
from ipoa_mission.scenario import Scenario


class _Composing:
    """Each level has its width as a share of the tolerance, PX4's acceptance radius [m], and expected tight places."""

    levels: tuple[tuple[float, float, float], ...] = (
        (1.0, 10.0, 0.5), (0.6, 10.0, 0.5), (0.3, 7.0, 1.0), (0.3, 4.0, 10.0), (0.1, 2.0, 100.0), (0.03, 0.0, 100.0),
    )  # fmt: skip
    spacings: tuple[float, ...] = (6.0, 2.5)  # of even levels [m]
    max_rounds: int = 16
    least_spacing: float = 1.0  # where two levels meet [m]
    remaining_risk: float = 0.7  # share of the chance, of passings that stay as they are


def composed_route(plan: Plan, scenario: Scenario) -> Attempt:
    """Return the first route that is fit and guaranteed, or the best fit one, or the last.

    Each round predicts the flight, and approximates the curve tighter at the legs that break a limit.
    """
    fit, levels = list[Attempt](), _approximations(plan, scenario)
    chosen = np.zeros(1 + int(max(level.stations[-1] for level in levels)), int)  # by meter along the curve
    remaining = _Composing.remaining_risk
    for _ in range(_Composing.max_rounds):
        points, stations, radii = _composed(levels, chosen)
        radius = radii if scenario.vehicle.autopilot.guidance.takes_radius else 0.0
        attempt = Attempt(plan, Route(points, radius=radius), scenario)
        fit += [attempt] if attempt.is_fit else []
        forbidding = attempt.whole.guarantee.forbidding if attempt.is_fit else None
        if forbidding == ():
            return attempt
        before = chosen.copy()
        for station in _broken(attempt, stations, [kept.place for kept in forbidding or ()], remaining):
            now = int(before[int(station)])
            leg = int(np.searchsorted(stations[1:-1], station, "right"))
            beside = int(now == len(levels) - 1)  # then it is approached slower
            begin, end = stations[max(leg - beside, 0)], stations[min(leg + 1 + beside, len(stations) - 1)]
            on_leg = slice(int(begin), 1 + int(np.ceil(end)))
            chosen[on_leg] = np.maximum(chosen[on_leg], min(now + 1, len(levels) - 1))
        if (chosen == before).all():
            remaining /= 4
    return max(fit, key=lambda attempt: attempt.slack, default=attempt)


class _Level(NamedTuple):
    """Waypoints (k, 3), their stations along the curve (k,) [m], which are given places (k,), and a radius [m]."""

    points: Points
    stations: Vector
    given: NDArray[np.bool_]
    radius: float


def _approximations(plan: Plan, scenario: Scenario) -> list[_Level]:
    curve, via, task = plan.curve, scenario.via_points, clearance_task(scenario)
    lines = [
        (*corridor(curve, width * scenario.route.tolerance, via=via), radius, tight)
        for width, radius, tight in _Composing.levels
    ]
    for spacing in _Composing.spacings:
        even = every(curve, spacing, via)
        lines.append((even, np.linspace(0.0, curve.length, len(even)), 0.0, _Composing.levels[-1][-1]))
    levels = []
    for points, stations, radius, tight in lines:
        given = (points[:, None] == scenario.places).all(axis=2).any(axis=1)
        given[[0, -1]] = True
        levels.append(_Level(push_clear(points, with_margins(task, tight, keep_gaps=True)), stations, given, radius))
    return levels


def _composed(levels: list[_Level], chosen: NDArray[np.intp]) -> tuple[Points, Vector, Vector]:
    """Return waypoints, stations and radii of the level `chosen` at each meter (n,); given places only once."""
    rows = [
        (float(level.stations[n]), bool(level.given[n]), number, n)
        for number, level in enumerate(levels)
        for n in range(len(level.points))
        if (number == 0 if level.given[n] else chosen[int(level.stations[n])] == number)
    ]
    kept = rows[:0]
    for row in sorted(rows):
        if kept and row[0] - kept[-1][0] < _Composing.least_spacing:
            if not row[1]:
                continue
            if not kept[-1][1]:
                kept.pop()
        kept.append(row)
    parts = [(levels[number].points[n], station, levels[number].radius) for station, _, number, n in kept]
    points, stations, radii = map(np.array, zip(*parts, strict=True))
    return points, stations, radii


def _broken(attempt: Attempt, stations: Vector, places: list[tuple[float, float, float]], risk: float) -> Vector:
    """Return stations [m] of `places`, of broken limits, and where a flight is likeliest too near to something."""
    prediction, scenario, curve = attempt.quick_prediction, attempt.scenario, attempt.plan.curve
    task, tolerance = clearance_task(scenario), scenario.route.tolerance
    airspace, required = task.path.airspace, up(task.path.limits.obstacle_distance)
    flown, (samples, line) = pieces_of(prediction.track), curve_samples(curve)
    is_broken = (airspace.obstacle_distance(flown.points) < required) | is_far(flown.points, line, tolerance)
    for place in [*places, *(check.nearest.place for check in broken_limits(flown.points, task))]:
        is_broken[np.argmin(np.linalg.norm(flown.points - place, axis=1))] = True
    times = flown.times[is_broken]
    if task.chance is not None:
        risks = proximity_risks(flown, airspace, task.law, required)
        times = np.append(times, risks.seconds[risks.likeliest_passings(required, risk * task.chance)])
    legs = zip(attempt.route.points[:-1], attempt.route.points[1:], strict=True)
    unproved = [not attempt.proof.is_proved and not prove(np.array(leg), scenario, spare=0.0).is_proved for leg in legs]
    broken = [
        np.interp(times, prediction.reached, stations),
        arc_lengths(samples)[is_far(samples, flown.points, tolerance)],
        ((stations[:-1] + stations[1:]) / 2)[unproved],
    ]
    return np.unique(np.concatenate(broken).clip(stations[0], stations[-1]))
