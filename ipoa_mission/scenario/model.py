"""The scenario: every table of the file with its defaults, and the world it describes.

The smallest valid scenario has `home`, `start` and `goal`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AwareDatetime, ConfigDict, Field, ValidationError, ValidationInfo, model_validator

from ipoa_mission.errors import BadInput, TooFar
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.maps.passed import PassedCount, PassedOver
from ipoa_mission.rules import expect_ignorable
from ipoa_mission.scenario.explain import explained
from ipoa_mission.scenario.map_sections import MapSection
from ipoa_mission.scenario.obstacles import ObstacleSection
from ipoa_mission.scenario.path_limits import Limits, low_zones, without_repeats
from ipoa_mission.scenario.place_sections import (
    BoundsSection,
    FenceSection,
    FlatTerrain,
    HomeSection,
    Place,
    TerrainSection,
)
from ipoa_mission.scenario.profiles import with_profile
from ipoa_mission.scenario.safety import SafetySection
from ipoa_mission.scenario.section import NotNegative, Positive, Section
from ipoa_mission.scenario.seeking import CostSection, OptimizerSection, PlanningSection
from ipoa_mission.scenario.site import NO_REACH, Reach
from ipoa_mission.scenario.surroundings import Surroundings, surroundings_of
from ipoa_mission.scenario.survey_section import SurveySection, with_survey
from ipoa_mission.scenario.vehicle_section import VehicleSection
from ipoa_mission.scenario.wind_section import WindSection
from ipoa_mission.survey.area import Area
from ipoa_mission.unread import Unread
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.wind import Wind
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.frame import REACH, Geodetic, LocalFrame, apart, why_so_far
from ipoa_mission.world.ground import EARTH_RADIUS, LEVEL, Ground

EARTH = 40_000_000.0  # its circumference [m]
KEPT = ("frame", "survey_area", "_surroundings", "from_starts")  # of the world, that are worked out once
#: The tables that the world is made from.
WORLD = {"home", "start", "goal", "via", "bounds", "terrain", "obstacles", "maps", "fence", "survey"}


class RouteSection(Section):
    """How the curve becomes waypoints, and how the mission ends."""

    mode: Literal["even", "corridor", "spline", "fastest"] = "fastest"
    """`even`: a waypoint every `spacing` metres; `corridor`: the fewest whose legs stay within `tolerance`; `spline`:
    spline waypoints every `spacing` metres (ArduPilot); `fastest`: what the autopilot flies in the least time, its
    predicted path within `tolerance`; of routes that differ by less than half a per cent, the one that keeps away
    farthest."""
    spacing: Positive = 10.0
    """Greatest distance between waypoints of `even` and `spline` [m]."""
    tolerance: Positive = 4.0
    """How far the legs of `corridor`, or the predicted path of `fastest`, may leave the curve [m]."""
    ending: Literal["rtl", "land"] = "rtl"
    """`rtl`: return to home and land there, after a climb over the goal where the way would not be clear; `land`: land
    at the goal."""


#: What a file may be called on every system: no separators, nothing that Windows keeps for itself, no dot before it.
FILE_NAME = r"^[^./\\:*?\"<>|\x00-\x1f\x7f][^/\\:*?\"<>|\x00-\x1f\x7f]*$"


def _needs_ends(schema: dict[str, Any]) -> None:
    """In the schema, that a survey may stand in place of start and goal."""
    schema["required"] = ["home"]
    schema["anyOf"] = [{"required": ["start", "goal"]}, {"required": ["survey"]}]


class Scenario(Section):
    """A flight to be planned: what a scenario file holds, key by key; docs/scenario.md says what each means.

    Example:
        >>> from ipoa_mission import Scenario
        >>> home = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
        >>> start, goal = {"east": 0.0, "north": 0.0, "up": 15.0}, {"east": 120.0, "north": 90.0, "up": 20.0}
        >>> Scenario.from_dict({"name": "field", "home": home, "start": start, "goal": goal}).goal_point
        array([120.,  90.,  20.])
    """

    model_config = ConfigDict(json_schema_extra=_needs_ends)

    name: Annotated[str, Field(pattern=FILE_NAME)] = "mission"
    """Also the name of the files that are written; left out, that of the scenario file."""
    profile: Literal["delivery", "rescue", "endurance"] | None = None
    """Weights and distances for a task; what the file says itself wins. Left out, those of the paper."""
    safety_distance: NotNegative = 1.0
    """Least clearance that must be left between the vehicle's hull and anything else [m]."""
    safety: SafetySection = SafetySection()
    """How sure that clearance is."""
    time: AwareDatetime | None = None
    """When it takes off, such as 2026-11-22T10:00:00Z: zones that are not active in the hour from then on are left out;
    left out itself, zones are kept at all times."""
    home: HomeSection
    """Where the vehicle takes off, and the origin of the local frame."""
    start: Place
    """Where the planned path begins, above home or a little way from it; left out with a `survey`, over home, as high
    as that is flown."""
    goal: Place
    """Where the planned path ends; left out with a `survey`, where it begins."""
    via: tuple[Place, ...] = ()
    """Places to pass on the way, in this order: each is a waypoint of the mission."""
    bounds: BoundsSection = BoundsSection()
    """The box in which the flight must stay."""
    terrain: TerrainSection = FlatTerrain()
    """The ground."""
    obstacles: tuple[ObstacleSection, ...] = ()
    """What stands in the way, drawn by hand."""
    vehicle: VehicleSection = VehicleSection()
    """What flies the mission."""
    wind: WindSection = WindSection()
    """In what wind it is to fly."""
    cost: CostSection = CostSection()
    """How a path is judged."""
    planning: PlanningSection = PlanningSection()
    """How the path is sought."""
    optimizer: OptimizerSection = OptimizerSection()
    """The search algorithm."""
    route: RouteSection = RouteSection()
    """How the curve becomes waypoints, and how the mission ends."""
    maps: tuple[MapSection, ...] = ()
    """Files with buildings, no-fly zones or the flight area."""
    fence: tuple[FenceSection, ...] = ()
    """Geofence that the path keeps and that goes into the mission."""
    rally: tuple[Place, ...] = ()
    """Rally points that go into the mission."""
    survey: SurveySection | None = None
    """An area to be seen, in place of a goal."""

    @model_validator(mode="before")
    @classmethod
    def _what_is_left_out(cls, table: Any, info: ValidationInfo) -> Any:
        return with_survey(with_profile(table), info.context) if isinstance(table, dict) else table

    @model_validator(mode="after")
    def _near_home(self) -> "Scenario":
        places = {"start": self.start, "goal": self.goal, **{f"via[{i}]": place for i, place in enumerate(self.via)}}
        for name, place in (places | {f"rally[{i}]": place for i, place in enumerate(self.rally)}).items():
            there = place.there()
            away = float(np.hypot(*place.east_north(self.frame))) if there is None else apart(self.frame.home, there)
            if not away < REACH:
                far = f"{away / 1000:.0f}" if away < 100 * EARTH else f"{away / 1000:.0e}"
                why = "" if there is None else why_so_far(self.frame.home, there, name)
                words = f"{name}: expected a place within {REACH / 1000:g} km of home, not {far} km{why}"
                raise ValueError(words)
        return self

    @classmethod
    def from_dict(cls, table: Mapping[str, Any], folder: str | Path = "") -> "Scenario":
        """The scenario in a table.

        Args:
            table: with the keys of a scenario file.
            folder: where the files that it names are sought.

        Returns:
            The scenario, its maps read.

        Raises:
            BadInput: naming the place and what was expected there, or the map and the place in it.
            BadInput: a library that reads a map is not installed.
        """
        try:
            scenario = cls.model_validate(dict(table), context={"folder": str(folder)})
        except ValidationError as error:
            raise explained(error, table, cls) from error
        scenario.read_maps()
        return scenario.with_wind_read()

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> "Scenario":
        """A copy with some values replaced, unchecked; its world is the same one unless they describe it.

        Args:
            update: the new values.
            deep: copy what the values hold too.

        Returns:
            The copy.
        """
        copied = super().model_copy(update=update, deep=deep)
        if not WORLD & (update or {}).keys():
            copied.__dict__ |= {key: self.__dict__[key] for key in KEPT if key in self.__dict__}
        return copied

    def in_airspace(self, airspace: Airspace) -> "Scenario":
        """A copy in another world."""
        copied = self.model_copy(update={})
        copied.__dict__["_surroundings"] = replace(self._surroundings, airspace=airspace)
        return copied

    def with_wind_read(self) -> "Scenario":
        """The same in the wind of the forecast that it names, if it names one.

        Raises:
            BadInput, MissionError: as `read_wind`.
        """
        if self.wind.file is None:
            return self
        from ipoa_mission.maps.winds import read_wind

        begins = None if self.time is None else np.datetime64(int(self.time.timestamp()), "s")
        forecast = read_wind(self.wind.file, self.home.geodetic(), begins)
        return self.model_copy(update={"wind": WindSection.of(forecast.wind, forecast)})

    def in_wind(self, wind: Wind) -> "Scenario":
        """The same in this wind."""
        return self.model_copy(update={"wind": WindSection.of(wind)})

    def ignoring(self, codes: Iterable[str]) -> "Scenario":
        """Leave out the findings of these codes, too.

        Raises:
            BadInput: a code is none, or a crash may follow from what it finds.
        """
        more = tuple(sorted(expect_ignorable(codes) - self.safety.ignored))
        safety = self.safety.model_copy(update={"ignore": (*self.safety.ignore, *more)})
        return self.model_copy(update={"safety": safety}) if more else self

    def flown_by(self, autopilot: Autopilot) -> "Scenario":
        """The same with this autopilot in its vehicle."""
        if autopilot is self.vehicle.autopilot:
            return self
        return self.model_copy(update={"vehicle": self.vehicle.flown_by(autopilot)})

    def why_elsewhere(self, home: Geodetic) -> BadInput | None:
        """That a mission from `home` is of another place than this scenario; None where it is not.

        A home that is no place is judged by those who look at positions.
        """
        if not (abs(home.latitude_deg) <= 90 and abs(home.longitude_deg) <= 360):
            return None
        away = apart(home, self.frame.home)
        if away <= REACH:
            return None
        return TooFar(
            f"it is {away / 1000:.0f} km from the scenario's, expected within {REACH / 1000:g} km",
            hint="is it the scenario of another mission?",
            place="home",
        )

    def expect_here(self, home: Geodetic) -> None:
        """Refuse a mission from `home` that is of another place.

        Raises:
            BadInput: saying how far it is.
        """
        if (elsewhere := self.why_elsewhere(home)) is not None:
            raise elsewhere

    def read_maps(self) -> None:
        """Read the maps and make the world of them, now rather than when it is first asked for.

        Raises:
            BadInput: naming the map file and the place in it that makes no sense, or that home lies outside.
            BadInput: a library that reads a map is not installed.
        """
        _ = self._surroundings

    @cached_property
    def frame(self) -> LocalFrame:
        """The local frame at home."""
        return LocalFrame(self.home.geodetic())

    @cached_property
    def start_point(self) -> Vector:
        """Where the planned path begins, (3,) [m]."""
        return self._point(self.start)

    @cached_property
    def goal_point(self) -> Vector:
        """Where the planned path ends, (3,) [m]."""
        return self._point(self.goal)

    @cached_property
    def via_points(self) -> Points:
        """Points on the way, (k, 3) [m]."""
        return self._points(self.via)

    @cached_property
    def rally_points(self) -> Points:
        """Rally points, (k, 3) [m]."""
        return self._points(self.rally)

    @cached_property
    def survey_area(self) -> Area | None:
        """What a survey has to see; None without one.

        Raises:
            BadInput: naming what makes no sense of it.
        """
        return None if self.survey is None else self.survey.build(self.frame)

    @cached_property
    def from_starts(self) -> "dict[int, Scenario]":
        """Its world as seen from those of the survey's start places that were asked for; `at_start` fills it."""
        return {}

    @property
    def survey_reach(self) -> Reach:
        """Where a survey is flown, corners (n, 2), and how high above the ground at most [m]."""
        area = self.survey_area
        return NO_REACH if self.survey is None or area is None else self.survey.reach(area)

    @property
    def airspace(self) -> Airspace:
        """Bounds, terrain and obstacles in the local frame, those of the maps among them."""
        return self._surroundings.airspace

    @property
    def ground(self) -> Ground:
        """How high the ground is above home, as an autopilot counts: from where it stands, on a round Earth."""
        if isinstance(self.terrain, FlatTerrain):
            return LEVEL
        terrain = self.airspace.terrain
        return Ground(terrain, float(terrain.height(np.zeros((1, 2)))[0]), EARTH_RADIUS)

    @property
    def geofence(self) -> tuple[FenceSection, ...]:
        """The geofence that goes into the mission: `fence`, then the flight area and the no-fly zones of the maps."""
        return self._surroundings.geofence

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was assumed, mended or left out: parameters of another autopilot, things on the maps, of the wind."""
        wind = self.wind.forecast
        more = () if wind is None else (*wind.remarks, *(thing.words for thing in wind.unread))
        return (*self.vehicle.remarks, *self._surroundings.remarks, *more)

    @property
    def passed_over(self) -> tuple[PassedOver, ...]:
        """What the maps have near the flight that became no obstacle and may stand; of the rest the first ones."""
        return self._surroundings.passed_over

    @property
    def passed_counts(self) -> tuple[PassedCount, ...]:
        """How many things on the maps became no obstacle, by file and reason."""
        return self._surroundings.passed_counts

    @property
    def unread(self) -> tuple[Unread, ...]:
        """What the readers of its files did not take, each kind once; `passed_counts` are the rest."""
        wind = self.wind.forecast
        return (*self._surroundings.unread, *(() if wind is None else wind.unread))

    @cached_property
    def places(self) -> Points:
        """Start, via points and goal, in this order, (k, 3) [m]; a via point where the way already is counts once."""
        return without_repeats(self.start_point, self.via_points, self.goal_point)

    @property
    def unix_s(self) -> float | None:
        """When it takes off [s since 1970]; None where nobody says."""
        return None if self.time is None else self.time.timestamp()

    @property
    def radius(self) -> float:
        """Radius of the vehicle's hull [m]."""
        return self.vehicle.radius

    @cached_property
    def limits(self) -> Limits:
        """What the path must keep."""
        planning, distance = self.planning, self.vehicle.radius + self.safety_distance
        angles = (planning.max_climb_angle_deg, planning.max_descent_angle_deg)
        climb, descent = (np.inf if angle is None else float(np.radians(angle)) for angle in angles)
        least = distance if planning.min_height_above_ground is None else planning.min_height_above_ground
        zones = low_zones(self.places, self.airspace, least, min(climb, descent))
        return Limits(distance, least, planning.max_height_above_ground or np.inf, climb, descent, zones)

    def _point(self, place: Place) -> Vector:
        return place.point(self.frame, self.airspace.ground)

    def _points(self, places: tuple[Place, ...]) -> Points:
        return np.array([self._point(place) for place in places]).reshape(-1, 3)

    @cached_property
    def _surroundings(self) -> Surroundings:
        return surroundings_of(self)
