import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, combinations
from typing import Any

import numpy as np

from ipoa_mission import NotEnoughBattery
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.forecast.contingency.energy_budget import budget_of, refusal_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.planning.proof import prove
from ipoa_mission.routing.planned_returns import or_else, settled, why_not_planned
from ipoa_mission.routing.route import NoRoute
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.other_home import at_start, between
from ipoa_mission.scenario.survey_area import Area
from ipoa_mission.scenario.survey_section import SurveySection
from ipoa_mission.survey.assembly import assemble_survey
from ipoa_mission.survey.laying import lay_lines, leg_times, way_over
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.starting import RouteCost, by_start, nearest_areas, nearest_parts, quickest_parts
from ipoa_mission.survey.tour import Sortie, Swath, Tour
from ipoa_mission.survey.tour_split import fewest_parts, part_of, parts_of_equal_length

MAX_EVERY_SUBSET = 3
MIN_ONLY_FULL_SET = 10
TRIAL_FACTOR = 1.5  # of the estimated number of lines
IMPOSSIBLE_COST = RouteCost(np.inf, np.inf)
JUST_OVER_ONE = float(np.nextafter(1.0, 2.0))


@dataclass(frozen=True)
class FlightMaker:
    """Forecasts flights; `growth` [m] by obstacle name adds clearance."""

    scenario: Scenario
    sight: Sight
    growth: Mapping[str, float]
    seed: int
    _longest: dict[Swath, tuple[Tour, Forecast]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, part: Sortie) -> Forecast:
        """Return a flight's forecast. Raises BadInput, NoPath, NoRoute, MissionError, Unsafe."""
        world, tour = self.scenario, part.tour
        longest = self._longest.get(tour.swaths[0])
        if longest is not None and part.start is None and longest[0].swaths == tour.swaths:
            return longest[1]
        if part.start is not None:
            world = _expect_clear(at_start(self.scenario, part.start), part.start)
            tour = tour.moved(between(self.scenario.frame, world.frame))
        return Forecast(assemble_survey(tour, self.sight, world, self.growth, self.seed), world)

    def fits(self, tour: Tour) -> bool:
        """Return whether one flight from home flies a tour; cached."""
        forecast = self._taken(Sortie(tour))
        if forecast is None or (self.scenario.vehicle.battery is not None and refusal_of(forecast) is not None):
            return False
        self._longest[tour.swaths[0]] = tour, forecast
        return True

    def tried(self, part: Sortie) -> RouteCost:
        """Return a flight's cost: infinite with too many items, over 1 without the battery reserve."""
        forecast = self._taken(part)
        if forecast is None:
            return IMPOSSIBLE_COST
        budget, seconds = budget_of(forecast), forecast.estimate.total_s
        if refusal_of(forecast) is not None:
            return RouteCost(JUST_OVER_ONE if budget is None else max(budget.share, JUST_OVER_ONE), seconds)
        return RouteCost(0.0 if budget is None else min(budget.share, 1.0), seconds)

    @property
    def max_lines(self) -> int:
        vehicle = self.scenario.vehicle
        per = 2 if self.sight.trigger is None else 4
        return vehicle.autopilot.firmware(vehicle.version).max_items // per

    def _taken(self, part: Sortie) -> Forecast | None:
        if len(part.tour.swaths) > self.max_lines:
            return None
        forecast = self(part)
        return None if is_too_long(forecast.mission) else forecast

    @cached_property
    def cut_overlap(self) -> float:
        """Return the overlap of the parts of a cut line [m]."""
        return max(self.sight.trigger or 0.0, self.sight.along / 2, 1.0)


def _expect_clear(world: Scenario, n: int) -> Scenario:
    """Refuse a start place with a blocked climb. Raises BadInput."""
    up = world.start_point[2]
    for found in prove(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, up]]), world).checks:
        if found.limit in ("obstacles", "bounds") and found.slack < 0.0:
            words = f"expected a place with a clear climb to {up:.0f} m: {found.words()}"
            raise BadInput(words, code="place-blocked", place=f"survey.starts[{n}]")
    return world


def laid_tours(make: FlightMaker, section: SurveySection, area: Area, outside: Any | None) -> list[Tour]:
    """Return tours to compare. Raises NoPath, MissionError."""
    scenario, sight = make.scenario, make.sight
    if section.starts is None:
        return [lay_lines(scenario, section, area, sight, outside)]
    starts = np.array(section.starts)
    if scenario.vehicle.battery is None:
        return [_joined(make, section, area, outside, starts)]
    tours = [lay_lines(scenario, section, area, sight, outside)]
    if section.direction_deg == "best":
        east, north = max((swath.end - swath.begin for swath in tours[0].swaths), key=np.linalg.norm).tolist()
        across = section.model_copy(update={"direction_deg": math.degrees(math.atan2(east, north)) + 90.0})
        tours.append(lay_lines(scenario, across, area, sight, outside))
    return tours + [_joined(make, section, area, outside, starts[[*some]]) for some in _sets(len(starts))]


def _sets(count: int) -> Iterator[tuple[int, ...]]:
    """Return sets of start places to try."""
    large = (count, count - 1, 1) if count < MIN_ONLY_FULL_SET else (count,)
    sizes = range(count, 0, -1) if count <= MAX_EVERY_SUBSET else large
    return chain.from_iterable(combinations(range(count), size) for size in sizes)


def _joined(make: FlightMaker, section: SurveySection, area: Area, outside: Any | None, starts: Points) -> Tour:
    scenario, sight = make.scenario, make.sight
    swaths, ways, way = list[Swath](), list[Points](), way_over(area, scenario, section, sight, outside)
    for start, own in zip(starts, nearest_areas(area, starts, sight.spacing), strict=True):
        if own is None or own.without(outside).is_empty:
            continue
        tour = lay_lines(scenario, section, own, sight, outside, at=start)
        ways += [way(swaths[-1].end, tour.swaths[0].begin)] if swaths else []
        swaths, ways = [*swaths, *tour.swaths], [*ways, *tour.ways]
    if not swaths:
        lay_lines(scenario, section, area, sight, outside)  # raises the reason
    return Tour(tuple(swaths), tuple(ways))


def parts_of(tours: Sequence[Tour], make: FlightMaker, section: SurveySection) -> tuple[Tour, tuple[Sortie, ...]]:
    """Return the best tour, and its flights. Raises BadInput, NotEnoughBattery, NoPath, NoRoute."""
    if section.starts is not None:
        return _from_starts(tours, make, np.array(section.starts))
    (tour,) = tours
    if section.flights is not None:
        if section.flights > len(tour.swaths):
            raise BadInput(
                f"expected at most {len(tour.swaths)} flights, one for each line",
                code="too-many-flights",
                place="survey.flights",
                remedies=(Remedy(("survey", "flights"), len(tour.swaths)), Remedy(("survey", "flights"))),
            )
        return tour, tuple(map(Sortie, parts_of_equal_length(tour, section.flights)))

    about = _lines_at_once(tour, make)
    if len(tour.swaths) <= TRIAL_FACTOR * about and make.fits(tour):
        return tour, (Sortie(tour),)
    parts = fewest_parts(tour, make.fits, make.cut_overlap, max(int(about), 1))
    if isinstance(parts, Swath):
        raise _unreached(parts, "and home")
    return tour, tuple(map(Sortie, parts))


def _lines_at_once(tour: Tour, make: FlightMaker) -> float:
    if make.scenario.vehicle.battery is None or len(tour.swaths) == 1:
        return make.max_lines
    try:
        alone = make.tried(Sortie(part_of(tour, 0, 1)))
    except (NoPath, NoRoute):  # another line may have a way home
        return make.max_lines
    if not 0.0 < alone.share <= 1.0:
        return 1.0 if alone.share else make.max_lines
    on_a_line = leg_times(make.scenario, make.sight).seconds(tour.path) / len(tour.swaths)
    return min(1.0 + (1.0 / alone.share - 1.0) * alone.seconds / on_a_line, make.max_lines)


def _from_starts(tours: Sequence[Tour], make: FlightMaker, starts: Points) -> tuple[Tour, tuple[Sortie, ...]]:
    """Return the best tour and its flights; without a battery each place gets the nearest lines."""

    def tried(part: Sortie) -> RouteCost:
        try:
            return make.tried(part)
        except (NoPath, NoRoute):
            return IMPOSSIBLE_COST

    for n in range(len(starts)):
        _expect_clear(at_start(make.scenario, n), n)
    times = leg_times(make.scenario, make.sight)
    best: tuple[float, Tour, tuple[Sortie, ...]] | None = None
    unreached: Swath | None = None
    for tour in tours:
        if make.scenario.vehicle.battery is None:
            near = nearest_parts(tour, starts, make.tried, make.cut_overlap)
            found: tuple[tuple[Sortie, ...], float] | Swath | None = near if isinstance(near, Swath) else (near, 0.0)
        else:
            most = np.inf if best is None else best[0]
            found = quickest_parts(tour, starts, times, tried, make.cut_overlap, most)
        if found is None:
            continue
        if isinstance(found, Swath):
            unreached = unreached or found
        elif best is None or found[1] < best[0]:
            best = found[1], tour, by_start(found[0])
    if best is None:
        assert unreached is not None
        for n in range(len(starts)):
            make(Sortie(Tour((unreached,), ()), n))  # raises if no way leads there
        raise _unreached(unreached, "from a start place, and back there")
    return best[1:]


def _unreached(swath: Swath, words: str) -> NotEnoughBattery:
    east, north = swath.begin.tolist()
    return NotEnoughBattery(
        f"expected enough charge to reach the line at east {east:.0f}, north {north:.0f} m, {words} with the "
        "reserve, but it is too little",
        hint="begin nearer, or with a larger battery",
        place="battery",
    )


def returning(forecast: Forecast) -> Forecast:
    """Return the forecast with the items of planned returns. Raises NoPath."""
    if forecast.world.safety.returns != "planned":
        return forecast
    best, short = settled(forecast)
    if short:
        raise NoPath(f"the lines are clear, but {why_not_planned(best)}", hint=or_else(best))
    return best
