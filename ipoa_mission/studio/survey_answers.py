"""Define the server's messages on a survey: its area, its lines and their coverage."""

from typing import Literal, TypeAlias

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage, Path

#: Polygons as rings, the outer one first.
Polygons: TypeAlias = tuple[tuple[tuple[LngLat, ...], ...], ...]


class AreaRing(PageMessage):
    """An open ring of the area, or the middle line of a corridor; `path` if the scenario draws it."""

    name: str
    path: Path | None
    what: Literal["outer", "hole", "line"]
    places: tuple[LngLat, ...]


class SurveyArea(PageMessage):
    """The survey's area as in the file, valid or not; no rings without a survey.

    `cameras` are the names of the known ones.
    """

    kind: Literal["area"] = "area"
    revision: int
    rings: tuple[AreaRing, ...]
    cameras: tuple[str, ...]


class SurveyLine(PageMessage):
    """A line flown with the sensor on: its flight (from 0), the heights of its ends, and its photos."""

    flight: int
    begin: LngLat
    end: LngLat
    up: tuple[float, float]
    photos: tuple[LngLat, ...]


class LeastOverlap(PageMessage):
    share: float
    place: LngLat


class SurveyLayout(PageMessage):
    """Lines, connections and coverage: `share` of the visible area that is seen, and its `gaps`.

    `height`: least and most above the highest ground seen. `footprint`: size of a photo across and along the line, or
    the sensor's width. `trigger`: largest distance of photos. `kept_out`: no lines here. `front` and `side`: smallest
    overlaps with the next photo and the next line. `starts`: alternatives to home. `short`: photos with less overlap
    than required, in words. `degrees`: direction of the longest line.
    """

    starts: tuple[LngLat, ...]
    lines: tuple[SurveyLine, ...]
    ways: tuple[tuple[LngLat, ...], ...]
    seen: Polygons
    gaps: Polygons
    kept_out: Polygons
    share: float
    gaps_m2: float
    area_m2: float
    outside_m: float
    spacing: float
    trigger: Number
    photos: int
    height: tuple[float, float]
    footprint: tuple[float, float]
    front: LeastOverlap | None
    side: LeastOverlap | None
    short: tuple[str, ...]
    degrees: float


class CoarseSurvey(PageMessage):
    """Lines before their flights are planned: nothing is proved yet.

    `seconds`: approximate duration without take-off, transit and landing. `number` is that of the drag it answers, or
    None for the document.
    """

    kind: Literal["coarse_survey"] = "coarse_survey"
    revision: int
    number: int | None
    layout: SurveyLayout
    seconds: float
    took_s: float
