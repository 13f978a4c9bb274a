"""Lay a survey's lines outside of what they keep out of, also unchecked for interactive editing."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from threadpoolctl import threadpool_limits

from ipoa_mission import Mission, NoPath, Scenario
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.forecast.deviation.kept_limits import NO_DEVIATION, DeviationBound, deviation_bound_of
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.geometry import Plane, Vector, union_of
from ipoa_mission.survey.cover import CoverProblem, quickest_tour
from ipoa_mission.survey.flown_coverage import Coverage, coverage
from ipoa_mission.survey.free import widen
from ipoa_mission.survey.sight import Sight, sight_of
from ipoa_mission.survey.survey_area import Area
from ipoa_mission.survey.survey_section import SurveySection, survey_of, surveyed_area
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Swath, Tour
from ipoa_mission.world.obstacles import Obstacle

TIGHT_PLACES = 4.0  # share the chance of a deviation
SPARE = 0.05  # [m]


@dataclass(frozen=True, eq=False)
class SurveyTask:
    """The survey of a scenario; `growth` [m] by obstacle name adds clearance, flown round."""

    scenario: Scenario
    growth: Mapping[str, float]

    @property
    def section(self) -> SurveySection:
        return expect_survey(self.scenario)[0]

    @property
    def area(self) -> Area:
        return expect_survey(self.scenario)[1]

    @cached_property
    def sight(self) -> Sight:
        return sight_of(self.section, self.area, self.scenario)

    @cached_property
    def obstacles(self) -> list[Obstacle]:
        """Return the obstacles flown neither over nor under, or grown."""
        bodies = self.scenario.airspace.obstacles
        return [body for body in bodies if body.name in self.growth or not _is_passed(body, self.sight, self.scenario)]

    @cached_property
    def keep_out(self) -> Any | None:
        """Return the geometry to keep out of, in plan (shapely)."""
        air = self.scenario.airspace
        bound = survey_bound(self.scenario)
        distance = self.scenario.limits.obstacle_distance + SPARE
        max_widening = min(0.05 * self.sight.spacing, 0.25)  # [m], for fewer corners
        segments = 16  # of a quarter circle
        shapes = list[Any]()
        for body in self.obstacles:
            away = (distance + bound.lateral + self.growth.get(body.name, 0.0)) / math.cos(math.pi / 4 / segments)
            shapes.append(widen(body.horizontal_shape.buffer(away, quad_segs=segments), max_widening))
        if air.bounds.footprint is not None:
            inside = air.bounds.footprint.shape.buffer(-bound.lateral - SPARE - self.growth.get("bounds", 0.0))
            box = shapely.box(*air.bounds.lower[:2], *air.bounds.upper[:2])
            shapes.append(box.buffer(2 * self.scenario.bounds.margin).difference(inside))
        return union_of(shapes) if shapes else None

    @property
    def free(self) -> Any:
        return self.area.without(self.keep_out)

    @cached_property
    def times(self) -> LegTimes:
        vehicle = self.scenario.vehicle
        empty = Mission(
            self.scenario.frame.home,
            (),
            vehicle.autopilot,
            parameters=vehicle.autopilot_parameters(),
            vehicle=vehicle.learned,
            firmware_version=vehicle.version,
        )
        return LegTimes.of(empty, vehicle.cruise_speed, self.sight.middle, self.scenario.wind.air())

    @cached_property
    def cover(self) -> CoverProblem:
        return CoverProblem.of(self.area, self.sight.spacing, self.times, self.keep_out, self.section.turns_outside)

    def coverage_of(self, tour: Tour) -> Coverage:
        return coverage(self.area, tour, self.sight.spacing, self.keep_out)


@dataclass(frozen=True, eq=False)
class SurveySketch(SurveyTask):
    """Unchecked lines; `seconds` without take-off and landing."""

    tour: Tour
    coverage: Coverage
    seconds: float


def sketch_survey(scenario: Scenario) -> SurveySketch:
    task = task_of(scenario)
    with threadpool_limits(1, "blas"):
        tour = lay_lines(task)
        seconds = task.times.seconds(tour.path)
    return SurveySketch(scenario, {}, tour, task.coverage_of(tour), seconds)


def expect_survey(scenario: Scenario) -> tuple[SurveySection, Area]:
    section = survey_of(scenario)
    area = surveyed_area(scenario)
    if section is None or area is None:
        raise BadInput("expected a [survey] in the scenario, but there is none", code="missing", place="survey")
    return section, area


def task_of(scenario: Scenario, growth: Mapping[str, float] | None = None) -> SurveyTask:
    task = SurveyTask(scenario, growth or {})
    _expect_high_enough(task.sight, scenario)
    return task


def survey_bound(scenario: Scenario) -> DeviationBound:
    chance = scenario.safety.chance
    if chance is None:
        return NO_DEVIATION
    law = law_of(scenario.vehicle.autopilot, scenario.wind.strongest)
    bound = deviation_bound_of(law, chance)
    return DeviationBound(law.lateral.distance(chance / TIGHT_PLACES), bound.down, bound.up)


def _is_passed(body: Obstacle, sight: Sight, scenario: Scenario) -> bool:
    bound = survey_bound(scenario)
    distance = scenario.limits.obstacle_distance + SPARE
    (west, south, base), (east, north, top) = body.bounds.tolist()
    reach = max(sight.across, sight.along) / 2 + distance + bound.lateral
    grid = np.meshgrid(np.linspace(west - reach, east + reach, num=7), np.linspace(south - reach, north + reach, num=7))
    heights = scenario.airspace.ground(np.stack(grid, axis=-1).reshape(-1, 2))
    lowest = float(heights.min()) + sight.least
    highest = float(heights.max()) + sight.least + sight.band
    return bool(top + distance + bound.down <= lowest or highest + distance + bound.up <= base)


def _expect_high_enough(sight: Sight, scenario: Scenario) -> None:
    needed = scenario.limits.height_above_ground + survey_bound(scenario).down + 2 * SPARE
    if sight.least < needed:
        raise NoPath(
            f"{sight.least:g} m above the ground is too low, at least {needed:.2f} m required",
            hint="fly higher (survey.height_above_ground, or a larger survey.gsd_cm)",
            code="survey-too-low",
            place="survey",
            remedies=(Remedy(("survey", "height_above_ground"), float(math.ceil(needed + SPARE))),),
        )


def lay_lines(task: SurveyTask) -> Tour:
    scenario = task.scenario
    section = task.section
    if task.free.is_empty:
        height = f"{task.sight.least:g} m above ground"
        words = f"obstacles and the clearance to them leave nothing of the area at {height}"
        hint = "fly higher (survey.height_above_ground), or with a smaller safety_distance"
        raise NoPath(words, hint=hint, code="area-covered", place="survey")
    _expect_manageable(task)
    begin = np.array(section.entry or scenario.start_point[:2])
    end = np.array(section.exit or scenario.goal_point[:2])
    middles = section.middles(scenario.frame)
    if len(middles) == 1 and section.width is not None and section.direction_deg == "best":
        corridor = _corridor_tour(task, middles[0], section.width, begin)
        if corridor is not None:
            return corridor
    return quickest_tour(task.cover, section.direction_deg, begin, end)


def _expect_manageable(task: SurveyTask) -> None:
    """Refuse what takes too much memory: 100 h take 1 to 2 GB."""
    spacing = task.sight.spacing
    speed = task.scenario.vehicle.cruise_speed
    shape = task.area.shape
    max_lines = 3000
    max_hours = 100
    west, south, east, north = shape.bounds
    lines = shape.area / spacing / math.hypot(east - west, north - south)
    length = float(task.free.area) / spacing
    hours = length / speed / 3600.0
    apart = "set lines farther apart (survey.line_spacing, or a greater height)"
    if lines > max_lines:
        words = f"expected at most {max_lines} lines, not {lines:.0f} or more, {spacing:g} m apart"
        hint = f"{apart}, or split the survey"
    elif hours > max_hours:
        words = f"expected at most {max_hours} h of flight, not {hours:.0f} h or more: "
        words += f"{length / 1000.0:.0f} km of lines at {speed:g} m/s"
        hint = f"split the survey, or {apart}"
    else:
        return
    raise BadInput(words, hint=hint, code="survey-too-long", place="survey")


def _corridor_tour(task: SurveyTask, middle: Plane, width: float, begin: Vector) -> Tour | None:
    """Return lines along a corridor from its end nearer to `begin` (2,); None if one bends back or leaves the area."""
    spacing = task.sight.spacing
    inside = task.free.buffer(1e-6)  # [m]
    count = max(math.ceil(width / spacing - 1e-9), 1)
    if np.linalg.norm(middle[-1] - begin) < np.linalg.norm(middle[0] - begin):
        middle = middle[::-1]
    middle = _trim_ends(middle, min(task.times.past_corners, 1 / 8 * spacing))
    lines = list[Plane]()
    for n in range(count):
        line = shapely.LineString(middle).offset_curve(width * ((n + 0.5) / count - 0.5), join_style="mitre")
        corners = shapely.get_coordinates(line)
        if line.geom_type != "LineString" or len(corners) != len(middle) or not inside.covers(line):
            return None
        lines.append(corners if n % 2 == 0 else corners[::-1])
    swaths = tuple(Swath(a, b) for line in lines for a, b in pairwise(line))
    return Tour.of(swaths, [np.array([before.end, after.begin]) for before, after in pairwise(swaths)])


def _trim_ends(middle: Plane, by: float) -> Plane:
    legs = middle[[1, -2]] - middle[[0, -1]]
    lengths = np.linalg.norm(legs, axis=1, keepdims=True)
    if (lengths <= 2 * by).any():
        return middle
    ends = middle[[0, -1]] + by / lengths * legs
    return np.concatenate([ends[:1], middle[1:-1], ends[1:]])
