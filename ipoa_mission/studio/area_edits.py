"""Change the survey's area in a scenario's table."""

from collections.abc import Callable, Iterator, MutableMapping
from typing import Any, TypeAlias

import numpy as np
import shapely
import tomlkit

from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.studio.requests import AddCorner, AreaChange, DrawArea, MapArea, OwnArea, PutCorner
from ipoa_mission.studio.vocabulary import LngLat, Path
from ipoa_mission.survey.survey_area import depth_of, parts_of
from ipoa_mission.survey.survey_section import USUAL_HEIGHT, USUAL_SPACING

DIGITS, DEGREES = 2, 7  # decimals of meters and of degrees
#: [east, north] or [latitude, longitude]
Move: TypeAlias = Callable[[float, float], tuple[float, float]]


def local_of(frame: LocalFrame, place: LngLat) -> list[float]:
    """Return east and north, to the centimeter [m]."""
    east, north = frame.local(Geodetic(place[1], place[0], frame.home.altitude))[:2].round(DIGITS).tolist()
    return [east + 0.0, north + 0.0]  # never -0.0


def moves_of(old: LocalFrame, new: LocalFrame, step: Any) -> tuple[Move, Move]:
    """Return how [east, north] and [latitude, longitude] move by `step` (2,) [m] into another frame."""

    def local(east: float, north: float) -> tuple[float, float]:
        moved = np.array([float(east) + step[0], float(north) + step[1], 0.0])
        if new is not old:
            there = old.geodetic(moved)
            moved = new.local(Geodetic(there.latitude_deg, there.longitude_deg, new.home.altitude))
        return round(float(moved[0]), DIGITS), round(float(moved[1]), DIGITS)

    def geodetic(latitude: float, longitude: float) -> tuple[float, float]:
        east, north, _ = old.local(Geodetic(float(latitude), float(longitude), old.home.altitude))
        there = old.geodetic(np.array([east + step[0], north + step[1], 0.0]))
        return round(there.latitude_deg, DEGREES), round(there.longitude_deg, DEGREES)

    return local, geodetic


LEAST_CORNERS = {"polygon": 3, "line": 2}


def is_of_area(path: Path) -> bool:
    return len(path) > 1 and path[0] == "survey" and path[1] in LEAST_CORNERS


def rings_in(polygon: Any) -> Iterator[tuple[Path, Any]]:
    """Yield the rings of `survey.polygon` with their paths, at any depth, outer ring first."""
    depth = depth_of(polygon)
    if depth == 2:
        yield ("survey", "polygon"), polygon
    for n, part in enumerate(polygon if depth > 2 else ()):
        if depth == 3:
            yield ("survey", "polygon", n), part
        yield from ((("survey", "polygon", n, m), ring) for m, ring in enumerate(part if depth == 4 else ()))


def change_area(document: MutableMapping[str, Any], change: AreaChange, frame: LocalFrame) -> None:
    match change:
        case DrawArea():
            _draw(document, change, frame)
        case OwnArea():
            parts = [[[local_of(frame, at) for at in ring] for ring in rings] for rings in change.parts]
            _shaped(document, "polygon", parts if len(parts) > 1 else parts[0])
        case MapArea():
            _shaped(document, "area", change.file)
        case PutCorner():
            ring, at, mate = _corner(document, change.path)
            for n in (at, *mate):
                ring[n][0], ring[n][1] = local_of(frame, change.place)
        case AddCorner():
            at_path(document, change.path[:-1]).insert(int(change.path[-1]), local_of(frame, change.place))


def take_of_area(document: MutableMapping[str, Any], path: Path) -> None:
    """Remove a corner, a hole, or an area. Raises BadInput if nothing is left."""
    polygon = document["survey"].get("polygon")
    ring_paths = {ring_path for ring_path, _ in rings_in(polygon)} if polygon is not None else {("survey", "line")}
    if path[:-1] in ring_paths:
        ring, at, mate = _corner(document, path)
        if len(ring) - len(mate) <= LEAST_CORNERS[str(path[1])]:
            raise InvalidRing(f"expected {LEAST_CORNERS[str(path[1])]} corners or more", hint="remove the whole area")
        del ring[at]
        if mate:  # a closed ring remains closed
            ring[-1] = tomlkit.item(list(ring[0])) if at == 0 else ring[-1]
        return
    here, last = at_path(document, path[:-1]), path[-1]
    if len(path) == 4 and last == 0:
        here, last = at_path(document, path[:-2]), path[-2]
    if len(path) < 3 or len(here) < 2 or (len(path) == 3 and last == 0 and path in ring_paths):
        raise InvalidRing("expected some area to be left", hint="remove the survey")
    del here[last]


def move_nested(value: Any, move: Move) -> None:
    if len(value) and not isinstance(value[0], list):
        value[0], value[1] = move(value[0], value[1])
    else:
        for part in value:
            move_nested(part, move)


def at_path(document: Any, path: Path) -> Any:
    for step in path:
        document = document[step]
    return document


def _corner(document: Any, path: Path) -> tuple[Any, int, tuple[int, ...]]:
    """Return a corner's ring, its index, and that of its duplicate in a closed ring."""
    ring, at = at_path(document, path[:-1]), int(path[-1])
    is_closed = path[1] == "polygon" and len(ring) > 3 and list(ring[0]) == list(ring[-1])
    return ring, at, ((len(ring) - 1,) if at == 0 else (0,) if at == len(ring) - 1 else ()) if is_closed else ()


def _draw(document: MutableMapping[str, Any], change: DrawArea, frame: LocalFrame) -> None:
    ring = [local_of(frame, place) for place in change.ring]
    polygon = document.get("survey", {}).get("polygon")
    if change.what == "corridor":
        _shaped(document, "line", ring)
        document["survey"]["width"] = 40.0  # [m]
    elif change.what == "hole":
        _put_hole(document, polygon, ring)
    elif polygon is None:
        _shaped(document, "polygon", [ring])
    else:
        document["survey"]["polygon"] = [*parts_of(polygon), [ring]]


def _put_hole(document: MutableMapping[str, Any], polygon: Any, ring: list[list[float]]) -> None:
    for n, rings in enumerate([] if polygon is None else parts_of(polygon)):
        if shapely.Polygon(rings[0]).buffer(0.0).intersects(shapely.Point(ring[0])):
            if depth_of(polygon) == 2:
                document["survey"]["polygon"] = [polygon, ring]
            else:
                (polygon if depth_of(polygon) == 3 else polygon[n]).append(ring)
            return
    hint = "draw an area first" if "survey" not in document else "an area of a map can be changed after: Edit it here"
    raise BadInput("expected a place inside an area that this scenario draws", hint=hint, place="hole")


def _shaped(document: MutableMapping[str, Any], key: str, shape: Any) -> None:
    """Replace the survey's shape; add a survey from home to home if there is none."""
    if "survey" not in document:
        for other in ("start", "goal", "via"):
            document.pop(other, None)
        document["survey"] = {key: shape, "line_spacing": USUAL_SPACING, "height_above_ground": USUAL_HEIGHT}
        return
    for other in {"polygon", "line", "area", "width"} - {key}:
        document["survey"].pop(other, None)
    document["survey"][key] = shape
