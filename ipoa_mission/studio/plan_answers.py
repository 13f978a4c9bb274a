import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ipoa_mission import Airspace, Bounds, Command, Flat, Flight, Forecast, Scenario
from ipoa_mission.autopilot.failsafe import TIMED, Contingency
from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.forecast.contingency.contingencies import Contingencies, ContingencyRow, Grade, PredictedContingency
from ipoa_mission.forecast.contingency.contingencies_now import DURATIONS
from ipoa_mission.forecast.contingency.energy_budget import Budget, budget_of
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.planning.planner import Sketch
from ipoa_mission.report import drawn_flight
from ipoa_mission.report.drawn_flight import SampledTrack
from ipoa_mission.report.panels.contingency_panel import GRADE_LOOKS, contingency_bars, return_paths, stretches
from ipoa_mission.report.panels.profile import NearbyObstacle, near_track
from ipoa_mission.studio import answers
from ipoa_mission.studio.view import line_of, on_map, without_folders

UNKNOWN_EXTENT = 1e7  # [m]


def sketched(sketch: Sketch, scenario: Scenario, number: int | None) -> answers.Sketch:
    """Return a coarse path; its time is a lower bound."""
    vehicle = scenario.vehicle
    curves = (sketch.curve, *sketch.others)
    points, *others = (curve.sample(math.ceil(min(max(curve.length / 2.0, 40.0), 400.0))) for curve in curves)
    limits = vehicle.autopilot.part(FlightModel).kinematics(vehicle.autopilot_parameters(), vehicle.cruise_speed)
    east, north, up = np.diff(points, axis=0).T
    rises = np.where(up > 0.0, up / limits.climb, -up / limits.descent)
    return answers.Sketch(
        number=number,
        line=line_of(scenario.frame, points),
        others=tuple(line_of(scenario.frame, other) for other in others),
        is_proved=sketch.proof.is_proved,
        verdict=without_folders(sketch.proof.words(), scenario),
        length=round(float(sketch.curve.length), 1),
        clearance=round(float(sketch.proof.clearance.distance), 2),
        nearest=without_folders(sketch.proof.clearance.what, scenario),
        seconds=round(float(np.maximum(np.hypot(east, north) / limits.speed, rises).sum()), 1),
    )


def planned(flight: Flight, proof: str) -> answers.Plan:
    proved = {
        "of": "scenario",
        "proof": proof,
        "waypoints": len(flight.chosen.route.points),
        "limits": tuple(_limits(flight)),
        "warnings": tuple(without_folders(finding.message, flight.scenario) for finding in flight.findings),
        "remarks": flight.notes,
    }
    return expected(flight.forecast, flight.name).model_copy(update=proved)


def expected(forecast: Forecast, name: str) -> answers.Plan:
    scenario = forecast.scenario
    estimate = forecast.estimate
    course = course_of(forecast)
    frame = forecast.frame
    guarantee = None if scenario is None else forecast.guarantee_if_known
    kept = None if guarantee is None else guarantee.clearance
    required = 0.0 if scenario is None else scenario.limits.obstacle_distance
    if kept is not None:
        required = kept.required
    budget = budget_of(forecast)
    left = None if budget is None else budget.left(budget.used.between)
    deviation_m = 0.0 if guarantee is None else drawn_flight.shown_deviation_bound(forecast).lateral
    return answers.Plan(
        name=name,
        verdict="" if scenario is None or not forecast.cruise else without_folders(forecast.proof.words(), scenario),
        confidence=None if guarantee is None else guarantee.confidence,
        kept=None if kept is None else floor_cm(kept.guaranteed),
        nominal=None if kept is None else floor_cm(kept.nominal),
        required=ceil_cm(required),
        nearest="" if scenario is None or kept is None else without_folders(kept.to, scenario),
        total_s=round(estimate.total_s, 2),
        low_s=round(estimate.low_s, 2),
        high_s=round(estimate.high_s, 2),
        length=round(float(course.along[-1]), 1),
        energy_wh=None if budget is None else round(budget.used.energy_wh, 2),
        battery_left=None if left is None else round(left.likely, 3),
        deviation_ring=tuple(on_map(frame, ring) for ring in drawn_flight.outline_around(course.points, deviation_m)),
        course=answers.Course(
            line=line_of(frame, course.points),
            times=course.times.round(2).tolist(),
            along=course.along.round(1).tolist(),
            speeds=course.speeds.round(2).tolist(),
            ground=course.ground.round(2).tolist(),
            apart=tuple(value if math.isfinite(value) else None for value in course.apart.round(2).tolist()),
            returns_at=_turns_home(course, forecast),
        ),
        nearby=() if scenario is None else tuple(_nearby(course, scenario)),
        stops=tuple(_stops(forecast, course)),
        bindings=(*_near_places(guarantee, course, scenario), *_slow_items(estimate, course)),
        homeward=tuple(
            answers.Homeward(from_s=path["from"], clear=path["clear"], line=line_of(frame, np.array(path["points"])))
            for path in ([] if guarantee is None else return_paths(forecast))
        ),
        remarks=tuple(estimate.remarks),
    )


def course_of(forecast: Forecast) -> SampledTrack:
    nowhere = Airspace(Bounds((-UNKNOWN_EXTENT,) * 3, (UNKNOWN_EXTENT,) * 3), Flat())
    airspace = nowhere if forecast.scenario is None else forecast.scenario.airspace
    return drawn_flight.sample_track(forecast.estimate.track, airspace, samples=500)


def _turns_home(course: SampledTrack, forecast: Forecast) -> int | None:
    items = forecast.estimate.items
    if len(items) < 2:
        return None
    before, last = items[-2:]
    is_return = forecast.mission.items[last.seq - 1].command == Command.NAV_RETURN_TO_LAUNCH
    return course.nearest(before.done_s) if is_return else None


def _stops(forecast: Forecast, course: SampledTrack) -> Iterator[answers.Stop]:
    scenario = forecast.scenario
    items = drawn_flight.placed_items(forecast)
    for time in forecast.estimate.items:
        item, place = items[time.seq - 1]
        above = None
        if place is not None and scenario is not None:
            above = round(float(place[2] - scenario.airspace.ground(place[None, :])[0]), 1)
        yield answers.Stop(
            seq=time.seq,
            at=course.nearest(time.done_s),
            words=item_words(item),
            done_s=round(time.done_s, 1),
            place=None if place is None else on_map(forecast.frame, place[None, :])[0],
            up=None if place is None else round(float(place[2]), 1),
            above_ground=above,
        )


def _nearby(course: SampledTrack, scenario: Scenario) -> Iterator[NearbyObstacle]:
    for one in near_track(course, scenario.airspace, scenario.limits.obstacle_distance):
        yield replace(one, name=without_folders(one.name, scenario))


def _near_places(
    guarantee: ClearanceGuarantee | None, course: SampledTrack, scenario: Scenario | None
) -> Iterator[answers.Binding]:
    if scenario is None:
        return
    for danger in drawn_flight.find_dangers(course, scenario):
        yield answers.Binding(what="danger", words=danger.words, at=int(np.argmin(course.apart)))
    if guarantee is None:
        return
    for limit in sorted(guarantee.limits, key=lambda limit: limit.slack)[:5]:
        if math.isfinite(limit.guaranteed) and limit.slack < 1.5 * limit.required + 1.0:
            sample = int(np.argmin(np.linalg.norm(course.points - np.array(limit.place), axis=1)))
            part = f", in {limit.part}" if limit.part else ""
            confidence = None if limit.part else guarantee.confidence
            words = f"{limit.limit}, to {limit.to}{part}: {limit.words(confidence)}"
            yield answers.Binding(what="near", words=without_folders(words, scenario), at=sample)


def _slow_items(estimate: Estimate, course: SampledTrack) -> Iterator[answers.Binding]:
    slow = sorted((item for item in estimate.items if item.reason), key=lambda item: -item.duration_s)
    for item in sorted(slow[:4], key=lambda item: item.done_s):
        words = f"item {item.seq}: {item.reason}, {item.mean_speed:.1f} m/s on average"
        yield answers.Binding(what="slow", words=words, at=course.nearest(item.done_s))


def _limits(flight: Flight) -> Iterator[answers.Limit]:
    for check in flight.proof.checks:
        if math.isfinite(check.nearest.distance):
            words = without_folders(check.words(), flight.scenario)
            yield answers.Limit(limit=check.limit, words=words, is_kept=check.is_kept)


def strips_of(forecast: Forecast, flight: int) -> Iterator[answers.ContingencyStrip]:
    """Yield the strip at once, and again with costs."""
    bars = {} if forecast.scenario is None else contingency_bars(forecast)
    if not bars:
        yield answers.ContingencyStrip(flight=flight, reserve=None, bars=())
        return

    budget = budget_of(forecast)
    reserve = None if budget is None or budget.battery is None else budget.battery.reserve
    course = course_of(forecast)
    drawn = [
        answers.StripBar(contingency=contingency, stretches=_stretches(rows, course, forecast.world), costs=())
        for contingency, rows in bars.items()
    ]
    yield answers.ContingencyStrip(flight=flight, reserve=reserve, bars=tuple(drawn))
    costs = [tuple(_costs(rows, forecast, budget)) for rows in bars.values()]
    full = (bar.model_copy(update={"costs": cost}) for bar, cost in zip(drawn, costs, strict=True))
    yield answers.ContingencyStrip(flight=flight, reserve=reserve, bars=tuple(full))


def _stretches(
    rows: tuple[ContingencyRow, ...], course: SampledTrack, scenario: Scenario
) -> tuple[answers.StripStretch, ...]:
    return tuple(
        answers.StripStretch(
            look=GRADE_LOOKS[row.grade],
            from_s=round(row.from_s, 2),
            to_s=round(row.to_s, 2),
            begins=round(begins, 1),
            ends=round(ends, 1),
            words=without_folders(row.in_full, scenario),
        )
        for row, begins, ends in stretches(rows, course)
    )


def _costs(rows: tuple[ContingencyRow, ...], forecast: Forecast, budget: Budget | None) -> Iterator[answers.StripCost]:
    if rows[0].contingency not in TIMED or rows[0].grade is Grade.UNKNOWN:
        return
    for time, predicted in sorted(_sampled_costs(rows[0].contingency, forecast.cached(Contingencies)).items()):
        low, high = predicted.duration_s
        used = predicted.used
        left = None if budget is None or used is None else budget.left(budget.taken(time, used))
        yield answers.StripCost(
            at_s=round(time, 2),
            seconds=(round(low, 1), round(high, 1)),
            energy_wh=None if used is None else (round(used.between.low, 2), round(used.between.high, 2)),
            lands=None if left is None else round(left.likely, 3),
            least=None if left is None else round(left.low, 3),
            most=None if left is None else round(left.high, 3),
        )


def _sampled_costs(contingency: Contingency, contingencies: Contingencies) -> dict[float, PredictedContingency]:
    """Return costs at up to 24 times, denser at jumps."""
    begin, end = contingencies.in_air
    evenly = np.linspace(begin, end, min(16, 2 + math.floor((end - begin) / DURATIONS.step_s))).tolist()
    predicted = ((time, contingencies.predicted(contingency, time)) for time in evenly)
    costs = {time: cost for time, cost in predicted if cost is not None}
    while len(costs) < 24:
        wide = [(a, b) for a, b in pairwise(sorted(costs)) if b - a > DURATIONS.min_step_s]
        mean_s = {time: sum(cost.duration_s) / 2 for time, cost in costs.items()}
        steep = [(abs(mean_s[b] - mean_s[a]) / (b - a), (a + b) / 2) for a, b in wide]
        steepest, middle = max(steep, default=(0.0, 0.0))
        cost = contingencies.predicted(contingency, middle) if steepest >= DURATIONS.max_slope else None
        if cost is None:
            break
        costs[middle] = cost
    return costs
