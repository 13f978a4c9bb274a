from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import shapely

from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.camera import CAMERAS
from ipoa_mission.scenario.survey_section import SurveySection
from ipoa_mission.studio.area_edits import depth_of, parts_of
from ipoa_mission.studio.edits import frame_of
from ipoa_mission.studio.survey_answers import AreaRing, SurveyArea
from ipoa_mission.studio.view import on_map
from ipoa_mission.studio.vocabulary import Path, renamed
from ipoa_mission.world.frame import LocalFrame

CORRIDOR = "corridor"
LABELS = {"gsd_cm": "ground sampling distance", "direction_deg": "direction", "area": "the area's map"}


def area_of(table: Mapping[str, Any], scenario: Scenario | None, revision: int) -> SurveyArea:
    """Return a scenario's drawn area, valid or not; an area of a map only if valid."""
    rings = list[AreaRing]()
    with suppress(KeyError, TypeError, ValueError, IndexError):
        rings = list(_drawn(table["survey"], frame_of(dict(table))))
    if not rings and scenario is not None and scenario.survey_area is not None:
        rings = list(_mapped(scenario))
    return SurveyArea(revision=revision, rings=tuple(rings), cameras=tuple(CAMERAS))


def _drawn(survey: Mapping[str, Any], frame: LocalFrame) -> Iterator[AreaRing]:
    if "line" in survey:
        yield AreaRing(name=CORRIDOR, path=("survey", "line"), what="line", places=_places(survey["line"], frame))
    polygon = survey.get("polygon", [])
    for path, ring in parts_of(polygon):
        is_hole = len(path) > 2 and path[-1] != 0
        corners = ring[:-1] if len(ring) > 3 and list(ring[0]) == list(ring[-1]) else ring
        places = _places(corners, frame)
        yield AreaRing(name=ring_name(path, polygon), path=path, what="hole" if is_hole else "outer", places=places)


def _mapped(scenario: Scenario) -> Iterator[AreaRing]:
    assert scenario.survey_area is not None
    parts = shapely.get_parts(scenario.survey_area.shape)
    for n, part in enumerate(parts):
        for m, ring in enumerate((part.exterior, *part.interiors)):
            name = _name(n, m, len(parts))
            places = on_map(scenario.frame, shapely.get_coordinates(ring)[:-1])
            yield AreaRing(name=name, path=None, what="hole" if m else "outer", places=places)


def _places(corners: Any, frame: LocalFrame) -> Any:
    return on_map(frame, np.array(corners, float).reshape(-1, 2))


def ring_name(path: Path, polygon: Any) -> str:
    numbers = [int(step) for step in path[2:]]
    part, ring = numbers if len(numbers) == 2 else (0, *numbers) if numbers else (0, 0)
    return _name(part, ring, len(polygon) if depth_of(polygon) == 4 else 1)


def _name(part: int, ring: int, parts: int) -> str:
    area = "area" if parts == 1 else f"area {part + 1}"
    return area if ring == 0 else f"hole {ring}" + (f" of {area}" if parts > 1 else "")


def in_words(message: str, table: Mapping[str, Any] | None = None) -> str:
    """Replace paths by their labels on the page.

    >>> field = [[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]], [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]]
    >>> in_words("survey.polygon[1][2]: expected a number", {"survey": {"polygon": field}})
    'hole 1, corner 3: expected a number'
    >>> in_words("survey.gsd_cm: expected more than 0")
    'ground sampling distance: expected more than 0'
    """
    survey = (table or {}).get("survey")
    polygon = survey.get("polygon", []) if isinstance(survey, Mapping) else []
    deep = max(depth_of(polygon) - 2, 0)

    def name(numbers: list[int]) -> str:
        ring, corner = numbers[:deep], numbers[deep : deep + 1]
        path: Path = ("survey", "polygon", *ring, *([0] * (deep - len(ring))))
        return ring_name(path, polygon) + "".join(f", corner {n + 1}" for n in corner)

    for key in sorted(SurveySection.model_fields.keys() - {"polygon", "line"}, key=len, reverse=True):
        message = message.replace(f"survey.{key}", LABELS.get(key, key.replace("_", " ")))
    message = renamed(message, "survey.line", lambda n: CORRIDOR + "".join(f", corner {one + 1}" for one in n[:1]))
    return renamed(message, "survey.polygon", name)
