from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, ValidationError, ValidationInfo, model_validator
from pydantic_core import PydanticKnownError

import ipoa_mission.scenario.flight_sections as flight_sections
import ipoa_mission.scenario.place_sections as place_sections
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import BadInput, TooFar
from ipoa_mission.files import plug_ins
from ipoa_mission.geodesy import EARTH_RADIUS, REACH, Geodetic, LocalFrame, apart, swap_hint
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.ground import FLAT_GROUND, Ground, HasHeight, MovedTerrain
from ipoa_mission.maps.geozones import Instant
from ipoa_mission.maps.passed import PassedCount, PassedOver, count_passed_over
from ipoa_mission.rules import expect_ignorable
from ipoa_mission.scenario.explain import explained
from ipoa_mission.scenario.flight_sections import WindSection
from ipoa_mission.scenario.map_sections import MapSection
from ipoa_mission.scenario.obstacles import ObstacleSection
from ipoa_mission.scenario.path_limits import Limits, low_zones, without_repeats
from ipoa_mission.scenario.place_sections import FenceSection, FlatTerrain, Place
from ipoa_mission.scenario.section import NotNegative, Section, merged
from ipoa_mission.scenario.surroundings import Reach, Surroundings, surroundings_of
from ipoa_mission.scenario.vehicle_section import VehicleSection
from ipoa_mission.unread import Unread
from ipoa_mission.wind import Wind
from ipoa_mission.world.airspace import Airspace

# docs/lab/profiles.md: few stops save most time and energy.
PROFILES: Mapping[str, Mapping[str, Any]] = {
    "delivery": {"cost": {"omega": (0.9, 0.05, 0.05)}},
    "rescue": {"safety_distance": 3.0, "cost": {"omega": (0.3, 0.1, 0.6), "d_safe": 15.0}},
    "endurance": {"cost": {"omega": (0.5, 0.45, 0.05)}, "route": {"tolerance": 8.0}},
}
# A file's name that is valid on every system.
_NAME = r"^[^./\\:*?\"<>|\x00-\x1f\x7f][^/\\:*?\"<>|\x00-\x1f\x7f]*$"
Made = TypeVar("Made")
CACHED = ("frame", "known", "_surroundings")
WORLD = {"time", "home", "start", "goal", "via", "bounds", "terrain", "obstacles", "maps", "fence"}


def _expect_added(value: Any) -> Any:
    if isinstance(value, ValidationError):
        raise value
    if not isinstance(value, AddedSection):
        raise PydanticKnownError("extra_forbidden")
    return value


class Scenario(Section):
    """A flight to be planned, with the keys of a scenario file; see docs/scenario.md.

    Example:
        >>> from ipoa_mission import Scenario
        >>> home = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
        >>> start, goal = {"east": 0.0, "north": 0.0, "up": 15.0}, {"east": 120.0, "north": 90.0, "up": 20.0}
        >>> Scenario.from_dict({"name": "field", "home": home, "start": start, "goal": goal}).goal_point
        array([120.,  90.,  20.])
    """

    model_config = ConfigDict(extra="allow")

    name: Annotated[str, Field(pattern=_NAME)] = "mission"
    """Also the name of the output files. Default: that of the scenario file."""
    profile: Literal["delivery", "rescue", "endurance"] | None = None
    """Weights and distances for a task. Explicit values take precedence. Default: the weights of the paper."""
    safety_distance: NotNegative = 1.0
    """Least clearance between the vehicle's hull and anything else [m]."""
    safety: flight_sections.SafetySection = flight_sections.SafetySection()
    """Confidence in that clearance."""
    time: Instant | None = None
    """Take-off time, such as 2026-11-22T10:00:00Z. Zones that are inactive in the following hour are ignored. Default:
    zones are kept at all times."""
    home: place_sections.HomeSection
    """Take-off place, and origin of the local frame."""
    start: Place
    """Begin of the planned path, above home or near it. Default with a `survey`: over home, at its height."""
    goal: Place
    """End of the planned path. Default with a `survey`: where it begins."""
    via: tuple[Place, ...] = ()
    """Via points in this order; each is a waypoint of the mission."""
    bounds: place_sections.BoundsSection = place_sections.BoundsSection()
    """Box in which the flight stays."""
    terrain: place_sections.TerrainSection = FlatTerrain()
    """The ground."""
    obstacles: tuple[ObstacleSection, ...] = ()
    """Obstacles drawn by hand."""
    vehicle: VehicleSection = VehicleSection()
    """The vehicle."""
    wind: WindSection = WindSection()
    """The wind of the flight."""
    cost: flight_sections.CostSection = flight_sections.CostSection()
    """The cost of a path."""
    planning: flight_sections.PlanningSection = flight_sections.PlanningSection()
    """The search for a path."""
    optimizer: flight_sections.OptimizerSection = flight_sections.OptimizerSection()
    """The search algorithm."""
    route: flight_sections.RouteSection = flight_sections.RouteSection()
    """Waypoints of the curve, and the end of the mission."""
    maps: tuple[MapSection, ...] = ()
    """Files with buildings, no-fly zones or the flight area."""
    fence: tuple[FenceSection, ...] = ()
    """Geofence that the path keeps and the mission contains."""
    rally: tuple[Place, ...] = ()
    """Rally points of the mission."""
    __pydantic_extra__: dict[str, Annotated[Any, AfterValidator(_expect_added)]]

    @classmethod
    def model_json_schema(cls, *options: Any, **named: Any) -> dict[str, Any]:
        whole = super().model_json_schema(*options, **named)
        ends = [{"required": ["start", "goal"]}]
        for name, section in added_sections().items():
            own = section.model_json_schema(*options, **named)
            whole["$defs"] |= own.pop("$defs", {}) | {section.__name__: own}
            choices = [{"$ref": f"#/$defs/{section.__name__}"}, {"type": "null"}]
            whole["properties"][name] = {"anyOf": choices, "default": None, "description": section.about}
            ends.append({"required": [name]})
        whole["$defs"] = dict(sorted(whole["$defs"].items()))
        return dict(sorted((whole | {"additionalProperties": False, "anyOf": ends, "required": ["home"]}).items()))

    @model_validator(mode="before")
    @classmethod
    def _with_defaults(cls, table: Any, info: ValidationInfo) -> Any:
        if not isinstance(table, dict):
            return table
        name = table.get("profile")
        profile = PROFILES.get(name, {}) if isinstance(name, str) else {}
        return _with_added(merged(profile, table), info.context)

    @model_validator(mode="after")
    def _near_home(self) -> "Scenario":
        places = {"start": self.start, "goal": self.goal, **{f"via[{i}]": place for i, place in enumerate(self.via)}}
        for name, place in (places | {f"rally[{i}]": place for i, place in enumerate(self.rally)}).items():
            there = place.there()
            away = float(np.hypot(*place.east_north(self.frame))) if there is None else apart(self.frame.home, there)
            if not away < REACH:
                far = f"{away / 1000:{'.0f' if away < 4e9 else '.0e'}}"  # 100 times around the Earth
                why = "" if there is None else swap_hint(self.frame.home, there, name)
                raise ValueError(f"{name}: expected a place within {REACH / 1000:g} km of home, not {far} km{why}")
        return self

    @classmethod
    def from_dict(cls, table: Mapping[str, Any], folder: str | Path = "") -> "Scenario":
        """Build a scenario from a table.

        Args:
            table: with the keys of a scenario file.
            folder: base of relative paths.

        Raises:
            BadInput: with place and expected value; or a library is missing.
        """
        try:
            scenario = cls.model_validate(dict(table), context={"folder": str(folder)})
        except ValidationError as error:
            raise explained(error, table, cls) from error
        return scenario.with_files_read()

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> "Scenario":
        """Return a copy, unchecked, which shares the world and a forecast's wind unless `update` changes them."""
        copied = super().model_copy(update=update, deep=deep)
        changed = (update or {}).keys()
        if not (WORLD | added_sections().keys()) & changed:
            copied.__dict__ |= {name: value for name, value in self.__dict__.items() if name in CACHED}
        return copied._with_wind_read() if changed & {"time", "home"} else copied

    def with_airspace(self, airspace: Airspace) -> "Scenario":
        copied = self.model_copy()
        copied.__dict__["_surroundings"] = replace(self._surroundings, airspace=airspace)
        return copied

    def with_files_read(self) -> "Scenario":
        _ = self._surroundings
        return self._with_wind_read()

    def _with_wind_read(self) -> "Scenario":
        if self.wind.file is None:
            return self
        from ipoa_mission.maps.winds import read_wind

        begins = None if self.time is None else np.datetime64(int(self.time.timestamp()), "s")
        forecast = read_wind(self.wind.file, self.home.geodetic(), begins)
        return self.model_copy(update={"wind": WindSection.of(forecast.wind, forecast, self.wind.file)})

    def in_wind(self, wind: Wind | None) -> "Scenario":
        return self if wind is None else self.model_copy(update={"wind": WindSection.of(wind)})

    def ignoring(self, codes: Iterable[str]) -> "Scenario":
        """Ignore these findings, too. Raises BadInput if one may mean a crash."""
        more = tuple(sorted(expect_ignorable(codes) - self.safety.ignored))
        safety = self.safety.model_copy(update={"ignore": (*self.safety.ignore, *more)})
        return self.model_copy(update={"safety": safety}) if more else self

    def flown_by(self, autopilot: Autopilot) -> "Scenario":
        if autopilot is self.vehicle.autopilot:
            return self
        return self.model_copy(update={"vehicle": self.vehicle.flown_by(autopilot)})

    def why_elsewhere(self, home: Geodetic) -> BadInput | None:
        if not (abs(home.latitude_deg) <= 90 and abs(home.longitude_deg) <= 360):
            return None
        away = apart(home, self.frame.home)
        if away <= REACH:
            return None
        return TooFar(
            f"it is {away / 1000:.0f} km from the scenario's, expected within {REACH / 1000:g} km",
            hint="check that it is the scenario of this mission",
            place="home",
        )

    def expect_here(self, home: Geodetic) -> None:
        elsewhere = self.why_elsewhere(home)
        if elsewhere is not None:
            raise elsewhere

    @cached_property
    def frame(self) -> LocalFrame:
        return LocalFrame(self.home.geodetic())

    @cached_property
    def start_point(self) -> Vector:
        return self.start.point(self.frame, self.airspace.ground)

    @cached_property
    def goal_point(self) -> Vector:
        return self.goal.point(self.frame, self.airspace.ground)

    @cached_property
    def via_points(self) -> Points:
        return self._points(self.via)

    @cached_property
    def rally_points(self) -> Points:
        return self._points(self.rally)

    @property
    def added(self) -> "dict[str, AddedSection]":
        return self.__pydantic_extra__

    @cached_property
    def known(self) -> dict[Any, Any]:
        """Return the results that added tables have computed in this world."""
        return {}

    def cached(self, make: "Callable[[Scenario], Made]") -> "Made":
        """Return `make` of this scenario, computed once."""
        made: dict[Any, Made] = self.__dict__.setdefault("_made", {})
        if make not in made:
            made[make] = make(self)
        return made[make]

    @property
    def added_reach(self) -> Reach:
        reaches = [section.reach(self) for section in self.added.values()]
        corners = np.vstack([np.zeros((0, 2)), *(corners for corners, _ in reaches)])
        return corners, max((height for _, height in reaches), default=0.0)

    @property
    def airspace(self) -> Airspace:
        return self._surroundings.airspace

    @property
    def ground(self) -> Ground:
        return self.ground_from(self.frame)

    def ground_from(self, frame: LocalFrame) -> Ground:
        """Return the ground as an autopilot counts, from home."""
        if isinstance(self.terrain, FlatTerrain):
            return FLAT_GROUND
        terrain: HasHeight = self.airspace.terrain
        if frame.home != self.frame.home:
            terrain = MovedTerrain(terrain, partial(self.frame.moved, other=frame))
        return Ground(terrain, float(terrain.height(np.zeros((1, 2)))[0]), EARTH_RADIUS)

    @property
    def geofence(self) -> tuple[FenceSection, ...]:
        return self._surroundings.geofence

    @property
    def remarks(self) -> tuple[str, ...]:
        wind = self.wind.forecast
        more = () if wind is None else (*wind.remarks, *(thing.words for thing in wind.unread))
        return (*self.vehicle.remarks, *self._surroundings.remarks, *more)

    @property
    def passed_over(self) -> tuple[PassedOver, ...]:
        return self._surroundings.passed_over

    @property
    def passed_counts(self) -> tuple[PassedCount, ...]:
        return tuple(count_passed_over(self.passed_over))

    @property
    def unread(self) -> tuple[Unread, ...]:
        wind = self.wind.forecast
        return (*self._surroundings.unread, *(() if wind is None else wind.unread))

    @cached_property
    def places(self) -> Points:
        """Return start, via points and goal, (k, 3) [m]."""
        return without_repeats(self.start_point, self.via_points, self.goal_point)

    @property
    def radius(self) -> float:
        return self.vehicle.radius

    @cached_property
    def limits(self) -> Limits:
        planning = self.planning
        distance = self.vehicle.radius + self.safety_distance
        angles = (planning.max_climb_angle_deg, planning.max_descent_angle_deg)
        climb, descent = (np.inf if angle is None else float(np.radians(angle)) for angle in angles)
        least = distance if planning.min_height_above_ground is None else planning.min_height_above_ground
        zones = low_zones(self.places, self.airspace, least, min(climb, descent))
        return Limits(distance, least, planning.max_height_above_ground or np.inf, climb, descent, zones)

    def _points(self, places: tuple[Place, ...]) -> Points:
        return np.array([place.point(self.frame, self.airspace.ground) for place in places]).reshape(-1, 3)

    @cached_property
    def _surroundings(self) -> Surroundings:
        return surroundings_of(self)


class AddedSection(Section):
    """A table of another room, in place of start and goal; an entry point of `ipoa_mission.scenario_sections`."""

    about: ClassVar[str]
    planned_by: ClassVar[str]

    @classmethod
    @abstractmethod
    def with_ends(cls, table: Mapping[str, Any], section: Self | None) -> dict[str, Any]:
        """Add start and goal to a scenario's table; None: it is invalid."""

    @abstractmethod
    def reach(self, scenario: Scenario) -> Reach:
        """Return its corners, and its greatest height above ground [m]."""


@cache
def added_sections() -> dict[str, type[AddedSection]]:
    return {entry.name: entry.load() for entry in plug_ins("scenario_sections")}


def _with_added(table: dict[str, Any], context: Any) -> dict[str, Any]:
    for name, section in added_sections().items():
        raw = table.pop(name, None)
        if raw is None:
            continue
        parsed: AddedSection | ValidationError
        try:
            parsed = section.model_validate(raw, context=context)
        except ValidationError as error:
            parsed = error
        if isinstance(raw, Mapping | section):
            table = section.with_ends(table, parsed if isinstance(parsed, section) else None)
        table = {name: parsed, **table}
    return table
