import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import shapely

from ipoa_mission import Scenario, Survey
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.studio import answers
from ipoa_mission.studio.area_edits import areas_of
from ipoa_mission.studio.edits import frame_of
from ipoa_mission.studio.plan_answers import expected
from ipoa_mission.studio.view import on_map, rings_of, without_folders
from ipoa_mission.studio.vocabulary import renamed
from ipoa_mission.survey.camera import CAMERAS
from ipoa_mission.survey.flown_coverage import Overlap, Overlaps, lines_of_tour, photo_places, smallest_overlaps
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.survey_area import depth_of
from ipoa_mission.survey.survey_plan import SurveyPlan
from ipoa_mission.survey.survey_section import SurveySection, surveyed_area
from ipoa_mission.survey.survey_task import SurveySketch
from ipoa_mission.survey.tour import Tour


def area_of(table: Mapping[str, Any], scenario: Scenario | None) -> answers.SurveyArea:
    """Return the drawn area, valid or not; that of a map only if valid."""
    rings = list[answers.AreaRing]()
    with suppress(KeyError, TypeError, ValueError, IndexError):
        survey = table["survey"]
        frame = frame_of(dict(table))
        if "line" in survey:
            places = _places(survey["line"], frame)
            rings.append(answers.AreaRing(name="corridor", path=("survey", "line"), what="line", places=places))
        rings += _rings(areas_of(survey.get("polygon", [])), frame, is_drawn=True)
    area = None if rings or scenario is None else surveyed_area(scenario)
    if scenario is not None and area is not None:
        parts = ((part.exterior, *part.interiors) for part in shapely.get_parts(area.shape))
        areas = [[shapely.get_coordinates(ring)[:-1] for ring in rings_of_part] for rings_of_part in parts]
        rings = _rings(areas, scenario.frame, is_drawn=False)
    return answers.SurveyArea(rings=tuple(rings), cameras=tuple(CAMERAS))


def _rings(areas: list[list[Any]], frame: LocalFrame, is_drawn: bool) -> list[answers.AreaRing]:
    return [
        answers.AreaRing(
            name=ring_name(n, m, len(areas)),
            path=("survey", "polygon", n, m) if is_drawn else None,
            what="hole" if m else "outer",
            places=_places(ring, frame),
        )
        for n, rings in enumerate(areas)
        for m, ring in enumerate(rings)
    ]


def _places(corners: Any, frame: LocalFrame) -> Any:
    return on_map(frame, np.array(corners, float).reshape(-1, 2))


def ring_name(area: int, ring: int, areas: int) -> str:
    name = "area" if areas == 1 else f"area {area + 1}"
    return name if ring == 0 else f"hole {ring}" + (f" of {name}" if areas > 1 else "")


def numbers_in_full(numbers: Sequence[int], polygon: Any) -> list[int]:
    """Return area, ring and corner numbers of indices in `survey.polygon` as written."""
    return [*[0] * min(4 - depth_of(polygon), 2), *numbers]


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

    def name(numbers: list[int]) -> str:
        numbers = numbers_in_full(numbers, polygon)
        area, ring = (*numbers, 0, 0)[:2]
        areas = len(polygon) if depth_of(polygon) == 4 else 1
        return ring_name(area, ring, areas) + "".join(f", corner {n + 1}" for n in numbers[2:3])

    labels = {"gsd_cm": "ground sampling distance", "direction_deg": "direction", "area": "the area's map"}
    for key in sorted(SurveySection.model_fields.keys() - {"polygon", "line"}, key=len, reverse=True):
        message = message.replace(f"survey.{key}", labels.get(key, key.replace("_", " ")))
    message = renamed(message, "survey.line", lambda n: "corridor" + "".join(f", corner {k + 1}" for k in n[:1]))
    return renamed(message, "survey.polygon", name)


def coarse_survey(sketch: SurveySketch, scenario: Scenario, number: int | None) -> answers.CoarseSurvey:
    ground = scenario.airspace.ground
    free = sketch.area.without(sketch.keep_out)
    lines = [*lines_of_tour(sketch.tour, sketch.sight, ground)]
    overlaps = smallest_overlaps(lines, sketch.sight, ground, free) if lines else None
    return answers.CoarseSurvey(
        number=number, layout=_layout(scenario, sketch, (sketch.tour,), overlaps), seconds=round(sketch.seconds, 1)
    )


def planned_survey(survey: Survey, proofs: Sequence[str], flown: Sequence[FilePath]) -> answers.PlannedSurvey:
    plan = survey.plan
    parts = []
    remarks = tuple(without_folders(words, plan.scenario) for words in survey.notes)
    for name, flight, proof in zip(survey.names, plan.flights, proofs, strict=True):
        warned = tuple(without_folders(finding.message, plan.scenario) for finding in flight.findings)
        proved = {"of": "scenario", "proof": proof, "warnings": warned, "remarks": remarks}
        parts.append(
            answers.SurveyPart(
                file=f"{name}.plan",
                lines=len(flight.tour.swaths),
                photos=plan.sight.photos_of(flight.tour),
                plan=expected(flight.forecast, name).model_copy(update=proved),
            )
        )
    energy = [part.plan.energy_wh for part in parts if part.plan.energy_wh is not None]
    tours = tuple(flight.tour for flight in plan.flights)
    return answers.PlannedSurvey(
        layout=_layout(plan.scenario, plan, tours, plan.overlaps),
        flights=tuple(parts),
        flown=tuple(log.name for log in flown),
        total_s=round(survey.total_s, 2),
        energy_wh=round(sum(energy), 2) if len(energy) == len(parts) else None,
    )


def _layout(
    scenario: Scenario, laid: SurveySketch | SurveyPlan, tours: Sequence[Tour], overlaps: Overlaps | None
) -> answers.SurveyLayout:
    frame = scenario.frame
    sight = laid.sight
    coverage = laid.coverage
    swaths = [swath for tour in tours for swath in tour.swaths]
    around = laid.area.shape.buffer(sight.spacing)
    kept_out = shapely.Polygon() if laid.keep_out is None else laid.keep_out.intersection(around)
    longest = max(swaths, key=lambda swath: swath.length)
    east, north = longest.end - longest.begin
    gaps = [part for part in shapely.get_parts(coverage.gaps) if part.area > 0.01]  # [m^2], else of rounding
    front, side = (None, None) if overlaps is None else (overlaps.front, overlaps.side)
    return answers.SurveyLayout(
        lines=tuple(_lines(scenario, sight, tours)),
        ways=tuple(on_map(frame, way) for tour in tours for way in tour.transits if len(way) > 1),
        seen=_polygons(scenario, coverage.seen),
        gaps=tuple(rings_of(frame, part) for part in gaps if part.geom_type == "Polygon"),
        kept_out=_polygons(scenario, kept_out),
        share=coverage.share,
        gaps_m2=round(float(sum(part.area for part in gaps)), 2),
        area_m2=round(float(laid.area.shape.area), 1),
        spacing=round(sight.spacing, 2),
        trigger=None if sight.trigger is None else round(sight.trigger, 2),
        photos=sum(map(sight.photos_of, tours)),
        height=(round(sight.least, 2), round(sight.least + sight.band, 2)),
        footprint=(round(sight.across, 2), round(sight.along, 2)),
        front=None if front is None else _least(front, frame),
        side=None if side is None else _least(side, frame),
        short=() if overlaps is None else tuple(map(in_words, overlaps.falls_short(*sight.overlaps))),
        degrees=round(math.degrees(math.atan2(east, north)) % 180.0, 1) % 180.0,
    )


def _least(overlap: Overlap, frame: LocalFrame) -> answers.LeastOverlap:
    return answers.LeastOverlap(share=overlap.share, place=on_map(frame, np.array([overlap.at]))[0])


def _lines(scenario: Scenario, sight: Sight, tours: Sequence[Tour]) -> Iterator[answers.SurveyLine]:
    for n, tour in enumerate(tours):
        for swath in tour.swaths:
            places = np.vstack([swath.begin, swath.end, photo_places(swath, sight).reshape(-1, 2)])
            begin, end, *photos = on_map(scenario.frame, places)
            low, high = (scenario.airspace.ground(np.array([swath.begin, swath.end])) + sight.middle).round(1).tolist()
            yield answers.SurveyLine(flight=n, begin=begin, end=end, up=(low, high), photos=tuple(photos))


def _polygons(scenario: Scenario, shape: Any) -> answers.Polygons:
    simple = shapely.simplify(shape, tolerance=0.1)
    return tuple(rings_of(scenario.frame, part) for part in shapely.get_parts(simple) if part.geom_type == "Polygon")
