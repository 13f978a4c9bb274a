import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
import shapely
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from ipoa_mission import Scenario
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Plane
from ipoa_mission.scenario.model import AddedSection
from ipoa_mission.scenario.section import Count, NotNegative, Number, Positive, existing_file, one_of
from ipoa_mission.scenario.surroundings import Reach
from ipoa_mission.survey.camera import GivenCamera
from ipoa_mission.survey.survey_area import Area, corridor, depth_of, expect_here, read_map, read_polygon, shapes_in
from ipoa_mission.unread import Unread, gathered

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
    flights: Count | None = None
    """Number of flights. Default: the fewest that the battery allows, each with its reserve."""

    _one_area = one_of("area", "polygon", "line")

    @model_validator(mode="after")
    def _compatible(self) -> Self:
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
        return self

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
        height = 10.0 if section is None else section.height  # above home, before the height is known [m]
        start = table.get("start", {"east": 0.0, "north": 0.0, "height_above_ground": height})
        return {"start": start, "goal": start, **table}

    def reach(self, scenario: Scenario) -> Reach:
        area = surveyed_area(scenario)
        assert area is not None
        corners = shapely.get_coordinates(shapely.box(*area.shape.buffer(self.turns_outside).bounds))
        return corners, self.height * (1.0 + BAND)

    def build(self, frame: LocalFrame) -> Area:
        if self.area is not None:
            return expect_here(read_map(self.area, self.width, frame), str(self.area))
        if self.polygon is not None:
            return expect_here(read_polygon(self.polygon), "survey.polygon")
        shape = corridor(np.array(self.line), self.width or 0.0, "survey.line")
        return expect_here(Area(shapely.MultiPolygon([shape])), "survey.line")

    def unread(self, frame: LocalFrame) -> tuple[Unread, ...]:
        return () if self.area is None else gathered(shapes_in(self.area, frame)[1])

    def middles(self, frame: LocalFrame) -> tuple[Plane, ...]:
        if self.line is not None:
            return (np.array(self.line),)
        if self.width is None or self.area is None:
            return ()
        shapes, _ = shapes_in(self.area, frame)
        return tuple(shapely.get_coordinates(shape) for _, shape in shapes if shape.geom_type == "LineString")


def survey_of(scenario: Scenario) -> SurveySection | None:
    section = scenario.added.get("survey")
    return section if isinstance(section, SurveySection) else None


def surveyed_area(scenario: Scenario) -> Area | None:
    section = survey_of(scenario)
    if section is not None and "area" not in scenario.known:
        scenario.known["area"] = section.build(scenario.frame)
    return scenario.known.get("area")
