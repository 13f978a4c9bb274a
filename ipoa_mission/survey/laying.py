import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from threadpoolctl import threadpool_limits

from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.survey_area import Area
from ipoa_mission.scenario.survey_section import SurveySection
from ipoa_mission.survey.cover import quickest_tour, way_between
from ipoa_mission.survey.flown_coverage import Coverage, coverage
from ipoa_mission.survey.keep_out import SPARE, keep_out, survey_bound
from ipoa_mission.survey.sight import Sight, sight_of
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Swath, Tour

MAX_LINES = 3000  # memory for the ways between all of them
MAX_HOURS = 100  # of flight: planning takes 1 to 2 GB


@dataclass(frozen=True, eq=False)
class SurveySketch:
    """Unchecked lines; `seconds` without take-off and landing."""

    area: Area
    sight: Sight
    keep_out: Any | None
    tour: Tour
    coverage: Coverage
    seconds: float


def sketch_survey(scenario: Scenario) -> SurveySketch:
    """Return the lines, for interactive editing. Raises BadInput, NoPath, MissionError."""
    section, area = expect_survey(scenario)
    sight = sight_of(section, area, scenario)
    expect_high_enough(sight, scenario)
    outside = keep_out(scenario, sight, {})
    with threadpool_limits(1, "blas"):
        tour = lay_lines(scenario, section, area, sight, outside)
        seconds = leg_times(scenario, sight).seconds(tour.path)
    return SurveySketch(area, sight, outside, tour, coverage(area, tour, sight.spacing, outside), seconds)


def expect_survey(scenario: Scenario) -> tuple[SurveySection, Area]:
    section, area = scenario.survey, scenario.survey_area
    if section is None or area is None:
        raise BadInput("expected in the scenario, but missing", code="missing", place="survey")
    return section, area


def expect_high_enough(sight: Sight, scenario: Scenario) -> None:
    """Refuse a height too near to the ground. Raises NoPath."""
    needed = scenario.limits.height_above_ground + survey_bound(scenario).down + 2 * SPARE
    if sight.least < needed:
        raise NoPath(
            f"{sight.least:g} m above the ground is too low, at least {needed:.2f} m required",
            hint="fly higher (survey.height_above_ground, or a larger survey.gsd_cm)",
            code="survey-too-low",
            place="survey",
            remedies=(Remedy(("survey", "height_above_ground"), float(math.ceil(needed + SPARE))),),
        )


def lay_lines(
    scenario: Scenario,
    section: SurveySection,
    area: Area,
    sight: Sight,
    outside: Any | None,
    at: Vector | None = None,
) -> Tour:
    """Return the quickest lines over what obstacles leave. Raises BadInput, NoPath.

    They begin and end near `at` (2,), else near home; with start places anywhere.
    """
    free = area.without(outside)
    if free.is_empty:
        words = f"obstacles and the clearance to them leave nothing of the area at {sight.least:g} m above ground"
        hint = "fly higher (survey.height_above_ground), or with a smaller safety_distance"
        raise NoPath(words, hint=hint, code="area-covered", place="survey")
    _expect_lines(area, sight.spacing)
    _expect_hours(float(free.area), sight.spacing, scenario.vehicle.cruise_speed)
    begin = np.array(section.entry or scenario.start_point[:2]) if at is None else at
    end = np.array(section.exit or scenario.goal_point[:2]) if at is None else at
    cost = leg_times(scenario, sight)
    is_anywhere = section.starts is not None and at is None
    middles = section.middles(scenario.frame)
    if len(middles) == 1 and section.width is not None and section.direction_deg == "best":
        inside = where_allowed(area, outside)
        along = corridor_tour(middles[0], section.width, sight.spacing, begin, inside, cost.past_corners)
        if along is not None:
            return along
    return quickest_tour(
        area,
        sight.spacing,
        cost=cost,
        keep_out=outside,
        direction=section.direction_deg,
        turns_outside=section.turns_outside,
        begin=None if is_anywhere else begin,
        end=None if is_anywhere else end,
    )


def _expect_lines(area: Area, spacing: float) -> None:
    (west, south, east, north) = area.shape.bounds
    least = area.shape.area / spacing / math.hypot(east - west, north - south)
    if least > MAX_LINES:
        words = f"expected at most {MAX_LINES} lines, not {least:.0f} or more, {spacing:g} m apart"
        hint = "set lines farther apart (survey.line_spacing, or a greater height), or split the survey"
        raise BadInput(words, hint=hint, code="survey-too-long", place="survey")


def _expect_hours(seen_m2: float, spacing: float, speed: float) -> None:
    length = seen_m2 / spacing
    if (hours := length / speed / 3600.0) > MAX_HOURS:
        raise BadInput(
            f"expected at most {MAX_HOURS} h of flight, not {hours:.0f} h or more: "
            f"{length / 1000.0:.0f} km of lines at {speed:g} m/s",
            hint="split the survey, or set lines farther apart (survey.line_spacing, or a greater height)",
            code="survey-too-long",
            place="survey",
        )


def way_over(
    area: Area, scenario: Scenario, section: SurveySection, sight: Sight, outside: Any | None
) -> Callable[[Vector, Vector], Points]:
    """Return a function that gives the corners (k, 2) between two places (2,)."""
    return way_between(
        area,
        sight.spacing,
        cost=leg_times(scenario, sight),
        keep_out=outside,
        turns_outside=section.turns_outside,
    )


def leg_times(scenario: Scenario, sight: Sight) -> LegTimes:
    vehicle = scenario.vehicle
    given = Mission(
        scenario.frame.home,
        (),
        vehicle.autopilot,
        parameters=vehicle.autopilot_parameters(),
        vehicle=vehicle.learned,
        firmware_version=vehicle.version,
    )
    return LegTimes.of(given, vehicle.cruise_speed, sight.middle, scenario.wind.air())


MAX_TRIM = 1 / 8
INSIDE = 1e-6  # [m]


def corridor_tour(middle: Points, width: float, spacing: float, begin: Vector, inside: Any, past: float) -> Tour | None:
    """Return lines at most `spacing` apart [m], from the corridor's end nearer to `begin` (2,).

    Lines end earlier by the overshoot `past` corners [m]. Return None if a line bends back on itself or leaves
    `inside`.
    """
    count = max(math.ceil(width / spacing - 1e-9), 1)
    if np.linalg.norm(middle[-1] - begin) < np.linalg.norm(middle[0] - begin):
        middle = middle[::-1]
    middle = _trimmed(middle, min(past, MAX_TRIM * spacing))
    lines = list[Points]()
    for n in range(count):
        line = shapely.LineString(middle).offset_curve(width * ((n + 0.5) / count - 0.5), join_style="mitre")
        corners = shapely.get_coordinates(line)
        if line.geom_type != "LineString" or len(corners) != len(middle) or not inside.covers(line):
            return None
        lines.append(corners if n % 2 == 0 else corners[::-1])
    swaths = tuple(Swath(a, b) for line in lines for a, b in pairwise(line))
    return Tour(swaths, tuple(np.array([one.end, other.begin]) for one, other in pairwise(swaths)))


def _trimmed(middle: Points, by: float) -> Points:
    legs = middle[[1, -2]] - middle[[0, -1]]
    lengths = np.linalg.norm(legs, axis=1, keepdims=True)
    if (lengths <= 2 * by).any():
        return middle
    ends = middle[[0, -1]] + by / lengths * legs
    return np.concatenate([ends[:1], middle[1:-1], ends[1:]])


def where_allowed(area: Area, keep_out: Any | None) -> Any:
    return area.without(keep_out).buffer(INSIDE)
