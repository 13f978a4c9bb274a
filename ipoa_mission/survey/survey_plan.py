"""Split a survey's tour into forecast flights, so that all keep their clearance."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import shapely

from ipoa_mission import BadInput, Finding, Forecast, MissionError, NoPath, Scenario
from ipoa_mission.centimeters import floor_cm
from ipoa_mission.checks.check import check
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.errors import Remedy
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.energy_budget import budget_of, refusal_of
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, KeptLimit
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.geometry import Points, place_words
from ipoa_mission.progress import Progress, silent
from ipoa_mission.routing.planned_returns import choose_returns, other_options_hint, why_not_planned
from ipoa_mission.survey.assembly import assemble_survey
from ipoa_mission.survey.flown_coverage import (
    AsFlown,
    Coverage,
    Overlaps,
    as_flown,
    lines_of_forecast,
    predict_lines,
    smallest_overlaps,
)
from ipoa_mission.survey.resume import rest_of_tour
from ipoa_mission.survey.survey_task import SurveyTask, lay_lines, task_of
from ipoa_mission.survey.tour import Tour, fewest_parts, parts_of_equal_length
from ipoa_mission.world.obstacles import Obstacle

ROUNDS = 8  # with more clearance, at each speed
SPEEDS = (1.0, 0.7, 0.5)  # times the cruise speed


@dataclass(frozen=True, eq=False)
class SurveyFlight:
    tour: Tour
    forecast: Forecast
    findings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class SurveyPlan(SurveyTask):
    """A checked survey.

    `scenario` has the flown cruise speed, possibly lower than the file's. `is_rest`: `coverage` is that of all lines.
    """

    tour: Tour
    coverage: Coverage
    flights: tuple[SurveyFlight, ...]
    is_rest: bool = False

    @property
    def photos(self) -> int:
        return sum(self.sight.photos_of(flight.tour) for flight in self.flights)

    @cached_property
    def overlaps(self) -> Overlaps | None:
        if self.sight.trigger is None:
            return None
        lines = [line for flight in self.flights for line in lines_of_forecast(flight.forecast, self.sight.lag)]
        return smallest_overlaps(lines, self.sight, self.scenario.airspace.ground, self.free)

    @cached_property
    def flown(self) -> AsFlown | None:
        """Return the coverage as forecast, or None for the rest of a survey."""
        if self.is_rest:
            return None
        visible = self.area.visible(self.keep_out, self.sight.spacing)
        flights = (predict_lines(flight.forecast, flight.tour) for flight in self.flights)
        return as_flown(flights, self.area.shape, visible, self.sight.across)


class _TooNear(Exception):
    def __init__(self, kept: KeptLimit, guarantee: ClearanceGuarantee) -> None:
        super().__init__(kept.to)
        self.kept = kept
        self.guarantee = guarantee


def plan_flights(scenario: Scenario, seed: int = 0, progress: Progress = silent) -> SurveyPlan:
    """Plan the fastest survey that keeps its clearance: more distance to obstacles first, then less speed."""
    for n, share in enumerate(SPEEDS):
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": share * scenario.vehicle.cruise_speed})
        world = scenario if share == 1.0 else scenario.model_copy(update={"vehicle": vehicle})
        progress(n / len(SPEEDS), f"lines at {world.vehicle.cruise_speed:g} m/s")
        try:
            return _with_room(world, seed)
        except _TooNear as error:
            nearest = error
    raise _refusal(nearest, scenario)


def _with_room(scenario: Scenario, seed: int) -> SurveyPlan:
    growth = dict[str, float]()
    for _ in range(ROUNDS):
        task = task_of(scenario, growth)
        make = FlightMaker(task, seed)
        tour = lay_lines(task)
        parts = split_into_flights(tour, make, task.section.flights)
        forecasts = [make(part) for part in parts]
        near = _too_near(forecasts)
        if not near:
            break
        needed = dict[str, float]()
        for kept, guarantee in near:
            if kept.limit not in ("obstacles", "bounds"):
                raise _TooNear(kept, guarantee)
            is_bound = kept.limit == "bounds"
            missing = {"bounds": -kept.slack} if is_bound else _missing_clearance(kept, guarantee, task.obstacles)
            for name, by in missing.items():  # [m]
                needed[name] = max(needed.get(name, 0.0), growth.get(name, 0.0) + by * 1.15 + 0.05)
        growth = growth | needed
    else:
        raise _TooNear(*min(near, key=lambda pair: pair[0].slack))
    return SurveyPlan(scenario, growth, tour, task.coverage_of(tour), _check_flights(parts, forecasts))


def _too_near(forecasts: Sequence[Forecast]) -> list[tuple[KeptLimit, ClearanceGuarantee]]:
    """Return the limits that flights do not keep; drops large data."""
    near = list[tuple[KeptLimit, ClearanceGuarantee]]()
    for forecast in forecasts:
        near += [(kept, forecast.guarantee) for kept in forecast.guarantee.forbidding]
        forecast.drop(ContingencyPaths)
    return near


def _missing_clearance(kept: KeptLimit, guarantee: ClearanceGuarantee, bodies: Sequence[Obstacle]) -> dict[str, float]:
    """Return the clearance [m] missing to the worst obstacle, and to others about as near."""
    flight = guarantee.flight
    lost = kept.nominal - kept.guaranteed
    min_slack = 0.25  # [m]
    points = flight.prediction.track.between(*flight.cruise_span).points[:, :2]
    path = shapely.LineString(points).simplify(THINNING_TOLERANCE)
    slack = shapely.distance(path, [body.horizontal_shape for body in bodies]) - lost - kept.required
    missing = {body.name: min_slack - float(each) for body, each in zip(bodies, slack, strict=True) if each < min_slack}
    return missing | {kept.to: -kept.slack}


def rest_of(plan: SurveyPlan, flown: Sequence[Points], seed: int = 0) -> SurveyPlan:
    """Return the plan of what paths left."""
    scenario = plan.scenario
    tour = rest_of_tour(plan.tour, flown, plan.sight, scenario.airspace.ground, plan.cover.transit)
    if tour is None:
        raise BadInput("no line is left to fly", code="nothing-left", place="survey")
    make = FlightMaker(plan, seed)
    parts = split_into_flights(tour, make)
    forecasts = [make(part) for part in parts]
    near = _too_near(forecasts)
    if near:
        raise _refusal(_TooNear(*near[0]), scenario)
    return replace(plan, tour=tour, flights=_check_flights(parts, forecasts), is_rest=True)


def _check_flights(parts: Sequence[Tour], forecasts: Sequence[Forecast]) -> tuple[SurveyFlight, ...]:
    flights = list[SurveyFlight]()
    for part, forecast in zip(parts, map(with_planned_returns, forecasts), strict=True):
        findings = refuse_errors(check(forecast))
        forecast.drop(ContingencyPaths)  # large after many hours
        budget = budget_of(forecast)
        if budget is not None and budget.shortage is not None:
            raise budget.shortage
        flights.append(SurveyFlight(part, forecast, findings))
    return tuple(flights)


def _refusal(nearest: _TooNear, scenario: Scenario) -> MissionError:
    kept = nearest.kept
    slowest = SPEEDS[-1] * scenario.vehicle.cruise_speed
    return NoPath(
        f"even at {slowest:g} m/s flights would come too near {kept.to} {place_words(kept.place)}: "
        f"{kept.words(nearest.guarantee.confidence)}",
        hint="fly higher (survey.height_above_ground), or leave that place out of the area",
        code="survey-too-near",
        place="survey",
        known={"limit": kept.limit, "near": kept.to},
    )


@dataclass(frozen=True)
class FlightMaker:
    task: SurveyTask
    seed: int
    _longest: dict[bytes, tuple[Tour, Forecast]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, tour: Tour) -> Forecast:
        longest = self._longest.get(tour.places[:2].tobytes())
        if longest is not None and np.array_equal(longest[0].places, tour.places):
            return longest[1]
        return Forecast(assemble_survey(tour, self.task, self.seed), self.task.scenario)

    def fits(self, tour: Tour) -> bool:
        """Return whether one flight from home flies a tour; keeps the longest that does."""
        if len(tour.swaths) > self.max_lines:
            return False
        forecast = self(tour)
        has_battery = self.task.scenario.vehicle.battery is not None
        if is_too_long(forecast.mission) or (has_battery and refusal_of(forecast) is not None):
            return False
        self._longest[tour.places[:2].tobytes()] = tour, forecast
        return True

    @property
    def max_lines(self) -> int:
        vehicle = self.task.scenario.vehicle
        items_per_line = 2 if self.task.sight.trigger is None else 4
        return vehicle.autopilot.firmware(vehicle.version).max_items // items_per_line


def split_into_flights(tour: Tour, make: FlightMaker, flights: int | None = None) -> tuple[Tour, ...]:
    if flights is not None:
        return _asked_parts(tour, flights)
    guess = make.max_lines if make.task.scenario.vehicle.battery is None else 8
    return tuple(fewest_parts(tour, make.fits, make.task.sight.piece_overlap, guess))


def _asked_parts(tour: Tour, count: int) -> tuple[Tour, ...]:
    most = len(tour.swaths)
    if count > most:
        raise BadInput(
            f"expected at most {most} flights, one for each line",
            code="too-many-flights",
            place="survey.flights",
            remedies=(Remedy(("survey", "flights"), most), Remedy(("survey", "flights"))),
        )
    return parts_of_equal_length(tour, count)


def with_planned_returns(forecast: Forecast) -> Forecast:
    if forecast.world.safety.returns != "planned":
        return forecast
    best, short = choose_returns(forecast)
    if short:
        raise NoPath(f"the lines are clear, but {why_not_planned(best)}", hint=other_options_hint(best))
    return best


def coverage_lines(plan: SurveyPlan) -> Iterator[str]:
    seen = plan.coverage
    inside = "nothing outside" if seen.outside_m < 0.005 else f"up to {seen.outside_m:.1f} m outside"
    hectares = f"{plan.area.shape.area / 1e4:.2f} ha"
    yield f"covers {floor_cm(100 * seen.share):.2f} % of the visible part of {hectares}; {inside}"
    if plan.flown is not None:
        share = f"{floor_cm(100 * plan.flown.share):.2f} %"
        yield f"as flown, with corners cut and passed: {share}, {plan.flown.outside_m:.1f} m outside"
    if str(plan.overlaps or ""):
        yield f"photos overlap by {plan.overlaps} at least"


def flight_table(plan: SurveyPlan, names: Sequence[str]) -> tuple[list[str], list[tuple[str, ...]]]:
    rows = list[tuple[str, ...]]()
    columns = ["file", "lines", "photos", "items", "takes\ns", "energy\nWh", "least clearance\nm"]
    for name, flight in zip(names, plan.flights, strict=True):
        energy = flight.forecast.energy
        kept = flight.forecast.guarantee.clearance
        counts = len(flight.tour.swaths), plan.sight.photos_of(flight.tour), len(flight.forecast.mission.items)
        takes = f"{flight.forecast.estimate.total_s:.1f}"
        wh = "" if energy is None else f"{energy.energy_wh:.1f}"
        least = "" if kept is None else f"{floor_cm(kept.guaranteed):.2f} to {kept.to}"
        rows.append((f"{name}.plan", *map(str, counts), takes, wh, least))
    return columns, rows
