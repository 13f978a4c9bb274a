import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from ipoa_mission.scenario import Scenario
from ipoa_mission.studio import answers
from ipoa_mission.studio.area_view import in_words
from ipoa_mission.studio.handed import survey_over
from ipoa_mission.studio.plan_answers import expected
from ipoa_mission.studio.survey_answers import CoarseSurvey, LeastOverlap, Polygons, SurveyLayout, SurveyLine
from ipoa_mission.studio.view import on_map, without_folders
from ipoa_mission.survey.laying import SurveySketch
from ipoa_mission.survey.overlap import Overlap, Overlaps, laid_lines, photo_places, smallest_overlaps
from ipoa_mission.survey.sight import Sight
from ipoa_mission.survey.survey_flight import Survey
from ipoa_mission.survey.survey_plan import SurveyPlan
from ipoa_mission.survey.tour import Tour
from ipoa_mission.world.frame import LocalFrame

DRAWING_TOLERANCE = 0.1  # [m]
SHOWN_GAP = 0.01  # rounding [m^2]
ZONE_MARGIN = 1.0  # around the area, in line spacings


def coarse_survey(
    sketch: SurveySketch, scenario: Scenario, revision: int, number: int | None, took_s: float
) -> CoarseSurvey:
    sight, ground = sketch.sight, scenario.airspace.ground
    free = sketch.area.without(sketch.keep_out)
    lines = [*laid_lines(sketch.tour, sight, ground)]
    overlaps = smallest_overlaps(lines, sight, ground, free) if lines else None
    return CoarseSurvey(
        revision=revision,
        number=number,
        layout=_layout(scenario, sketch, (sketch.tour,), overlaps),
        seconds=round(sketch.seconds, 1),
        took_s=round(took_s, 3),
    )


def planned_survey(survey: Survey, revision: int, took_s: float, flown: Sequence[Path] = ()) -> answers.PlannedSurvey:
    plan, names = survey.plan, survey.names
    parts = []
    for n, flight in enumerate(plan.flights):
        own = survey_over(survey, n)
        warned = tuple(without_folders(finding.message, plan.scenario) for finding in flight.findings)
        shown = expected(flight.forecast, names[n], revision, took_s)
        proved = {"of": "scenario", "proof": own.proof, "warnings": warned, "remarks": _remarks(survey)}
        parts.append(
            answers.SurveyPart(
                file=f"{names[n]}.plan",
                lines=len(flight.tour.swaths),
                photos=plan.sight.photos_of(flight.tour),
                plan=shown.model_copy(update=proved),
            )
        )
    used = [part.plan.energy_wh for part in parts]
    energy = [one for one in used if one is not None]
    tours = tuple(flight.tour for flight in plan.flights)
    return answers.PlannedSurvey(
        revision=revision,
        layout=_layout(plan.scenario, plan, tours, plan.overlaps),
        flights=tuple(parts),
        flown=tuple(log.name for log in flown),
        total_s=round(survey.total_s, 2),
        energy_wh=round(sum(energy), 2) if len(energy) == len(used) else None,
        took_s=round(took_s, 2),
    )


def _remarks(survey: Survey) -> tuple[str, ...]:
    return tuple(without_folders(words, survey.plan.scenario) for words in survey.notes)


def _layout(
    scenario: Scenario, laid: SurveySketch | SurveyPlan, tours: Sequence[Tour], overlaps: Overlaps | None
) -> SurveyLayout:
    frame, shape, sight, coverage = scenario.frame, laid.area.shape, laid.sight, laid.coverage
    swaths = [swath for tour in tours for swath in tour.swaths]
    kept_out = (
        shapely.Polygon()
        if laid.keep_out is None
        else laid.keep_out.intersection(shape.buffer(ZONE_MARGIN * sight.spacing))
    )
    longest = max(swaths, key=lambda swath: swath.length)
    east, north = longest.end - longest.begin
    gaps = [part for part in shapely.get_parts(coverage.gaps) if part.area > SHOWN_GAP]
    front, side = (None, None) if overlaps is None else (overlaps.front, overlaps.side)
    starts = () if scenario.survey is None else scenario.survey.starts or ()
    return SurveyLayout(
        starts=on_map(frame, np.array(starts).reshape(-1, 2)),
        lines=tuple(_lines(scenario, sight, tours)),
        ways=tuple(on_map(frame, way) for tour in tours for way in tour.ways if len(way) > 1),
        seen=_polygons(scenario, coverage.seen),
        gaps=tuple(_polygon(scenario, part) for part in gaps if part.geom_type == "Polygon"),
        kept_out=_polygons(scenario, kept_out),
        share=coverage.share,
        gaps_m2=round(float(sum(part.area for part in gaps)), 2),
        area_m2=round(float(shape.area), 1),
        outside_m=round(coverage.outside_m, 2),
        spacing=round(sight.spacing, 2),
        trigger=None if sight.trigger is None else round(sight.trigger, 2),
        photos=sum(sight.photos(swath.length) for swath in swaths),
        height=(round(sight.least, 2), round(sight.least + sight.band, 2)),
        footprint=(round(sight.across, 2), round(sight.along, 2)),
        front=None if front is None else _least(front, frame),
        side=None if side is None else _least(side, frame),
        short=() if overlaps is None else tuple(map(in_words, overlaps.falls_short(*sight.overlaps))),
        degrees=round(math.degrees(math.atan2(east, north)) % 180.0, 1) % 180.0,
    )


def _least(overlap: Overlap, frame: LocalFrame) -> LeastOverlap:
    return LeastOverlap(share=overlap.share, place=on_map(frame, np.array([overlap.at]))[0])


def _lines(scenario: Scenario, sight: Sight, tours: Sequence[Tour]) -> Iterator[SurveyLine]:
    for n, tour in enumerate(tours):
        for swath in tour.swaths:
            begin, end, *photos = on_map(
                scenario.frame, np.vstack([swath.begin, swath.end, photo_places(swath, sight).reshape(-1, 2)])
            )
            low, high = (scenario.airspace.ground(np.array([swath.begin, swath.end])) + sight.middle).round(1).tolist()
            yield SurveyLine(flight=n, begin=begin, end=end, up=(low, high), photos=tuple(photos))


def _polygons(scenario: Scenario, shape: Any) -> Polygons:
    simple = shapely.simplify(shape, DRAWING_TOLERANCE)
    return tuple(_polygon(scenario, part) for part in shapely.get_parts(simple) if part.geom_type == "Polygon")


def _polygon(scenario: Scenario, part: Any) -> Any:
    return tuple(on_map(scenario.frame, shapely.get_coordinates(ring)) for ring in (part.exterior, *part.interiors))
