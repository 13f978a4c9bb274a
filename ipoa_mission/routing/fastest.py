"""Find the quickest waypoints along a curve for its autopilot."""

import math
from collections.abc import Iterator
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import ipoa_mission.routing.resample as resample
from ipoa_mission.centimeters import ceil_cm
from ipoa_mission.forecast.deviation.clearance_guarantee import limits_broken_by_deviation
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, with_margins
from ipoa_mission.forecast.deviation.proximity import proximity_risks
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.forecast.timing.track import pieces_of
from ipoa_mission.geometry import Matrix, Points, Vector, arc_lengths, leg_lengths
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.proof import unproved_legs
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.build import VISITED
from ipoa_mission.scenario import Scenario


class Composition(NamedTuple):
    """Each level: width as a share of the tolerance, PX4's acceptance radius [m], expected tight places."""

    levels: tuple[tuple[float, float, float], ...] = (
        (1.0, 10.0, 0.5), (0.6, 10.0, 0.5), (0.3, 7.0, 1.0), (0.3, 4.0, 10.0), (0.1, 2.0, 100.0), (0.03, 0.0, 100.0),
    )  # fmt: skip
    spacings: tuple[float, ...] = (6.0, 2.5)  # of even levels [m]
    max_rounds: int = 16
    min_spacing: float = 1.0  # where two levels meet [m]
    remaining_risk: float = 0.7  # share of the chance that unchanged passings may take


COMPOSITION = Composition()


def composed_route(plan: Plan, scenario: Scenario) -> Attempt:
    """Return the first route that is fit and guaranteed, or the best fit one, or the last.

    Each round approximates the curve tighter at the legs that break a limit.
    """
    fit = list[Attempt]()
    levels = _approximations(plan, scenario)
    chosen = np.zeros(1 + int(max(level.stations[-1] for level in levels)), int)  # by meter
    remaining = COMPOSITION.remaining_risk
    for _ in range(COMPOSITION.max_rounds):
        points, stations, radii = _composed(levels, chosen)
        radius = radii if scenario.vehicle.autopilot.guidance.turns_at_acceptance_radius else 0.0
        attempt = Attempt(plan, resample.Route(points, radius=radius), scenario)
        places = list[tuple[float, float, float]]()
        if attempt.is_fit:
            if attempt.is_guaranteed:
                return attempt
            fit.append(attempt)
            places = [kept.place for kept in attempt.built.guarantee.forbidding]
        before = chosen.copy()
        for station in _broken(attempt, stations, places, remaining):
            now = int(before[int(station)])
            leg = int(np.searchsorted(stations[1:-1], station, "right"))
            more = 1 if now == len(levels) - 1 else 0  # adjacent legs: then it is approached slower
            begin = stations[max(leg - more, 0)]
            end = stations[min(leg + 1 + more, len(stations) - 1)]
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
    curve = plan.curve
    via = scenario.via_points
    task = clearance_task(scenario)
    lines = [
        (*resample.corridor(curve, width * scenario.route.tolerance, via=via), radius, tight)
        for width, radius, tight in COMPOSITION.levels
    ]
    for spacing in COMPOSITION.spacings:
        even = resample.every(curve, spacing, via)
        lines.append((even, np.linspace(0.0, curve.length, len(even)), 0.0, COMPOSITION.levels[-1][-1]))
    levels = []
    for points, stations, radius, tight in lines:
        given = (points[:, None] == scenario.places).all(axis=2).any(axis=1)
        given[[0, -1]] = True
        levels.append(
            _Level(resample.push_clear(points, with_margins(task, tight, keep_gaps=True)), stations, given, radius)
        )
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
        if kept and row[0] - kept[-1][0] < COMPOSITION.min_spacing:
            if not row[1]:
                continue
            if not kept[-1][1]:
                kept.pop()
        kept.append(row)
    parts = [(levels[number].points[n], station, levels[number].radius) for station, _, number, n in kept]
    points, stations, radii = map(np.array, zip(*parts, strict=True))
    return points, stations, radii


def _broken(attempt: Attempt, stations: Vector, places: list[tuple[float, float, float]], risk: float) -> Vector:
    """Return stations [m] of `places`, of broken limits, and of the likeliest shortfall."""
    tolerance = attempt.scenario.route.tolerance
    task = clearance_task(attempt.scenario)
    airspace = task.path.airspace
    required = ceil_cm(task.path.limits.obstacle_distance)
    flown = pieces_of(attempt.quick_prediction.track)
    samples, line = resample.curve_samples(attempt.plan.curve)
    is_broken = (airspace.obstacle_distance(flown.points) < required) | resample.is_far(flown.points, line, tolerance)
    for place in [*places, *(check.nearest.place for check in limits_broken_by_deviation(flown.points, task))]:
        is_broken[np.argmin(np.linalg.norm(flown.points - place, axis=1))] = True
    times = flown.times[is_broken]
    if task.chance is not None:
        risks = proximity_risks(flown, airspace, task.law, required)
        times = np.append(times, risks.seconds[risks.likeliest_passings(required, risk * task.chance)])
    broken = [
        np.interp(times, attempt.quick_prediction.reached, stations),
        arc_lengths(samples)[resample.is_far(samples, flown.points, tolerance)],
        ((stations[:-1] + stations[1:]) / 2)[list(unproved_legs(attempt.route.points, attempt.scenario))],
    ]
    return np.unique(np.concatenate(broken).clip(stations[0], stations[-1]))


def relaxed(curve: Spline, room: float, via: Points) -> Points:
    """Return places (n, 3) of the line with least bending within `room` [m] of the curve, through via points (m, 3)."""
    count = int(np.clip(math.ceil(curve.length / 3.0), 8, 200))  # one each 3 m
    samples, stops = resample.through(curve.sample(count + 1), via)
    free = np.setdiff1d(np.arange(1, len(samples) - 1), stops)
    if room <= 0 or len(free) == 0:
        return samples
    aside = resample.lefts(samples)[:, :2]
    bend = np.diff(np.eye(len(samples)), 2, axis=0)  # curvature
    system = np.vstack([(bend * aside[:, axis])[:, free] for axis in (0, 1)])
    wanted = -np.concatenate([bend @ samples[:, axis] for axis in (0, 1)])
    moved = _least_squares(system, wanted, room)
    samples[free, :2] += moved[:, None] * aside[free]
    return samples


def _least_squares(system: Matrix, wanted: Vector, room: float) -> Vector:
    """Solve for x (n,), |x| <= `room`, that minimizes |`system` x - `wanted`|, by projected Newton (Bertsekas 1982)."""
    from ipoa_mission.planning.banded import solve_banded

    hessian = system.T @ system
    toward = system.T @ wanted
    x = np.zeros(len(toward))
    cost = 0.0
    for _ in range(500):
        slope = hessian @ x - toward
        free = np.nonzero(((x > -room) | (slope <= 0)) & ((x < room) | (slope >= 0)))[0]
        band = np.zeros((3, len(free)))
        for k in range(min(3, len(free))):
            band[k, : len(free) - k] = hessian[free[k:], free[: len(free) - k]]
        step = np.zeros_like(x)
        step[free] = solve_banded(band, slope[free])[0]
        for share in 0.5 ** np.arange(30):
            trial = np.clip(x - share * step, -room, room)
            less = float(trial @ (hessian @ trial / 2 - toward))
            if less < cost:
                break
        if less >= cost - 1e-13 * abs(cost):
            break
        x = trial
        cost = less
    return x


NEAREST = 0.1  # between two waypoints [m]


class RouteGrid(NamedTuple):
    straight_shares: tuple[float, ...] = (1.0, 0.6, 0.3, 0.1)  # of the tolerance
    aside_share: float = 0.6
    turn_radii: tuple[float, ...] = (0.0, 4.0, 7.0, 10.0, 14.0)  # of PX4 [m]; 0: its parameter
    spline_shares: tuple[float, ...] = (0.8, 0.4, 0.0)  # of the tolerance
    spline_spacings: tuple[float, ...] = (40.0, 25.0, 12.0)  # [m]
    max_splines: int = 200


GRID = RouteGrid()


def candidates(curve: Spline, scenario: Scenario) -> Iterator[resample.Route]:
    guidance = scenario.vehicle.autopilot.guidance
    if guidance.flies_splines:
        yield from _splines(curve, scenario)
    drawn = set[bytes]()
    for share in GRID.straight_shares:
        width = share * scenario.route.tolerance
        beside = (-GRID.aside_share * width, 0.0, GRID.aside_share * width)
        for asides in (beside, resample.ON_THE_CURVE) if share == 1.0 else (beside,):
            points = resample.corridor(curve, width, asides, scenario.via_points)[0]
            if points.tobytes() in drawn:
                continue
            drawn.add(points.tobytes())
            has_radii = guidance.turns_at_acceptance_radius and len(points) > 2
            for radius in GRID.turn_radii if has_radii else GRID.turn_radii[:1]:
                yield resample.Route(points, radius=radius)


def braking_length(scenario: Scenario) -> float:
    """Return the braking distance on a curve [m]: v² / (2 a / 2), with half the acceleration."""
    limits = scenario.vehicle.autopilot.part(FlightModel).kinematics(scenario.vehicle.autopilot_parameters())
    return scenario.vehicle.cruise_speed**2 / limits.accel


def _splines(curve: Spline, scenario: Scenario) -> Iterator[resample.Route]:
    via = scenario.via_points
    for room in GRID.spline_shares:
        line = relaxed(curve, room * scenario.route.tolerance, via)
        length = float(leg_lengths(line).sum())
        whole = braking_length(scenario)
        brake = min(whole, length / 2)
        spacings = {max(spacing, length / GRID.max_splines) for spacing in GRID.spline_spacings if spacing < length / 2}
        for spacing in sorted(spacings, reverse=True):
            even = length / math.ceil(length / spacing)
            for last, on_curve in ((max(brake, even), True), (max(brake, even), False), (even, False)):
                points = resample.evenly_spaced(line, spacing, last, via)
                if leg_lengths(points).min() >= NEAREST and not (on_curve and last < whole):
                    yield resample.Route(points, spline=True, brakes_on_curve=on_curve)


class RouteSearch(NamedTuple):
    starts: int = 2  # routes to improve
    max_behind: float = 1.06  # of the second start's time to the first's
    trials: int = 36
    legs: int = 2000  # in all trials
    patience: int = 9  # trials without gain
    step_shares: tuple[float, ...] = (0.5, 0.2)  # of the tolerance
    min_gain_s: float = 0.1
    equal_share: float = 0.005  # of the time, of equally quick routes
    max_delay: float = 1.02  # flight time with noise to that without


SEARCH = RouteSearch()


def fastest_routes(plan: Plan, scenario: Scenario) -> list[Attempt]:
    """Return the quickest routes within all limits: fewest missed waypoints, then greatest margin, first."""
    drawn = [Attempt(plan, route, scenario) for route in candidates(plan.curve, scenario)]
    quickest = _quickest(drawn, scenario)
    most = SEARCH.max_behind * min(attempt.quick_prediction.seconds for attempt in drawn)
    if not quickest or quickest[0].quick_prediction.seconds > most:
        composed = composed_route(plan, scenario)
        if not composed.is_fit and not quickest:
            return [composed]
        quickest += [composed] if composed.is_fit else []
    routes = dict.fromkeys([*quickest, *map(_improve, quickest)])
    improved = sorted(routes, key=lambda each: each.quick_prediction.seconds)
    first = _best_of_equal(improved)
    return [first, *(attempt for attempt in improved if attempt is not first)]


def _best_of_equal(attempts: list[Attempt]) -> Attempt:
    """Return the best of the routes that are as quick as the first with sensor noise."""
    most = SEARCH.max_delay * attempts[0].quick_prediction.seconds
    equal = [attempt for attempt in attempts if attempt.quick_prediction.seconds <= most]
    if len(equal) == 1:
        return equal[0]
    ends = [attempt.prediction for attempt in equal]
    late = (1 + SEARCH.equal_share) * min(end.seconds + end.late for end in ends)
    ranks = [(end.seconds + end.late > late, round(end.missed, 2), -end.slack, n) for n, end in enumerate(ends)]
    return equal[min(ranks)[-1]]


def _quickest(drawn: list[Attempt], scenario: Scenario) -> list[Attempt]:
    waiting = [(attempt.quick_prediction.seconds, n, False, attempt) for n, attempt in enumerate(drawn)]
    heapify(waiting)
    cleared = dict[bytes, Points]()
    fit = dict[tuple[int, bool], Attempt]()
    while waiting and len(fit) < SEARCH.starts:
        seconds, n, is_clear, attempt = heappop(waiting)
        if fit and seconds > SEARCH.max_behind * min(other.quick_prediction.seconds for other in fit.values()):
            break
        points = attempt.route.points
        kind = (len(points), attempt.route.spline)
        if kind in fit:
            continue
        if is_clear:
            if attempt.is_fit:
                fit[kind] = attempt
            continue
        place = points.tobytes()
        if place not in cleared:
            cleared[place] = resample.push_clear(points, scenario)
        moved = cleared[place]
        if leg_lengths(moved).min() >= NEAREST:
            clear = attempt if (moved == points).all() else attempt.along(moved)
            heappush(waiting, (clear.quick_prediction.seconds, n, True, clear))
    return list(fit.values())


def _improve(attempt: Attempt) -> Attempt:
    if np.ndim(attempt.route.radius):
        return attempt
    scenario = attempt.scenario
    tried = set[bytes]()
    trials = min(SEARCH.trials, SEARCH.legs // len(attempt.route.points))
    for share in SEARCH.step_shares:
        step = share * scenario.route.tolerance
        at = 0
        in_vain = 0
        changes = [*_changes(attempt.route.points, step, scenario.via_points, tried)]
        while len(tried) < trials and in_vain < min(SEARCH.patience, len(changes)):
            candidate = attempt.along(changes[at % len(changes)])
            tried.add(candidate.route.points.tobytes())
            if (
                (candidate.route.spline or candidate.proof.is_proved)
                and candidate.quick_prediction.seconds < attempt.quick_prediction.seconds - SEARCH.min_gain_s
                and candidate.is_fit
            ):
                attempt = candidate
                in_vain = 0
                changes = [*_changes(attempt.route.points, step, scenario.via_points, tried)]
            else:
                at += 1
                in_vain += 1
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
