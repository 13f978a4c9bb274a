from collections.abc import Callable, MutableMapping
from typing import Any, TypeAlias

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.studio.requests import AreaChange, Corner, DrawArea, MapArea, OwnArea
from ipoa_mission.studio.vocabulary import LngLat, Path
from ipoa_mission.survey.survey_area import parts_of
from ipoa_mission.survey.survey_section import USUAL_HEIGHT, USUAL_SPACING

DIGITS = 2  # decimals of meters
DEGREES = 7  # decimals of degrees
LEAST_CORNERS = {"polygon": 3, "line": 2}
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
            place = old.geodetic(moved)
            moved = new.local(Geodetic(place.latitude_deg, place.longitude_deg, new.home.altitude))
        return round(float(moved[0]), DIGITS), round(float(moved[1]), DIGITS)

    def geodetic(latitude: float, longitude: float) -> tuple[float, float]:
        east, north, _ = old.local(Geodetic(float(latitude), float(longitude), old.home.altitude))
        place = old.geodetic(np.array([east + step[0], north + step[1], 0.0]))
        return round(place.latitude_deg, DEGREES), round(place.longitude_deg, DEGREES)

    return local, geodetic


def is_of_area(path: Path) -> bool:
    return len(path) > 1 and path[0] == "survey" and path[1] in LEAST_CORNERS


def areas_of(polygon: Any) -> list[list[Any]]:
    """Return the areas of `survey.polygon` as open rings, the outer one first."""
    return [[_opened(ring) for ring in rings] for rings in parts_of(polygon)]


def _opened(ring: Any) -> Any:
    return ring[:-1] if len(ring) > 3 and list(ring[0]) == list(ring[-1]) else ring


def write_in_full(document: MutableMapping[str, Any]) -> None:
    """Write the polygon as areas of open rings, so that a path has numbers of area, ring and corner."""
    survey = document.get("survey", {})
    if "polygon" in survey:
        areas = areas_of(survey["polygon"])
        if areas != survey["polygon"]:  # else its bytes stay
            survey["polygon"] = areas


def change_area(document: MutableMapping[str, Any], change: AreaChange, frame: LocalFrame) -> None:
    write_in_full(document)
    match change:
        case DrawArea():
            _draw(document, change, frame)
        case OwnArea():
            areas = [[[local_of(frame, place) for place in ring] for ring in rings] for rings in change.parts]
            _set_shape(document, "polygon", areas)
        case MapArea():
            _set_shape(document, "area", change.file)
        case Corner(op="put_corner"):
            corner = at_path(document, change.path)
            corner[0], corner[1] = local_of(frame, change.place)
        case Corner():
            at_path(document, change.path[:-1]).insert(int(change.path[-1]), local_of(frame, change.place))


def take_of_area(document: MutableMapping[str, Any], path: Path) -> None:
    """Remove a corner, a hole, or with its outer ring an area. Raises InvalidRing if nothing is left."""
    write_in_full(document)
    items = at_path(document, path[:-1])
    last = path[-1]
    if len(path) == (3 if path[1] == "line" else 5):
        least = LEAST_CORNERS[str(path[1])]
        if len(items) <= least:
            raise InvalidRing(f"expected {least} corners or more", hint="remove the whole area")
    else:
        if last == 0:
            items = at_path(document, path[:-2])
            last = path[-2]
        if len(path) != 4 or len(items) < 2:
            raise InvalidRing("expected some area to be left", hint="remove the survey")
    del items[last]


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


def _draw(document: MutableMapping[str, Any], change: DrawArea, frame: LocalFrame) -> None:
    ring = [local_of(frame, place) for place in change.ring]
    areas = document.get("survey", {}).get("polygon")
    if change.what == "corridor":
        _set_shape(document, "line", ring)
        document["survey"]["width"] = 40.0  # [m]
    elif change.what == "hole":
        _area_around(shapely.Point(ring[0]), document, areas or ()).append(ring)
    elif areas is None:
        _set_shape(document, "polygon", [[ring]])
    else:
        areas.append([ring])


def _area_around(point: Any, document: Any, areas: Any) -> Any:
    for rings in areas:
        if shapely.Polygon(rings[0]).buffer(0.0).intersects(point):
            return rings
    hint = "draw an area first" if "survey" not in document else "an area of a map can be changed after: Edit it here"
    raise BadInput("expected a place inside an area that this scenario draws", hint=hint, place="hole")


def _set_shape(document: MutableMapping[str, Any], key: str, shape: Any) -> None:
    """Replace the survey's shape; add a survey from home to home if there is none."""
    if "survey" not in document:
        for place in ("start", "goal", "via"):
            document.pop(place, None)
        document["survey"] = {key: shape, "line_spacing": USUAL_SPACING, "height_above_ground": USUAL_HEIGHT}
        return
    for replaced in {"polygon", "line", "area", "width"} - {key}:
        document["survey"].pop(replaced, None)
    document["survey"][key] = shape
