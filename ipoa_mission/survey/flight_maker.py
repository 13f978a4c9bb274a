"""Split a survey's tours into forecast flights."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, combinations

import numpy as np
import shapely

from ipoa_mission import Forecast, NoPath, NoRoute, NotEnoughBattery, Scenario
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.forecast.contingency.energy_budget import budget_of, refusal_of
from ipoa_mission.geometry import Plane
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.planned_returns import choose_returns, other_options_hint, why_not_planned
from ipoa_mission.survey.assembly import assemble_survey
from ipoa_mission.survey.survey_area import Area
from ipoa_mission.survey.survey_section import at_start, move_between
from ipoa_mission.survey.survey_task import SurveyTask, lay_lines
from ipoa_mission.survey.tour import (
    RouteCost,
    Sortie,
    StartSites,
    Swath,
    Tour,
    Unreached,
    fewest_parts,
    nearest_parts,
    parts_of_equal_length,
    quickest_parts,
)

IMPOSSIBLE_COST = RouteCost(np.inf, np.inf)


@dataclass(frozen=True)
class FlightMaker:
    """Forecasts flights; `growth` [m] by obstacle name adds clearance."""

    task: SurveyTask
    growth: Mapping[str, float]
    seed: int
    _longest: dict[Swath, tuple[Tour, Forecast]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, part: Sortie) -> Forecast:
        world = self.task.scenario
        tour = part.tour
        if part.start is None:
            longest = self._longest.get(tour.swaths[0])
            if longest is not None and longest[0].swaths == tour.swaths:
                return longest[1]
        else:
            world = _expect_clear(at_start(world, part.start), part.start)
            tour = tour.moved(move_between(self.task.scenario.frame, world.frame))
        return Forecast(assemble_survey(tour, self.task.sight, world, self.growth, self.seed), world)

    def fits(self, tour: Tour) -> bool:
        """Return whether one flight from home flies a tour; keeps the longest that does."""
        forecast = self._forecast(Sortie(tour))
        if forecast is None or (self.task.scenario.vehicle.battery is not None and refusal_of(forecast) is not None):
            return False
        self._longest[tour.swaths[0]] = tour, forecast
        return True

    def cost(self, part: Sortie) -> RouteCost:
        """Return a flight's cost: infinite with too many items, over 1 without the battery reserve."""
        forecast = self._forecast(part)
        if forecast is None:
            return IMPOSSIBLE_COST
        budget = budget_of(forecast)
        seconds = forecast.estimate.total_s
        if refusal_of(forecast) is not None:
            just_over_one = float(np.nextafter(1.0, 2.0))
            return RouteCost(max(0.0 if budget is None else budget.share, just_over_one), seconds)
        return RouteCost(0.0 if budget is None else min(budget.share, 1.0), seconds)

    @property
    def max_lines(self) -> int:
        vehicle = self.task.scenario.vehicle
        items_per_line = 2 if self.task.sight.trigger is None else 4
        return vehicle.autopilot.firmware(vehicle.version).max_items // items_per_line

    def _forecast(self, part: Sortie) -> Forecast | None:
        if len(part.tour.swaths) > self.max_lines:
            return None
        forecast = self(part)
        return None if is_too_long(forecast.mission) else forecast


def _expect_clear(world: Scenario, n: int) -> Scenario:
    up = world.start_point[2]
    for check in prove(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, up]]), world).checks:
        if check.limit in ("obstacles", "bounds") and check.slack < 0.0:
            words = f"expected a place with a clear climb to {up:.0f} m: {check.words()}"
            raise BadInput(words, code="place-blocked", place=f"survey.starts[{n}]")
    return world


def lay_tours(task: SurveyTask) -> list[Tour]:
    section = task.section
    if section.starts is None:
        return [lay_lines(task)]
    starts = np.array(section.starts)
    if task.scenario.vehicle.battery is None:
        return [_joined_by_start(task, starts)]
    tours = [lay_lines(task)]
    if section.direction_deg == "best":
        east, north = max((swath.end - swath.begin for swath in tours[0].swaths), key=np.linalg.norm).tolist()
        across = section.model_copy(update={"direction_deg": math.degrees(math.atan2(east, north)) + 90.0})
        tours.append(lay_lines(replace(task, section=across)))
    return tours + [_joined_by_start(task, starts[[*chosen]]) for chosen in _sets_of_starts(len(starts))]


def _sets_of_starts(count: int) -> Iterator[tuple[int, ...]]:
    """Return the sets of start places to try; of many only the whole."""
    if count <= 3:
        sizes: Sequence[int] = range(count, 0, -1)
    else:
        sizes = (count, count - 1, 1) if count < 10 else (count,)
    return chain.from_iterable(combinations(range(count), size) for size in sizes)


def _joined_by_start(task: SurveyTask, starts: Plane) -> Tour:
    swaths = list[Swath]()
    transits = list[Plane]()
    for start, area in zip(starts, nearest_areas(task.area, starts, task.sight.spacing), strict=True):
        if area is None or area.without(task.keep_out).is_empty:
            continue
        tour = lay_lines(replace(task, area=area), start)
        if swaths:
            transits.append(task.cover.transit(swaths[-1].end, tour.swaths[0].begin))
        swaths += tour.swaths
        transits += tour.transits
    if not swaths:
        lay_lines(task)  # raises the reason
    return Tour(tuple(swaths), tuple(transits))


def nearest_areas(area: Area, starts: Plane, spacing: float) -> list[Area | None]:
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(starts), extend_to=area.shape))
    min_area = 1e-3 * spacing**2  # [m^2]
    areas = list[Area | None]()
    for start in shapely.points(starts):
        nearest = area.shape
        if len(starts) > 1:
            nearest = nearest.intersection(next(cell for cell in cells if cell.covers(start)))
        parts = [part for part in shapely.get_parts(nearest) if part.geom_type == "Polygon" and part.area > min_area]
        areas.append(Area(shapely.MultiPolygon(parts)) if parts else None)
    return areas


def split_into_flights(tours: Sequence[Tour], make: FlightMaker) -> tuple[Tour, tuple[Sortie, ...]]:
    section = make.task.section
    tour = tours[0]
    try:
        if section.starts is not None:
            return _from_starts(tours, make, np.array(section.starts))
        if section.flights is not None:
            return tour, tuple(map(Sortie, _asked_parts(tour, section.flights)))
        estimate = _lines_of_one_flight(tour, make)
        if len(tour.swaths) <= 1.5 * estimate and make.fits(tour):
            return tour, (Sortie(tour),)
        parts = fewest_parts(tour, make.fits, make.task.sight.piece_overlap, max(int(estimate), 1))
        return tour, tuple(map(Sortie, parts))
    except Unreached as error:
        east, north = error.swath.begin.tolist()
        raise NotEnoughBattery(
            f"expected enough charge to reach the line at east {east:.0f}, north {north:.0f} m, and back with the "
            "reserve, but it is too little",
            hint="begin nearer, or with a larger battery",
            place="battery",
        ) from error


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


def _lines_of_one_flight(tour: Tour, make: FlightMaker) -> float:
    if make.task.scenario.vehicle.battery is None or len(tour.swaths) == 1:
        return make.max_lines
    try:
        first = make.cost(Sortie(tour.part(0, 1)))
    except (NoPath, NoRoute):  # another line may have a way home
        return make.max_lines
    if not 0.0 < first.share <= 1.0:
        return 1.0 if first.share else make.max_lines
    seconds_per_line = make.task.times.seconds(tour.path) / len(tour.swaths)
    return min(1.0 + (1.0 / first.share - 1.0) * first.seconds / seconds_per_line, make.max_lines)


def _from_starts(tours: Sequence[Tour], make: FlightMaker, starts: Plane) -> tuple[Tour, tuple[Sortie, ...]]:
    """Return the best tour and its flights; without a battery each place gets the nearest lines."""

    def cost(part: Sortie) -> RouteCost:
        try:
            return make.cost(part)
        except (NoPath, NoRoute):
            return IMPOSSIBLE_COST

    for n in range(len(starts)):
        _expect_clear(at_start(make.task.scenario, n), n)
    sites = StartSites(starts, make.task.times, cost, make.task.sight.piece_overlap)
    best: tuple[Tour, tuple[Sortie, ...]] | None = None
    least = np.inf
    unreached = list[Unreached]()
    for tour in tours:
        try:
            if make.task.scenario.vehicle.battery is None:
                return tour, tuple(nearest_parts(tour, replace(sites, forecast_cost=make.cost)))
            split = quickest_parts(tour, sites, least)
        except Unreached as error:
            unreached.append(error)
            continue
        if split is None or split[1] >= least:
            continue
        parts, least = split
        order = list(dict.fromkeys(part.start for part in parts))
        best = tour, tuple(sorted(parts, key=lambda part: order.index(part.start)))
    if best is None:
        for n in range(len(starts)):
            make(Sortie(Tour((unreached[0].swath,), ()), n))  # raises if no way leads there
        raise unreached[0]
    return best


def with_planned_returns(forecast: Forecast) -> Forecast:
    if forecast.world.safety.returns != "planned":
        return forecast
    best, short = choose_returns(forecast)
    if short:
        raise NoPath(f"the lines are clear, but {why_not_planned(best)}", hint=other_options_hint(best))
    return best
