import math
from collections.abc import Iterator

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.centimeters import down, up
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.deviation.promise import Promise
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places
from ipoa_mission.forecast.itinerary.program import as_flown
from ipoa_mission.forecast.timing.bound import least_time
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.forecast.timing.route_time import kinematics
from ipoa_mission.geometry import Points
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.planning.sketch import Sketch
from ipoa_mission.planning.spline import Spline
from ipoa_mission.report import drawn_flight
from ipoa_mission.report.panels.contingency_panel import return_paths
from ipoa_mission.report.panels.profile import near_track
from ipoa_mission.scenario import Scenario
from ipoa_mission.studio import answers
from ipoa_mission.studio.handed import proof_digest
from ipoa_mission.studio.view import line_of, on_map, without_folders
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.terrain import Flat

SAMPLES = 500
NEAR_PLACES, NEAR_FACTOR = 5, 1.5  # and multiple of the required clearance
SLOW_ITEMS = 4
UNKNOWN_EXTENT = 1e7  # [m]


def sketched(sketch: Sketch, scenario: Scenario, revision: int, number: int | None, took_s: float) -> answers.Sketch:
    """Show a coarse path; its time is a lower bound by the vehicle's limits."""
    vehicle, frame = scenario.vehicle, scenario.frame
    points = _sampled(sketch.curve)
    limits = kinematics(vehicle.autopilot, vehicle.autopilot_parameters(), vehicle.cruise_speed)
    clearance = sketch.proof.clearance
    return answers.Sketch(
        revision=revision,
        number=number,
        line=line_of(frame, points),
        others=tuple(line_of(frame, _sampled(other)) for other in sketch.others),
        holds=sketch.proof.holds,
        verdict=without_folders(sketch.proof.words(), scenario),
        length=round(float(sketch.curve.length), 1),
        clearance=round(float(clearance.distance), 2),
        nearest=without_folders(clearance.what, scenario),
        seconds=round(least_time(points, limits).seconds, 1),
        took_s=round(took_s, 3),
    )


def planned(flight: Flight, revision: int, took_s: float) -> answers.Plan:
    plan, scenario = expected(flight.forecast, flight.name, revision, took_s), flight.scenario
    proved = {
        "of": "scenario",
        "proof": proof_digest(flight),
        "choices": tuple(_choices(flight)),
        "limits": tuple(_limits(flight)),
        "warnings": tuple(without_folders(finding.message, scenario) for finding in flight.findings),
        "remarks": flight.notes,
    }
    return plan.model_copy(update=proved)


def expected(forecast: Forecast, name: str, revision: int, took_s: float) -> answers.Plan:
    """Show a forecast; its clearance only with a scenario."""
    scenario, estimate = forecast.scenario, forecast.estimate
    course = course_of(forecast)
    promise = None if scenario is None else forecast.promise_if_known
    kept = None if promise is None else promise.clearance
    budget = budget_of(forecast) if forecast.energy is not None else None
    left = None if budget is None else budget.left(budget.used.between)
    rim = None if scenario is None or promise is None else drawn_flight.shown_deviation_bound(forecast)
    ring = [] if rim is None else drawn_flight.outline_around(course.points, rim.level)
    near = () if scenario is None else _near_things(promise, course, scenario)
    return answers.Plan(
        of="mission",
        revision=revision,
        name=name,
        proof="",
        verdict="" if scenario is None or not forecast.cruise else without_folders(forecast.proof.words(), scenario),
        confidence=None if promise is None else promise.confidence,
        kept=None if kept is None else down(kept.kept),
        nominal=None if kept is None else down(kept.nominal),
        required=0.0 if scenario is None else up(scenario.limits.obstacle_distance if kept is None else kept.required),
        nearest="" if scenario is None or kept is None else without_folders(kept.to, scenario),
        total_s=round(estimate.total_s, 2),
        low_s=round(estimate.low_s, 2),
        high_s=round(estimate.high_s, 2),
        length=round(float(course.along[-1]), 1),
        energy_wh=None if budget is None else round(budget.used.energy_wh, 2),
        battery_left=None if left is None else round(left.likely, 3),
        tube_ring=tuple(on_map(forecast.frame, one) for one in ring),
        course=_course(course, forecast),
        beside=() if scenario is None else tuple(_beside(course, scenario)),
        stops=tuple(_stops(forecast, course)),
        bindings=(*near, *_slow_items(estimate, course)),
        homeward=() if promise is None else _homeward(forecast),
        choices=(),
        limits=(),
        warnings=(),
        remarks=tuple(estimate.remarks),
        took_s=round(took_s, 2),
    )


def course_of(forecast: Forecast) -> drawn_flight.SampledTrack:
    nowhere = Airspace(Bounds((-UNKNOWN_EXTENT,) * 3, (UNKNOWN_EXTENT,) * 3), Flat())
    airspace = nowhere if forecast.scenario is None else forecast.scenario.airspace
    return drawn_flight.sample_track(forecast.estimate.track, airspace, SAMPLES)


def _sampled(curve: Spline) -> Points:
    return curve.sample(math.ceil(min(max(curve.length / 2.0, 40.0), 400.0)))


def _course(course: drawn_flight.SampledTrack, forecast: Forecast) -> answers.Course:
    apart = [round(value, 2) if math.isfinite(value) else None for value in course.apart.tolist()]
    return answers.Course(
        line=line_of(forecast.frame, course.points),
        times=tuple(course.times.round(2).tolist()),
        along=tuple(course.along.round(1).tolist()),
        speeds=tuple(course.speeds.round(2).tolist()),
        ground=tuple(course.ground.round(2).tolist()),
        apart=tuple(apart),
        returns_at=_turns_home(course, forecast),
    )


def _turns_home(course: drawn_flight.SampledTrack, forecast: Forecast) -> int | None:
    items = forecast.estimate.items
    if len(items) < 2:
        return None
    *others, last = items
    is_return = forecast.mission.items[last.seq - 1].command == Command.NAV_RETURN_TO_LAUNCH
    return course.nearest(others[-1].done_s) if is_return else None


def _homeward(forecast: Forecast) -> tuple[answers.Homeward, ...]:
    return tuple(
        answers.Homeward(from_s=way["from"], clear=way["clear"], line=line_of(forecast.frame, np.array(way["points"])))
        for way in return_paths(forecast)
    )


def _stops(forecast: Forecast, course: drawn_flight.SampledTrack) -> Iterator[answers.Stop]:
    flown, scenario = as_flown(forecast.mission), forecast.scenario
    over = forecast.ground if scenario is None else scenario.airspace.ground
    places = item_places(flown, forecast.frame, over)
    for time in forecast.estimate.items:
        place = places[time.seq - 1]
        if place is not None and flown.items[time.seq - 1].command == Command.NAV_LAND:
            place[2] = over(place[None, :])[0]
        yield answers.Stop(
            seq=time.seq,
            at=course.nearest(time.done_s),
            words=item_words(flown.items[time.seq - 1]),
            done_s=round(time.done_s, 1),
            duration_s=round(time.duration_s, 1),
            place=None if place is None else on_map(forecast.frame, place[None, :])[0],
            up=None if place is None else round(float(place[2]), 1),
            above_ground=None
            if place is None or scenario is None
            else round(float(place[2] - over(place[None, :])[0]), 1),
        )


def _beside(course: drawn_flight.SampledTrack, scenario: Scenario) -> Iterator[answers.Beside]:
    for body, (begins, ends), look in near_track(course, scenario.airspace, scenario.limits.obstacle_distance):
        base, top = body.bounds[:, 2].round(2).tolist()
        name = without_folders(body.name, scenario)
        yield answers.Beside(name=name, look=look, begins=round(begins, 1), ends=round(ends, 1), base=base, top=top)


def _near_things(
    promise: Promise | None, course: drawn_flight.SampledTrack, scenario: Scenario
) -> Iterator[answers.Binding]:
    """Yield places too near to the flight, and the nearest, worst first."""
    for danger in drawn_flight.find_dangers(course, scenario):
        yield answers.Binding(what="danger", words=danger.words, at=int(np.argmin(course.apart)))
    limits = () if promise is None else promise.limits
    for check in sorted(limits, key=lambda kept: kept.slack)[:NEAR_PLACES]:
        if promise is not None and math.isfinite(check.kept) and check.slack < NEAR_FACTOR * check.required + 1.0:
            at = int(np.argmin(np.linalg.norm(course.points - np.array(check.place), axis=1)))
            part, share = (f", in {check.part}", None) if check.part else ("", promise.confidence)
            words = f"{check.limit}, to {check.to}{part}: {check.words(share)}"
            yield answers.Binding(what="near", words=without_folders(words, scenario), at=at)


def _slow_items(estimate: Estimate, course: drawn_flight.SampledTrack) -> Iterator[answers.Binding]:
    slow = sorted((item for item in estimate.items if item.reason), key=lambda item: -item.duration_s)
    for item in sorted(slow[:SLOW_ITEMS], key=lambda item: item.done_s):
        words = f"item {item.seq}: {item.reason}, {item.mean_speed:.1f} m/s on average"
        yield answers.Binding(what="slow", words=words, at=course.nearest(item.done_s))


def _choices(flight: Flight) -> Iterator[answers.Choice]:
    for option in flight.options:
        yield answers.Choice(
            mode=option.mode,
            waypoints=len(option.route.points),
            seconds=option.seconds,
            deviation=option.deviation,
            flies_clear=option.flies_clear,
            chosen=option.mode == flight.scenario.route.mode,
        )


def _limits(flight: Flight) -> Iterator[answers.Limit]:
    for check in flight.proof.checks:
        if math.isfinite(check.nearest.distance):
            yield answers.Limit(
                limit=check.limit,
                words=without_folders(check.words(), flight.scenario),
                found=round(float(check.nearest.distance), 3),
                required=round(float(check.required), 3),
                unit=check.unit,
                holds=check.holds,
            )
