from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, InvalidRing, NothingThere, Remedy, TooFar
from ipoa_mission.geodesy import REACH, LocalFrame
from ipoa_mission.geometry import Plane, union_of
from ipoa_mission.maps.areas import outline_of, why_no_area
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.passed import FAR_FROM_HOME
from ipoa_mission.maps.planar import remove_repeats, simple_parts, to_plane
from ipoa_mission.unread import Unread

LEAST_M2 = 1e-3
INSET = 0.02  # [m]; more than the rounding of coordinates to 1e-7 degrees
ARC = 64  # segments of a quarter circle


@dataclass(frozen=True, eq=False)
class Area:
    """Disjoint polygons with holes [m from home]; `shape` is a valid `shapely.MultiPolygon`.

    Example:
        >>> field = [[0.0, 0.0], [90.0, 0.0], [90.0, 60.0], [0.0, 60.0]]
        >>> pond = [[20.0, 20.0], [30.0, 20.0], [30.0, 30.0]]
        >>> Area.of([[field, pond]]).shape.area
        5350.0
    """

    shape: shapely.MultiPolygon

    @classmethod
    def of(
        cls, parts: Sequence[Sequence[Sequence[Sequence[float]] | Plane]], where: str = "area", levels: int = 4
    ) -> "Area":
        """Return the area of parts, each a list of rings (n, 2): outer, then holes. Errors name the last `levels`."""
        if not len(parts):
            raise InvalidRing("expected one polygon or more", place=where)
        spelling = _Spelling(where, levels)
        polygons = [_polygon(rings, spelling, n) for n, rings in enumerate(parts)]
        for n, polygon in enumerate(polygons):
            for m, other in enumerate(polygons[:n]):
                _expect_apart(spelling, (n, polygon), (m, other))
        return cls(shapely.MultiPolygon(polygons))

    def without(self, keep_out: Any | None) -> Any:
        return self.shape if keep_out is None else self.shape.difference(keep_out)

    def visible(self, keep_out: Any | None, width: float) -> Any:
        """Return the part within half a width of permitted lines."""
        if keep_out is None:
            return self.shape
        inner = self.without(keep_out).buffer(-INSET, join_style="mitre")
        return self.shape.intersection(inner.buffer(width / 2, quad_segs=ARC))


@dataclass(frozen=True)
class _Spelling:
    """The key of an area, and its levels of brackets, 2 to 4."""

    key: str
    levels: int

    def place(self, *indices: int) -> str:
        return self.key + "".join(f"[{n}]" for n in self._written(indices))

    def misplaced(self, words: str, *indices: int) -> BadInput:
        """Return an error whose remedy takes out the part or ring."""
        written = self._written(indices)
        remedies = (Remedy((*self.key.split("."), *written)),) if written else ()
        return BadInput(words, code="ring-misplaced", place=self.place(*indices), remedies=remedies)

    def _written(self, indices: tuple[int, ...]) -> tuple[int, ...]:
        return indices[4 - self.levels :]


def _polygon(rings: Sequence[Sequence[Sequence[float]] | Plane], spelling: _Spelling, part: int) -> shapely.Polygon:
    where = spelling.place(part)
    if not len(rings):
        raise InvalidRing("expected a ring of corners", place=where)
    outer, *holes = (shapely.Polygon(_ring(ring, spelling.place(part, n))) for n, ring in enumerate(rings))
    for n, hole in enumerate(holes, 1):
        if outer.intersection(hole).area < LEAST_M2:
            words = f"expected a hole inside of its outer ring {spelling.place(part, 0)}, but it lies outside"
            raise spelling.misplaced(words, part, n)
        for m, other in enumerate(holes[: n - 1], 1):
            if hole.within(other) or other.within(hole):
                inner, around = (n, m) if hole.within(other) else (m, n)
                words = f"expected no ring inside of the hole {spelling.place(part, around)}: islands are not surveyed"
                raise spelling.misplaced(words, part, inner)
    left = outer.difference(union_of(holes))
    if left.area < LEAST_M2:
        raise InvalidRing("expected some area, but its holes cover all of it", place=where)
    if left.geom_type != "Polygon":
        raise InvalidRing("expected an area in one piece, but its holes cut it; give each piece as a part", place=where)
    return left


def _ring(ring: Sequence[Sequence[float]] | Plane, where: str) -> Plane:
    try:
        are_numbers = not any(isinstance(number, bool | str) for corner in ring for number in corner)
        corners = np.asarray(ring, float) if are_numbers else np.empty(0)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.ndim != 2 or corners.shape[1:] != (2,):
        raise InvalidRing("expected corners as pairs of numbers, east and north [m]", place=where)
    for n in np.flatnonzero(~np.isfinite(corners).all(axis=1)):
        raise InvalidRing("expected finite numbers", place=f"{where}[{n}]")
    if len(corners) > 1 and (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    for n in np.flatnonzero((corners == np.roll(corners, 1, axis=0)).all(axis=1)):
        raise InvalidRing("expected another corner than the one before", place=f"{where}[{n}]")
    if len(corners) < 3:
        raise InvalidRing(f"expected three corners or more, not {len(corners)}", place=where)
    polygon = shapely.Polygon(corners)
    if shapely.make_valid(polygon).area < LEAST_M2:
        raise InvalidRing("expected a ring with an area, not corners on one line", place=where)
    if not polygon.is_valid:
        why = shapely.is_valid_reason(polygon)
        words = f"expected a ring that does not cross or touch itself, not one with {why.lower()} [m]"
        raise InvalidRing(words, place=where)
    return corners


def _expect_apart(spelling: _Spelling, *parts: tuple[int, shapely.Polygon]) -> None:
    (here, polygon), (there, other) = parts
    if polygon.intersection(other).area > LEAST_M2:
        raise spelling.misplaced(f"expected parts that do not overlap, but it overlaps {spelling.place(there)}", here)
    for (part, inner), (around, outer) in (parts, parts[::-1]):
        if any(inner.within(shapely.Polygon(hole)) for hole in outer.interiors):
            words = f"expected no part inside of a hole of {spelling.place(around)}: islands are not surveyed"
            raise spelling.misplaced(words, part)


def depth_of(value: Any) -> int:
    if not isinstance(value, list | tuple):
        return 0
    return 1 + (depth_of(value[0]) if value else 0)


def parts_of(polygon: Any) -> list[Any]:
    """Return polygons as rings, the outer one first."""
    depth = depth_of(polygon)
    if depth == 2:
        return [[polygon]]
    return [polygon] if depth == 3 else list(polygon)


def expect_here(area: Area, place: str) -> Area:
    farthest = float(np.linalg.norm(shapely.get_coordinates(area.shape), axis=1).max())
    if not farthest < REACH:
        words = f"expected an area within {REACH / 1000:g} km of home, not up to {farthest / 1000:.0f} km away"
        raise TooFar(words, hint="places count in meters from home", place=place)
    return area


def read_polygon(polygon: Any) -> Area:
    return Area.of(parts_of(polygon), "survey.polygon", depth_of(polygon))


def read_map(path: Path, width: float | None, frame: LocalFrame) -> Area:
    polygons: list[Any] = []
    shapes, _ = shapes_in(path, frame)
    for place, shape in shapes:
        if shape.geom_type == "LineString" and width is not None:
            polygons.append(corridor(shapely.get_coordinates(shape), width, place))
            continue
        if shape.geom_type != "Polygon":
            words = "expected a polygon, not an open line"
            raise InvalidRing(words, hint="--width M, or width under [survey], makes it a corridor", place=place)
        polygons += Area.of([_rings_of(remove_repeats(shape))], place).shape.geoms
    if not polygons:
        kinds = "a polygon" if width is None else "a line or a polygon"
        hint = "an area is a Polygon, or a closed line"
        raise NothingThere(f"expected {kinds}, but there is none", hint=hint, place=path)
    if width is not None:
        return Area(shapely.MultiPolygon([*shapely.get_parts(union_of(polygons))]))
    return Area.of([_rings_of(polygon) for polygon in polygons], str(path))


def _rings_of(polygon: shapely.Polygon) -> list[Plane]:
    return [shapely.get_coordinates(ring) for ring in shapely.get_rings(polygon)]


def shapes_in(path: Path, frame: LocalFrame) -> tuple[list[tuple[str, Any]], list[Unread]]:
    """Return areas and lines by place, and the rest."""
    about = MapWindow.of(frame)
    features = read_features(path, about)
    outlines, near = to_plane([feature.shape for feature in features], frame, about)
    about.expect_near(path)
    found = list[tuple[str, Any]]()
    unread = list[Unread]()
    for feature, outline, is_near in zip(features, outlines, near, strict=True):
        missing = feature.missing
        if missing is not None and not missing.elsewhere:
            words = f"expected an area that can be read, not {missing.words}"
            raise BadInput(words, missing.remedy, place=feature.place)
        shapes = [outline_of(part, feature.tags) for part in simple_parts(outline)]
        points = [shape for shape in shapes if shape.geom_type == "Point"]
        if points or not shapes:
            why = why_no_area(points, feature.tags) if is_near else FAR_FROM_HOME
            if why.may_be_obstacle:
                raise BadInput(f"expected an area, not {why.words}", why.remedy, place=feature.place)
            unread.append(Unread(path.name, why.words, feature.place.removeprefix(f"{path}: ")))
        found += [(f"{feature.place}.geometry", shape) for shape in shapes if shape.geom_type != "Point"]
    return found, unread


def corridor(line: Plane, width: float, place: str) -> Any:
    if not np.isfinite(line).all() or (np.diff(line, axis=0) == 0.0).all(axis=1).any():
        raise InvalidRing("expected a line without repeated corners", place=place)
    shape = shapely.LineString(line).buffer(width / 2, cap_style="flat", join_style="mitre", mitre_limit=2.0)
    if shape.geom_type != "Polygon" or shape.area < LEAST_M2:
        raise InvalidRing("expected a line whose corridor is one polygon", place=place)
    return shape
