import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import shapely

from ipoa_mission.checks.check import check
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.energy_budget import shortage_of
from ipoa_mission.forecast.deviation.promise import Kept, Promise
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import THINNING_TOLERANCE
from ipoa_mission.geometry import Points
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.progress import Progress, silent
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.survey_area import Area
from ipoa_mission.scenario.survey_section import SurveySection
from ipoa_mission.survey.flight_maker import FlightMaker, laid_tours, parts_of, returning
from ipoa_mission.survey.flown_coverage import AsFlown, Coverage, as_flown, coverage, expected_lines
from ipoa_mission.survey.keep_out import flown_round, keep_out
from ipoa_mission.survey.laying import expect_high_enough, expect_survey, way_over
from ipoa_mission.survey.overlap import Overlaps, flown_lines, smallest_overlaps
from ipoa_mission.survey.resume import left_to_fly
from ipoa_mission.survey.sight import Sight, sight_of
from ipoa_mission.survey.tour import Sortie, Tour
from ipoa_mission.world.obstacles import Obstacle

log = logging.getLogger(__name__)

ROUNDS = 8  # with more clearance, at each speed
MIN_SLACK = 0.25  # less gets more clearance, too [m]
SPEEDS = (1.0, 0.7, 0.5)  # times the cruise speed
GROWTH_FACTOR, GROWTH_MARGIN = 1.15, 0.05  # of the missing clearance; [m]


@dataclass(frozen=True, eq=False)
class SurveyFlight:
    """Tour in meters from the scenario's home, forecast from the flight's: place number `start`, if any."""

    tour: Tour
    forecast: Forecast
    findings: tuple[Finding, ...]
    start: int | None = None


@dataclass(frozen=True, eq=False)
class SurveyPlan:
    """A checked survey.

    `scenario` has the flown cruise speed, possibly lower than the file's. `growth` [m]: added clearance by obstacle
    name. `is_rest`: `coverage` is that of all lines.
    """

    scenario: Scenario
    area: Area
    sight: Sight
    keep_out: Any | None
    tour: Tour
    coverage: Coverage
    flights: tuple[SurveyFlight, ...]
    growth: Mapping[str, float]
    is_rest: bool = False

    @property
    def photos(self) -> int:
        return sum(self.sight.photos_of(flight.tour) for flight in self.flights)

    @cached_property
    def overlaps(self) -> Overlaps | None:
        if self.sight.trigger is None:
            return None
        frame = self.scenario.frame
        lines = [line for flight in self.flights for line in flown_lines(flight.forecast, self.sight.lag, frame)]
        return smallest_overlaps(lines, self.sight, self.scenario.airspace.ground, self.free)

    @cached_property
    def flown(self) -> AsFlown | None:
        """Return the coverage as forecast, or None for the rest of a survey."""
        if self.is_rest:
            return None
        visible = self.area.visible(self.keep_out, self.sight.spacing)
        flights = (expected_lines(flight.forecast, flight.tour, self.scenario.frame) for flight in self.flights)
        return as_flown(flights, self.area.shape, visible, self.sight.across)

    @property
    def section(self) -> SurveySection:
        section = self.scenario.survey
        assert section is not None
        return section

    def begin_of(self, flight: SurveyFlight) -> tuple[float, float]:
        return (0.0, 0.0) if self.section.starts is None or flight.start is None else self.section.starts[flight.start]

    @property
    def free(self) -> Any:
        """Return the part that may be flown over (shapely)."""
        return self.area.without(self.keep_out)


class _TooNear(Exception):
    def __init__(self, kept: Kept, promise: Promise) -> None:
        super().__init__(kept.to)
        self.kept, self.promise = kept, promise


def plan_flights(scenario: Scenario, seed: int = 0, progress: Progress = silent) -> SurveyPlan:
    """Plan the fastest survey that keeps its clearance. Raises BadInput, NoPath, NoRoute, NotEnoughBattery, Unsafe.

    If too few flights keep it, obstacles get more clearance, then the speed is reduced.
    """
    section, area = expect_survey(scenario)
    for n, share in enumerate(SPEEDS):
        vehicle = scenario.vehicle.model_copy(update={"cruise_speed": share * scenario.vehicle.cruise_speed})
        world = scenario if share == 1.0 else scenario.model_copy(update={"vehicle": vehicle})
        progress(n / len(SPEEDS), f"lines at {world.vehicle.cruise_speed:g} m/s")
        try:
            return _with_room(world, section, area, seed)
        except _TooNear as error:
            nearest = error
    raise _refusal(nearest, scenario)


def _with_room(scenario: Scenario, section: SurveySection, area: Area, seed: int) -> SurveyPlan:
    sight, growth = sight_of(section, area, scenario), dict[str, float]()
    expect_high_enough(sight, scenario)
    for _ in range(ROUNDS):
        outside = keep_out(scenario, sight, growth)
        make = FlightMaker(scenario, sight, growth, seed)
        tour, parts = parts_of(laid_tours(make, section, area, outside), make, section)
        forecasts = [make(part) for part in parts]
        near, wanted = _too_near(forecasts), dict[str, float]()
        if not near:
            break
        for kept, promise in near:
            if kept.limit not in ("obstacles", "bounds"):
                raise _TooNear(kept, promise)
            bodies = flown_round(scenario, sight, growth)
            missing = {"bounds": -kept.slack} if kept.limit == "bounds" else _missing(kept, promise, bodies)
            for name, by in missing.items():
                wanted[name] = max(wanted.get(name, 0.0), growth.get(name, 0.0) + by * GROWTH_FACTOR + GROWTH_MARGIN)
        growth |= wanted
    else:
        raise _TooNear(*min(near, key=lambda pair: pair[0].slack))
    seen = coverage(area, tour, sight.spacing, outside)
    return SurveyPlan(scenario, area, sight, outside, tour, seen, _checked(parts, forecasts), growth)


def _too_near(forecasts: Sequence[Forecast]) -> list[tuple[Kept, Promise]]:
    """Return the limits that flights do not keep; drops large data."""
    near = list[tuple[Kept, Promise]]()
    for forecast in forecasts:
        near += [(kept, forecast.promise) for kept in forecast.promise.forbidding]
        forecast.drop(ContingencyPaths)
    return near


def _missing(kept: Kept, promise: Promise, bodies: Sequence[Obstacle]) -> dict[str, float]:
    """Return the clearance [m] missing to the worst obstacle, and to others about as near, which have no bound."""
    flight, lost = promise.flight, kept.nominal - kept.kept
    way = shapely.LineString(flight.prediction.track.between(*flight.way).points[:, :2]).simplify(THINNING_TOLERANCE)
    slack = shapely.distance(way, [body.plan for body in bodies]) - lost - kept.required
    missing = {body.name: MIN_SLACK - float(each) for body, each in zip(bodies, slack, strict=True) if each < MIN_SLACK}
    return missing | {kept.to: -kept.slack}


def rest_of(plan: SurveyPlan, flown: Sequence[Points], seed: int = 0) -> SurveyPlan:
    """Return the plan of what paths (n, 3) left, east, north, up [m]. Raises as `plan_flights`."""
    scenario, sight, section = plan.scenario, plan.sight, plan.section
    way = way_over(plan.area, scenario, section, sight, plan.keep_out)
    tour = left_to_fly(plan.tour, flown, sight, scenario.airspace.ground, way)
    if tour is None:
        raise BadInput("no line is left to fly", code="nothing-left", place="survey")
    make = FlightMaker(scenario, sight, plan.growth, seed)
    tour, parts = parts_of([tour], make, section.model_copy(update={"flights": None}))
    forecasts = [make(part) for part in parts]
    near = _too_near(forecasts)
    if near:
        raise _refusal(_TooNear(*near[0]), scenario)
    return replace(plan, tour=tour, flights=_checked(parts, forecasts), is_rest=True)


def _checked(parts: Sequence[Sortie], forecasts: Sequence[Forecast]) -> tuple[SurveyFlight, ...]:
    flights = list[SurveyFlight]()
    for part, forecast in zip(parts, map(returning, forecasts), strict=True):
        findings = refuse_errors(check(forecast))
        forecast.drop(ContingencyPaths)  # large after many hours
        if (short := shortage_of(forecast)) is not None:
            raise short
        flights.append(SurveyFlight(part.tour, forecast, findings, part.start))
    return tuple(flights)


def _refusal(nearest: _TooNear, scenario: Scenario) -> MissionError:
    kept = nearest.kept
    east, north, up = kept.place
    slowest = SPEEDS[-1] * scenario.vehicle.cruise_speed
    return NoPath(
        f"even at {slowest:g} m/s flights would come too near {kept.to} at east {east:.1f}, north {north:.1f}, "
        f"up {up:.1f} m: {kept.words(nearest.promise.confidence)}",
        hint="fly higher (survey.height_above_ground), or leave that place out of the area",
        code="survey-too-near",
        place="survey",
        known={"limit": kept.limit, "near": kept.to},
    )
