import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
import shapely
from pydantic import AfterValidator, Field, PositiveInt, ValidationError, WithJsonSchema, model_validator

from ipoa_mission.errors import BadInput, InvalidRing, NothingThere, Remedy, TooFar
from ipoa_mission.geometry import Points
from ipoa_mission.maps.around import Around
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.planar import MapExtent, closed_as_polygon, flat, to_plane, unrepeated
from ipoa_mission.scenario.camera import Camera, GivenCamera
from ipoa_mission.scenario.section import NUMBER, NotNegative, Positive, Section, existing_file
from ipoa_mission.scenario.survey_area import LEAST_M2, Area, Reach
from ipoa_mission.world.frame import REACH, LocalFrame
from ipoa_mission.world.polygon import union_of

BAND = 0.15  # share of height over uneven ground
USUAL_SPACING, USUAL_HEIGHT = 20.0, 40.0  # [m]


def _an_overlap(share: float) -> float:
    if not 0.0 <= share < 1.0:
        meant = f" ({share / 100:g} for {share:g} %)" if 1.0 < share < 100.0 else ": at 100 % photos do not advance"
        raise ValueError(f"expected a share from 0 to below 1, not {share:g}{meant if share >= 1 else ''}")
    return share


def _a_direction(value: Any) -> Any:
    numbers = value if isinstance(value, list | tuple) else [value]
    finite = [isinstance(n, int | float) and not isinstance(n, bool) and math.isfinite(n) for n in numbers]
    if value not in ("best", "crosshatch") and not (finite and all(finite)):
        raise ValueError(f'expected "best", "crosshatch", degrees or a list of degrees, not {value!r}')
    return value


def _nested(value: Any) -> Any:
    if not 2 <= _depth(value) <= 4:
        raise ValueError("expected [[east, north], ...], rings of these, or polygons of such rings")
    return value


def _depth(value: Any) -> int:
    return 1 + (_depth(value[0]) if value else 0) if isinstance(value, list | tuple) else 0


_NUMBERS: dict[str, Any] = {"type": "array", "items": {"type": "number"}}
_RING: dict[str, Any] = {"type": "array", "items": _NUMBERS}
_PARTS: dict[str, Any] = {"type": "array", "items": _RING}
Overlap: TypeAlias = Annotated[float, AfterValidator(_an_overlap), NUMBER]
Direction: TypeAlias = Annotated[
    Any,
    AfterValidator(_a_direction),
    WithJsonSchema({"anyOf": [{"enum": ["best", "crosshatch"]}, {"type": "number"}, _NUMBERS]}),
]
Spot: TypeAlias = tuple[Annotated[float, NUMBER], Annotated[float, NUMBER]]
Rings: TypeAlias = Annotated[
    Any, AfterValidator(_nested), WithJsonSchema({"anyOf": [_RING, _PARTS, {"type": "array", "items": _PARTS}]})
]


class SurveySection(Section):
    """An area to photograph or scan in parallel lines, in place of a goal."""

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
            raise ValueError("width: expected with a line, but not there")
        if self.polygon is not None and self.width is not None:
            raise ValueError("width: expected with a line, not with a polygon")
        if self.camera is None:
            for key in ("gsd_cm", "front_overlap", "side_overlap"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: expected with a camera, but there is none")
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
                raise ValueError(f"{key}: expected without starts, since each flight has its own")
        for n, here in enumerate(starts):
            if not math.hypot(*here) < REACH:
                raise ValueError(f"starts[{n}]: expected a place within {REACH / 1000:g} km of home")
            for m, there in enumerate(starts[:n]):
                if math.dist(here, there) < 2.0:  # [m]
                    raise ValueError(f"starts[{n}]: expected another place than starts[{m}]")

    @property
    def taken_by(self) -> Camera | None:
        return None if self.camera is None else self.camera.build()

    @property
    def height(self) -> float:
        """Return the height above the ground, the greatest with `gsd_cm` [m]."""
        if self.height_above_ground is not None:
            return self.height_above_ground
        camera = self.taken_by
        assert camera is not None
        assert self.gsd_cm is not None
        return camera.height_for(self.gsd_cm)

    def reach(self, area: Area) -> Reach:
        """Return the corners (n, 2), and the greatest height [m]."""
        corners = shapely.get_coordinates(shapely.box(*area.shape.buffer(self.turns_outside).bounds))
        return np.vstack([corners, *(self.starts or ())]), self.height * (1.0 + BAND)

    def spacing(self, height: float) -> float:
        camera = self.taken_by
        if self.line_spacing is not None or camera is None:
            assert self.line_spacing is not None
            return self.line_spacing
        return camera.footprint(height)[0] * (1.0 - _given(self.side_overlap))

    def trigger(self, height: float) -> float | None:
        camera = self.taken_by
        return None if camera is None else camera.footprint(height)[1] * (1.0 - _given(self.front_overlap))

    def build(self, frame: LocalFrame) -> Area:
        """Return the area in the local plane. Raises BadInput."""
        if self.line is not None:
            corridor = _corridor(np.array(self.line), self.width or 0.0, "survey.line")
            return _expect_here(Area(shapely.MultiPolygon([corridor])), "survey.line")
        if self.polygon is not None:
            return _expect_here(_drawn(self.polygon), "survey.polygon")
        assert self.area is not None
        return _expect_here(_mapped(self.area, self.width, frame), str(self.area))

    def middles(self, frame: LocalFrame) -> tuple[Points, ...]:
        """Return center lines, (n, 2) each."""
        if self.line is not None:
            return (np.array(self.line),)
        if self.width is None or self.area is None:
            return ()
        shapes = (shape for _, shape in _shapes(self.area, frame))
        return tuple(shapely.get_coordinates(shape) for shape in shapes if shape.geom_type == "LineString")


def _expect_here(area: Area, place: str) -> Area:
    farthest = float(np.linalg.norm(shapely.get_coordinates(area.shape), axis=1).max())
    if not farthest < REACH:
        words = f"expected an area within {REACH / 1000:g} km of home, not up to {farthest / 1000:.0f} km away"
        raise TooFar(words, hint="places count in meters from home", place=place)
    return area


def _given(overlap: float | None) -> float:
    return 0.7 if overlap is None else overlap


def _drawn(polygon: Any) -> Area:
    depth = _depth(polygon)
    parts = [[polygon]] if depth == 2 else [polygon] if depth == 3 else polygon
    try:
        return Area.of(parts, "survey.polygon")
    except BadInput as error:
        all_brackets = "survey.polygon" + "[0]" * (4 - depth)
        error.place = error.place and error.place.replace(all_brackets, "survey.polygon")
        error.args = (error.args[0].replace(all_brackets, "survey.polygon"),)
        fields = (remedy.field[5 - depth :] for remedy in error.remedies)
        error.remedies = tuple(Remedy(("survey", "polygon", *field)) for field in fields if field)
        raise


def _mapped(path: Path, width: float | None, frame: LocalFrame) -> Area:
    polygons: list[Any] = []
    for place, shape in _shapes(path, frame):
        if shape.geom_type == "LineString" and width is not None:
            polygons.append(_corridor(shapely.get_coordinates(shape), width, place))
            continue
        if shape.geom_type != "Polygon":
            words = "expected a polygon, not an open line"
            raise InvalidRing(words, hint="--width M, or width under [survey], makes it a corridor", place=place)
        (clean,) = unrepeated(np.array([shape], object))
        rings = [shapely.get_coordinates(ring) for ring in (clean.exterior, *clean.interiors)]
        polygons += Area.of([rings], place).shape.geoms
    if not polygons:
        wanted = "a polygon" if width is None else "a line or a polygon"
        message = f"expected {wanted}, but there is none"
        raise NothingThere(message, hint="an area is a Polygon, or a closed line", place=path)
    if width is not None:
        return Area(shapely.MultiPolygon([*shapely.get_parts(union_of(polygons))]))
    rings_of = ([shapely.get_coordinates(ring) for ring in (p.exterior, *p.interiors)] for p in polygons)
    return Area.of([*rings_of], str(path))


def _shapes(path: Path, frame: LocalFrame) -> Iterator[tuple[str, Any]]:
    features = read_features(path, Around.of(frame))
    about = MapExtent(frame)
    shapes, near = to_plane([f.shape for f in features], [f.place for f in features], about)
    about.expect_near()
    for feature, shape, counts in zip(features, shapes, near, strict=True):
        if (missing := feature.missing) is not None and not missing.elsewhere:
            words = f"expected an area that can be read, not {missing.words}"
            raise BadInput(words, missing.remedy, place=feature.place)
        for part in flat(shape) if counts else ():
            if part.geom_type in ("Polygon", "LineString"):
                yield f"{feature.place}.geometry", closed_as_polygon(part)


def _corridor(line: Points, width: float, place: str) -> Any:
    if not np.isfinite(line).all() or (np.diff(line, axis=0) == 0.0).all(axis=1).any():
        raise InvalidRing("expected a line without repeated corners", place=place)
    shape = shapely.LineString(line).buffer(width / 2, cap_style="flat", join_style="mitre", mitre_limit=2.0)
    if shape.geom_type != "Polygon" or shape.area < LEAST_M2:
        raise InvalidRing("expected a line whose corridor is one polygon", place=place)
    return shape


def with_survey(table: Mapping[str, Any], context: Any) -> dict[str, Any]:
    """Add defaults of a survey. Raises ValueError."""
    if not isinstance(table.get("survey"), Mapping | SurveySection):
        return dict(table)
    try:
        section = SurveySection.model_validate(table["survey"], context=context)
    except ValidationError:
        height = 10.0  # above home, before the height is known [m]
    else:
        height = section.height
        for key in ("start", "goal"):
            if section.starts is not None and key in table:
                raise ValueError(f"{key}: expected without survey.starts, where flights begin and end")
    start = table.get("start", {"east": 0.0, "north": 0.0, "height_above_ground": height})
    return {"start": start, "goal": start, **table}
