"""Changes of a survey's area in a scenario's text: drawn, its corners moved, added and taken out."""

from collections.abc import Iterator, MutableMapping
from typing import Any

import shapely
import tomlkit

from ipoa_mission.errors import BadInput, InvalidRing
from ipoa_mission.scenario.survey_section import USUAL_HEIGHT, USUAL_SPACING
from ipoa_mission.studio.moves import Move, local_of
from ipoa_mission.studio.requests import AddCorner, AreaChange, DrawArea, MapArea, OwnArea, PutCorner
from ipoa_mission.studio.vocabulary import Path
from ipoa_mission.world.frame import LocalFrame

WIDTH = 40.0  # of a corridor that is drawn, until it is given another [m]
LEAST_CORNERS = {"polygon": 3, "line": 2}
ELSEWHERE = ("start", "goal", "via")  # what a survey is flown in place of
SHAPES = ("polygon", "line", "area", "width")  # the keys that say where it is


def is_of_area(path: Path) -> bool:
    """Whether a path leads into what a survey's area is made of."""
    return len(path) > 1 and path[0] == "survey" and path[1] in LEAST_CORNERS


def parts_of(polygon: Any) -> Iterator[tuple[Path, Any]]:
    """The rings of `survey.polygon`, each with its path, however many brackets are written; the outer ones first."""
    depth = depth_of(polygon)
    if depth == 2:
        yield ("survey", "polygon"), polygon
    for n, one in enumerate(polygon if depth > 2 else ()):
        if depth == 3:
            yield ("survey", "polygon", n), one
        for m, ring in enumerate(one if depth == 4 else ()):
            yield ("survey", "polygon", n, m), ring


def depth_of(value: Any) -> int:
    """How many lists are in each other, at the first of each."""
    return 1 + (depth_of(value[0]) if len(value) else 0) if isinstance(value, list) else 0


def change_area(document: MutableMapping[str, Any], change: AreaChange, frame: LocalFrame) -> None:
    """Make a change of the area."""
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
            ring = _at(document, change.path[:-1])
            ring.insert(int(change.path[-1]), local_of(frame, change.place))


def take_of_area(document: MutableMapping[str, Any], path: Path) -> None:
    """Take out a corner, a hole, or one of several areas.

    Raises:
        BadInput: nothing would be left of it.
    """
    polygon = document["survey"].get("polygon")
    ring_paths = {ring_path for ring_path, _ in parts_of(polygon)} if polygon is not None else {("survey", "line")}
    if path[:-1] in ring_paths:
        ring, at, mate = _corner(document, path)
        if len(ring) - len(mate) <= LEAST_CORNERS[str(path[1])]:
            raise InvalidRing(f"expected {LEAST_CORNERS[str(path[1])]} corners or more", hint="take the whole area out")
        del ring[at]
        if mate:  # a ring that is written closed stays so
            ring[-1] = tomlkit.item(list(ring[0])) if at == 0 else ring[-1]
        return
    here, last = _at(document, path[:-1]), path[-1]
    if len(path) == 4 and last == 0:  # without its outline nothing is left of it
        here, last = _at(document, path[:-2]), path[-2]
    if len(path) < 3 or len(here) < 2 or (len(path) == 3 and last == 0 and path in ring_paths):
        raise InvalidRing("expected some area to be left", hint="take the survey out")
    del here[last]


def move_area(document: MutableMapping[str, Any], path: Path, move: Move) -> None:
    """Move a ring, or all that lies below a path."""
    _move_nested(_at(document, path), move)


def move_survey(survey: MutableMapping[str, Any], move: Move) -> None:
    """Move all of a survey that is given in metres from home."""
    for key in ("polygon", "line", "entry", "exit", "starts"):
        if key in survey:
            _move_nested(survey[key], move)


def _move_nested(value: Any, move: Move) -> None:
    if len(value) and not isinstance(value[0], list):
        value[0], value[1] = move(value[0], value[1])
        return
    for one in value:
        _move_nested(one, move)


def _at(document: Any, path: Path) -> Any:
    for step in path:
        document = document[step]
    return document


def _corner(document: Any, path: Path) -> tuple[Any, int, tuple[int, ...]]:
    """The ring of a corner, its number, and that of the same place where the ring is written closed."""
    ring, at = _at(document, path[:-1]), int(path[-1])
    is_closed = path[1] == "polygon" and len(ring) > 3 and list(ring[0]) == list(ring[-1])
    return ring, at, ((len(ring) - 1,) if at == 0 else (0,) if at == len(ring) - 1 else ()) if is_closed else ()


def _draw(document: MutableMapping[str, Any], change: DrawArea, frame: LocalFrame) -> None:
    ring = [local_of(frame, place) for place in change.ring]
    polygon = document.get("survey", {}).get("polygon")
    if change.what == "corridor":
        _shaped(document, "line", ring)
        document["survey"]["width"] = WIDTH
    elif change.what == "hole":
        _put_hole(document, ring)
    elif polygon is None:
        _shaped(document, "polygon", [ring])
    else:
        document["survey"]["polygon"] = [*_parts(polygon), [ring]]


def _parts(polygon: Any) -> list[Any]:
    depth = depth_of(polygon)
    return [[polygon]] if depth == 2 else [polygon] if depth == 3 else list(polygon)


def _put_hole(document: MutableMapping[str, Any], ring: list[list[float]]) -> None:
    polygon = document.get("survey", {}).get("polygon")
    parts = [] if polygon is None else _parts(polygon)
    for n, rings in enumerate(parts):
        if shapely.Polygon(rings[0]).buffer(0.0).intersects(shapely.Point(ring[0])):
            if depth_of(polygon) == 2:
                document["survey"]["polygon"] = [polygon, ring]
            else:
                (polygon if depth_of(polygon) == 3 else polygon[n]).append(ring)
            return
    hint = "draw an area first" if "survey" not in document else "one of a map is drawn here first: Edit it here"
    raise BadInput("expected in an area that this scenario draws", hint=hint, place="hole")


def _shaped(document: MutableMapping[str, Any], key: str, shape: Any) -> None:
    """The survey is of this shape and no other; without one there is one from now on, from home to home."""
    if "survey" not in document:
        for other in ELSEWHERE:
            document.pop(other, None)
        document["survey"] = {key: shape, "line_spacing": USUAL_SPACING, "height_above_ground": USUAL_HEIGHT}
        return
    survey = document["survey"]
    for other in SHAPES:
        if other != key:
            survey.pop(other, None)
    survey[key] = shape
