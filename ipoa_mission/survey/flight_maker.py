"""Split a survey's tours into forecast flights."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ipoa_mission import Forecast, NoPath, NoRoute, NotEnoughBattery
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.forecast.contingency.energy_budget import budget_of, refusal_of
from ipoa_mission.routing.planned_returns import choose_returns, other_options_hint, why_not_planned
from ipoa_mission.survey.assembly import assemble_survey
from ipoa_mission.survey.survey_task import SurveyTask
from ipoa_mission.survey.tour import Swath, Tour, Unreached, fewest_parts, parts_of_equal_length


@dataclass(frozen=True)
class FlightMaker:
    """Forecasts flights; `growth` [m] by obstacle name adds clearance."""

    task: SurveyTask
    growth: Mapping[str, float]
    seed: int
    _longest: dict[Swath, tuple[Tour, Forecast]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, tour: Tour) -> Forecast:
        longest = self._longest.get(tour.swaths[0])
        if longest is not None and longest[0].swaths == tour.swaths:
            return longest[1]
        return Forecast(assemble_survey(tour, self.task, self.growth, self.seed), self.task.scenario)

    def fits(self, tour: Tour) -> bool:
        """Return whether one flight from home flies a tour; keeps the longest that does."""
        forecast = self.short_enough(tour)
        if forecast is None or (self.task.scenario.vehicle.battery is not None and refusal_of(forecast) is not None):
            return False
        self._longest[tour.swaths[0]] = tour, forecast
        return True

    @property
    def max_lines(self) -> int:
        vehicle = self.task.scenario.vehicle
        items_per_line = 2 if self.task.sight.trigger is None else 4
        return vehicle.autopilot.firmware(vehicle.version).max_items // items_per_line

    def short_enough(self, tour: Tour) -> Forecast | None:
        """Return the forecast, or None if the vehicle cannot hold that many items."""
        if len(tour.swaths) > self.max_lines:
            return None
        forecast = self(tour)
        return None if is_too_long(forecast.mission) else forecast


def split_into_flights(tour: Tour, make: FlightMaker) -> tuple[Tour, ...]:
    section = make.task.section
    if section.flights is not None:
        return _asked_parts(tour, section.flights)
    try:
        estimate = _lines_of_one_flight(tour, make)
        if len(tour.swaths) <= 1.5 * estimate and make.fits(tour):
            return (tour,)
        return tuple(fewest_parts(tour, make.fits, make.task.sight.piece_overlap, max(int(estimate), 1)))
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
        first = make.short_enough(tour.part(0, 1))
    except (NoPath, NoRoute):  # another line may have a way home
        return make.max_lines
    if first is None or refusal_of(first) is not None:
        return 1.0
    budget = budget_of(first)
    if budget is None or budget.share <= 0.0:
        return make.max_lines
    seconds_per_line = make.task.times.seconds(tour.path) / len(tour.swaths)
    left_s = (1.0 / min(budget.share, 1.0) - 1.0) * first.estimate.total_s
    return min(1.0 + left_s / seconds_per_line, make.max_lines)


def with_planned_returns(forecast: Forecast) -> Forecast:
    if forecast.world.safety.returns != "planned":
        return forecast
    best, short = choose_returns(forecast)
    if short:
        raise NoPath(f"the lines are clear, but {why_not_planned(best)}", hint=other_options_hint(best))
    return best
