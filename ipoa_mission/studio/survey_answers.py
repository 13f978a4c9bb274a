"""What the server tells the page of a survey: its area, and the lines over it with what they see."""

from typing import Literal, TypeAlias

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage, Path

#: Polygons as rings, the outer one first.
Polygons: TypeAlias = tuple[tuple[tuple[LngLat, ...], ...], ...]


class AreaRing(PageMessage):
    """A ring of the area, open, or the middle of a corridor; `path` where the scenario itself draws it."""

    name: str
    path: Path | None
    what: Literal["outer", "hole", "line"]
    places: tuple[LngLat, ...]


class SurveyArea(PageMessage):
    """What a survey is to see, as the file has it, even where that makes no sense yet; no rings without a survey.

    `cameras` are those that are known by name.
    """

    kind: Literal["area"] = "area"
    revision: int
    rings: tuple[AreaRing, ...]
    cameras: tuple[str, ...]


class SurveyLine(PageMessage):
    """A line that is flown with the sensor on, in which flight from 0 on, how high its ends, where it takes photos."""

    flight: int
    begin: LngLat
    end: LngLat
    up: tuple[float, float]
    photos: tuple[LngLat, ...]


class LeastOverlap(PageMessage):
    """The smallest share of a photo that another one shows too, and where it is taken."""

    share: float
    place: LngLat


class SurveyLayout(PageMessage):
    """Lines, the ways between them, and what they see: `share` of what can be seen, `gaps` where it is not.

    `height` is least and most above the highest ground that is seen, `footprint` what a photo shows across and along
    the way, or how wide the sensor sees; `trigger` is how far photos are apart at most. `kept_out` is where lines may
    not lie. `front` and `side` are the smallest overlaps with the next photo, and with those of the next line.
    `starts` are the places from which flights may begin in place of home. `short` says in words where photos overlap
    less than was asked. `degrees` is the direction of the longest line.
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
    """Lines as they are laid at once: no flight flies them yet, nothing is proved; never the last word.

    `seconds` is about how long they take, without take-off, the ways there and home, and landing. `number` is that of
    the drag it answers, or None for the document.
    """

    kind: Literal["coarse_survey"] = "coarse_survey"
    revision: int
    number: int | None
    layout: SurveyLayout
    seconds: float
    took_s: float
