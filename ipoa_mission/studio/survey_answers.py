from typing import Literal, TypeAlias

from ipoa_mission.studio.vocabulary import LngLat, Number, OfRevision, PageMessage, Path

#: rings, the outer one first
Polygons: TypeAlias = tuple[tuple[tuple[LngLat, ...], ...], ...]


class AreaRing(PageMessage):
    """An open ring of the area, or a corridor's middle line; `path` if the scenario draws it."""

    name: str
    path: Path | None
    what: Literal["outer", "hole", "line"]
    places: tuple[LngLat, ...]


class SurveyArea(OfRevision, kind="area"):
    """The area as in the file, valid or not; no rings without a survey."""

    rings: tuple[AreaRing, ...]
    cameras: tuple[str, ...]


class SurveyLine(PageMessage):
    """A line: its flight (from 0), heights of its ends, photos."""

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

    `height`: least and most above the highest ground seen. `footprint`: of a photo across and along, or the sensor's
    width. `trigger`: largest distance of photos. `front` and `side`: smallest overlaps. `starts`: alternatives to home.
    `short`: photos with too little overlap, in words. `degrees`: of the longest line.
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
    spacing: float
    trigger: Number
    photos: int
    height: tuple[float, float]
    footprint: tuple[float, float]
    front: LeastOverlap | None
    side: LeastOverlap | None
    short: tuple[str, ...]
    degrees: float


class CoarseSurvey(OfRevision, kind="coarse_survey"):
    """Unproved lines; `seconds` without take-off, transit and landing; `number` of the drag it answers."""

    number: int | None
    layout: SurveyLayout
    seconds: float
