import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias, TypeVar

import numpy as np
import shapely
from pydantic import AfterValidator, Field, PositiveInt, WithJsonSchema, model_validator

from ipoa_mission import BadInput, MissionError, Scenario
from ipoa_mission.geodesy import REACH, Geodetic, LocalFrame, apart
from ipoa_mission.geometry import Plane
from ipoa_mission.scenario.map_sections import NoFlyMap
from ipoa_mission.scenario.model import WORLD, AddedSection
from ipoa_mission.scenario.place_sections import (
    BoundsSection,
    FlatTerrain,
    GridTerrain,
    HomeSection,
    Horizontal,
    Place,
    TerrainSection,
)
from ipoa_mission.scenario.section import NotNegative, Number, Positive, Section, existing_file
from ipoa_mission.scenario.surroundings import Reach
from ipoa_mission.survey.camera import GivenCamera
from ipoa_mission.survey.survey_area import Area, corridor, depth_of, expect_here, read_map, read_polygon, shapes_in
from ipoa_mission.world.terrain import Grid

BAND = 0.15  # share of height over uneven ground
USUAL_SPACING = 20.0  # [m]
USUAL_HEIGHT = 40.0  # [m]


def _check_overlap(share: float) -> float:
    if not 0.0 <= share < 1.0:
        meant = f" ({share / 100:g} for {share:g} %)" if 1.0 < share < 100.0 else ": at 100 % photos do not advance"
        raise ValueError(f"expected a share from 0 to below 1, not {share:g}{meant if share >= 1 else ''}")
    return share


def _check_direction(value: Any) -> Any:
    numbers = value if isinstance(value, list | tuple) else [value]
    finite = [isinstance(n, int | float) and not isinstance(n, bool) and math.isfinite(n) for n in numbers]
    if value not in ("best", "crosshatch") and not (finite and all(finite)):
        raise ValueError(f'expected "best", "crosshatch", degrees or a list of degrees, not {value!r}')
    return value


def _check_nesting(value: Any) -> Any:
    if not 2 <= depth_of(value) <= 4:
        raise ValueError("expected [[east, north], ...], rings of these, or polygons of such rings")
    return value


_NUMBERS: dict[str, Any] = {"type": "array", "items": {"type": "number"}}
_RING: dict[str, Any] = {"type": "array", "items": _NUMBERS}
_PARTS: dict[str, Any] = {"type": "array", "items": _RING}
Overlap: TypeAlias = Annotated[Number, AfterValidator(_check_overlap)]
Direction: TypeAlias = Annotated[
    Any,
    AfterValidator(_check_direction),
    WithJsonSchema({"anyOf": [{"enum": ["best", "crosshatch"]}, {"type": "number"}, _NUMBERS]}),
]
Spot: TypeAlias = tuple[Number, Number]
Rings: TypeAlias = Annotated[
    Any, AfterValidator(_check_nesting), WithJsonSchema({"anyOf": [_RING, _PARTS, {"type": "array", "items": _PARTS}]})
]
Moved = TypeVar("Moved", bound=Section)
Ring: TypeAlias = tuple[tuple[float, float], ...]
Move: TypeAlias = Callable[[Plane], Plane]  # of places


class SurveySection(AddedSection):
    """An area to photograph or scan in parallel lines, in place of a goal."""

    about: ClassVar = "Area to photograph or scan, in place of a goal."
    planned_by: ClassVar = "plan_survey"

    area: Annotated[Path | None, existing_file("a map")] = None
    """A map with the area as polygons, holes as inner rings, in a format of `maps`, such as GeoJSON and KML. The path
    is relative to the scenario file. With `width`, its lines are corridors."""
    polygon: Rings | None = None
    """The area itself: `[[east, north], ...]`, meters from home. In a list of such rings the others are holes; a list
    of these is several areas."""
    line: Annotated[tuple[Spot, ...], Field(min_length=2)] | None = None
    """In place of an area, the center line of a corridor: `[[east, north], ...]`, meters from home."""
    width: Positive | None = None
    """Width of the corridor [m]."""
    line_spacing: Positive | None = None
    """Distance between neighboring lines [m]. Default: by the camera's footprint and `side_overlap`."""
    camera: GivenCamera | None = None
    """The camera, by its name or a table of its numbers. Default: no photos."""
    gsd_cm: Positive | None = None
    """Greatest width of a pixel on the ground [cm], in place of a height; needs a camera."""
    gimbal: Literal["nadir"] | None = None
    """`nadir`: the gimbal points the camera straight down from take-off on. Default: no gimbal command."""
    front_overlap: Overlap | None = None
    """Least share of a photo that the next one repeats; needs a camera. Default: 0.7."""
    side_overlap: Overlap | None = None
    """Least share of a photo that those of the next line repeat; needs a camera. Default: 0.7."""
    height_above_ground: Positive | None = None
    """Least height above the highest visible ground [m]; over uneven ground up to 15 % higher. Default: by `gsd_cm`."""
    direction_deg: Direction = "best"
    """Direction of the lines, clockwise from north: a number, or several (one pass each). `best` is the quickest one;
    `crosshatch` is the best one and the one across."""
    turns_outside: NotNegative = 0.0
    """Greatest distance of turns beyond the area, as commanded [m]."""
    entry: Spot | None = None
    """Place near the begin of the first line, `[east, north]`, meters from home. Default: home."""
    exit: Spot | None = None
    """Place near the end of the last line, `[east, north]`, meters from home. Default: home or the goal."""
    flights: PositiveInt | None = None
    """Number of flights. Default: the fewest that the battery allows, each with its reserve."""
    starts: Annotated[tuple[Spot, ...], Field(min_length=1)] | None = None
    """Take-off and landing places on the ground in place of home, `[[east, north], ...]`, meters from home; home itself
    is `[0, 0]`. Each flight gets the place with the least total time. Without a battery each place has one flight over
    the nearest part."""

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        areas = [key for key in ("area", "polygon", "line") if getattr(self, key) is not None]
        if len(areas) != 1:
            raise ValueError(f"expected one of area, polygon or line, not {' and '.join(areas) or 'none'}")
        if self.line is not None and self.width is None:
            raise ValueError("line: needs width")
        if self.polygon is not None and self.width is not None:
            raise ValueError("width: cannot be combined with polygon")
        if self.camera is None:
            for key in ("gsd_cm", "front_overlap", "side_overlap"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: needs camera")
            if self.line_spacing is None:
                raise ValueError("expected a line_spacing or a camera")
        elif self.line_spacing is not None and self.side_overlap is not None:
            raise ValueError("expected either line_spacing or side_overlap")
        if (self.height_above_ground is None) == (self.gsd_cm is None):
            raise ValueError("expected either height_above_ground or, with a camera, gsd_cm")
        if self.starts is not None:
            self._expect_apart(self.starts)
        return self

    def _expect_apart(self, starts: tuple[Spot, ...]) -> None:
        for key in ("flights", "entry", "exit"):
            if getattr(self, key) is not None:
                raise ValueError(f"{key}: cannot be combined with starts, as each flight has its own")
        for n, here in enumerate(starts):
            if not math.hypot(*here) < REACH:
                raise ValueError(f"starts[{n}]: expected a place within {REACH / 1000:g} km of home")
            for m, there in enumerate(starts[:n]):
                if math.dist(here, there) < 2.0:  # [m]
                    raise ValueError(f"starts[{n}]: expected another place than starts[{m}]")

    @property
    def height(self) -> float:
        """Return the height above the ground, the greatest with `gsd_cm` [m]."""
        if self.height_above_ground is not None:
            return self.height_above_ground
        assert self.camera is not None
        assert self.gsd_cm is not None
        return self.camera.height_for(self.gsd_cm)

    @classmethod
    def with_ends(cls, table: Mapping[str, Any], section: Self | None) -> dict[str, Any]:
        for key in ("start", "goal"):
            if section is not None and section.starts is not None and key in table:
                raise ValueError(f"{key}: cannot be combined with survey.starts, where flights begin and end")
        height = 10.0 if section is None else section.height  # above home, before the height is known [m]
        start = table.get("start", {"east": 0.0, "north": 0.0, "height_above_ground": height})
        return {"start": start, "goal": start, **table}

    @property
    def start_places(self) -> tuple[Spot, ...]:
        return self.starts or ()

    def seen_from(self, scenario: Scenario, home: Geodetic) -> Scenario:
        tolerance = 1.0  # [m]
        away = _distances_to_starts(scenario, home)
        if not away or min(away) > tolerance or apart(home, scenario.frame.home) <= tolerance:
            return scenario
        return at_start(scenario, int(np.argmin(away)))

    def reach(self, scenario: Scenario) -> Reach:
        area = surveyed_area(scenario)
        assert area is not None
        corners = shapely.get_coordinates(shapely.box(*area.shape.buffer(self.turns_outside).bounds))
        return np.vstack([corners, *(self.starts or ())]), self.height * (1.0 + BAND)

    def build(self, frame: LocalFrame) -> Area:
        if self.area is not None:
            return expect_here(read_map(self.area, self.width, frame), str(self.area))
        if self.polygon is not None:
            return expect_here(read_polygon(self.polygon), "survey.polygon")
        shape = corridor(np.array(self.line), self.width or 0.0, "survey.line")
        return expect_here(Area(shapely.MultiPolygon([shape])), "survey.line")

    def middles(self, frame: LocalFrame) -> tuple[Plane, ...]:
        if self.line is not None:
            return (np.array(self.line),)
        if self.width is None or self.area is None:
            return ()
        shapes = (shape for _, shape in shapes_in(self.area, frame))
        return tuple(shapely.get_coordinates(shape) for shape in shapes if shape.geom_type == "LineString")


def survey_of(scenario: Scenario) -> SurveySection | None:
    section = scenario.added.get("survey")
    return section if isinstance(section, SurveySection) else None


def surveyed_area(scenario: Scenario) -> Area | None:
    section = survey_of(scenario)
    if section is not None and "area" not in scenario.known:
        scenario.known["area"] = section.build(scenario.frame)
    return scenario.known.get("area")


def nearest_start(scenario: Scenario, there: Geodetic) -> Scenario:
    away = _distances_to_starts(scenario, there)
    return at_start(scenario, int(np.argmin(away))) if away else scenario


def _distances_to_starts(scenario: Scenario, there: Geodetic) -> list[float]:
    section = survey_of(scenario)
    starts = () if section is None else section.start_places
    return [apart(there, scenario.frame.geodetic(np.array([*start, 0.0]))) for start in starts]


def at_start(scenario: Scenario, n: int) -> Scenario:
    section = survey_of(scenario)
    from_starts = scenario.known.setdefault("from_starts", {})
    assert section is not None
    if section.start_places[n] == (0.0, 0.0):
        return scenario
    if n not in from_starts:
        from_start = scenario.model_copy(update=_sections_from(scenario, section, n))
        try:
            from_start.read_maps()
        except MissionError as error:
            raise error.at(f"survey.starts[{n}]: as home") from error
        from_starts[n] = from_start
    world = from_starts[n]
    moved = scenario.model_copy(update={key: getattr(world, key) for key in (*WORLD, "rally", "survey")})
    return moved.in_world_of(world)


def move_between(old: LocalFrame, new: LocalFrame) -> Move:
    def moved(places: Plane) -> Plane:
        if old.home == new.home:
            return places
        latitude, longitude, _ = old.to_geodetic(np.column_stack([places, np.zeros(len(places))]))
        return new.to_local(latitude, longitude, new.home.altitude)[:, :2]

    return moved


def _sections_from(scenario: Scenario, section: SurveySection, n: int) -> dict[str, Any]:
    old = scenario.frame
    place = np.array(section.start_places[n])
    there = old.geodetic(np.append(place, float(scenario.airspace.terrain.height(place[None])[0])))
    home = HomeSection(
        latitude_deg=round(there.latitude_deg, 7),
        longitude_deg=round(there.longitude_deg, 7),
        altitude_amsl=round(there.altitude, 3),
    )
    new = LocalFrame(home.geodetic())
    rise = home.altitude_amsl - old.home.altitude
    start = Place(east=0.0, north=0.0, height_above_ground=section.height)
    survey = {key: _move_nested(getattr(section, key), move_between(old, new)) for key in ("polygon", "line", "starts")}
    return {
        "home": home,
        "start": start,
        "goal": start,
        "via": (),
        "bounds": _bounds(scenario, new, rise),
        "terrain": _terrain(scenario, new, rise, n),
        "obstacles": tuple(_move_section(obstacle, old, new) for obstacle in scenario.obstacles),
        "maps": tuple(_raise_zones(zones, -rise) if isinstance(zones, NoFlyMap) else zones for zones in scenario.maps),
        "fence": tuple(_move_section(fence, old, new) for fence in scenario.fence),
        "rally": tuple(_move_section(place, old, new) for place in scenario.rally),
        "survey": section.model_copy(update=survey),
    }


def _bounds(scenario: Scenario, new: LocalFrame, rise: float) -> BoundsSection:
    bounds = scenario.airspace.bounds
    east, north, _ = new.local(scenario.frame.home)
    (west, far_east), (south, far_north), (low, high) = zip(bounds.lower, bounds.upper, strict=True)
    return BoundsSection(
        east=(west + east, far_east + east),
        north=(south + north, far_north + north),
        up=(low - rise, high - rise),
        margin=scenario.bounds.margin,
    )


def _terrain(scenario: Scenario, new: LocalFrame, rise: float, n: int) -> TerrainSection:
    section = scenario.terrain
    terrain = scenario.airspace.terrain
    if isinstance(section, FlatTerrain):
        return section.model_copy(update={"height": section.height - rise})
    if isinstance(section, GridTerrain) and isinstance(terrain, Grid):
        rows, columns = terrain.heights.shape
        east = terrain.east + terrain.spacing * np.arange(columns)
        north = terrain.north + terrain.spacing * np.arange(rows)
        nodes = np.column_stack([np.tile(east, rows), np.repeat(north, columns), terrain.heights.ravel()])
        moved = new.to_local(*scenario.frame.to_geodetic(nodes))
        corner = moved[:, :2].mean(axis=0) - terrain.spacing * (np.array([columns, rows]) - 1) / 2
        heights = tuple(map(tuple, moved[:, 2].reshape(rows, columns).tolist()))
        grid = {"east": float(corner[0]), "north": float(corner[1]), "heights": heights, "file": None}
        return section.model_copy(update=grid)
    if section.kind == "analytic":
        words = "expected home, or terrain of another kind: this one is defined from home only"
        raise BadInput(words, place=f"survey.starts[{n}]")
    return section


def _move_section(section: Moved, old: LocalFrame, new: LocalFrame) -> Moved:
    changes = dict[str, Any]()
    place = (0.0, 0.0)
    if isinstance(section, Horizontal):
        place = section.east_north(old)
        there = old.geodetic(np.array([*place, 0.0]))
        degrees = {"latitude_deg": there.latitude_deg, "longitude_deg": there.longitude_deg}
        changes = {"east": None, "north": None, **degrees}
    written = {key: value for key, value in section if value is not None}
    for key in ("footprint", "polygon"):
        if key in written:
            ring = written[key]
            changes |= {key: None, f"{key}_geodetic": _degrees(ring, old)}
            place = tuple(np.mean(ring, axis=0).tolist())
            if "holes" in written:
                changes["holes"] = tuple(_degrees(hole, old) for hole in written["holes"])
        elif f"{key}_geodetic" in written:
            latitude, longitude = np.mean(written[f"{key}_geodetic"], axis=0)
            place = tuple(old.local(Geodetic(latitude, longitude, old.home.altitude))[:2].tolist())
    if "center" in written:
        changes["center"] = _move_section(written["center"], old, new)
    for key in ("up", "base"):
        if key in written:
            changes[key] = float(new.local(old.geodetic(np.array([*place, written[key]])))[2])
    if "heading_deg" in written:
        begin, end = move_between(old, new)(np.array([place, (place[0], place[1] + 1.0)]))
        east, north = end - begin
        changes["heading_deg"] = written["heading_deg"] + math.degrees(math.atan2(east, north))
    return section.model_copy(update=changes)


def _degrees(ring: Iterable[tuple[float, float]], frame: LocalFrame) -> Ring:
    latitude, longitude, _ = frame.to_geodetic(np.array([(*corner, 0.0) for corner in ring]))
    return tuple(zip(latitude.tolist(), longitude.tolist(), strict=True))


def _raise_zones(zones: NoFlyMap, by: float) -> NoFlyMap:
    ends = {"base": zones.base, "top": zones.top}
    return zones.model_copy(update={key: end + by for key, end in ends.items() if end is not None})


def _move_nested(value: Any, move: Move) -> Any:
    if value is None:
        return None
    if not isinstance(value[0][0], int | float):
        return [_move_nested(part, move) for part in value]
    return tuple(map(tuple, move(np.array(value, float)).tolist()))
