"""Collect what a map's reader passes over or leaves unread."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import shapely

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.feature import Feature, Missing
from ipoa_mission.maps.kinds import Reason
from ipoa_mission.maps.planar import to_plane
from ipoa_mission.unread import Unread

MOST_NAMED = 3
NOT_UNDERSTOOD = "map-not-understood"
NOT_READ = "not-read"
FAR_FROM_HOME = Reason("more than 100 km from home", False)


@dataclass(frozen=True, eq=False, slots=True)
class PassedOver:
    """`shape`: east, north [m], or empty; `may_be_obstacle`: a possible obstacle; `remedy`: how to settle it.

    `heights`: keys under [[maps]] that give it a height. Code `not-read` may mean a higher obstacle.
    """

    file: str
    name: str
    reason: str
    shape: Any
    may_be_obstacle: bool
    remedy: str = ""
    code: str = NOT_UNDERSTOOD
    heights: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class PassedCount:
    """A map's features passed over for one reason; `names` of the first."""

    file: str
    reason: str
    may_be_obstacle: bool
    count: int
    names: tuple[str, ...]
    code: str = NOT_UNDERSTOOD

    def words(self) -> str:
        dots = ", ..." if self.count > len(self.names) else ""
        how = "not read" if self.code == NOT_READ else "passed over"
        return f"{self.file}: {self.count} {how}, {self.reason}: {', '.join(self.names)}{dots}"


class MapNotes:
    def __init__(self, frame: LocalFrame, path: Path) -> None:
        self.passed_over = list[PassedOver]()
        self.unread = list[Unread]()
        self.remarks = list[str]()
        self.frame = frame
        self.path = path

    def pass_over(self, feature: Feature, shape: Any, why: Reason, code: str = NOT_UNDERSTOOD) -> None:
        name = self._within_file(feature.name)
        thing = PassedOver(self.path.name, name, why.words, shape, why.may_be_obstacle, why.remedy, code, why.heights)
        self.passed_over.append(thing)

    def note(self, feature: Feature, subject: str, example: str, may_limit: bool = False) -> None:
        place = self._within_file(feature.name)
        self.unread.append(Unread(self.path.name, subject, place, example, may_limit=may_limit))

    def add_missing(self, feature: Feature) -> bool:
        """Add the unread part of a feature; return whether it may be near."""
        if feature.missing is None and not shapely.is_empty(feature.shape):
            return False
        remedy = "give it a geometry in the map, or take it out"
        missing = feature.missing or Missing("without a geometry", feature.shape, remedy)
        if missing.elsewhere:
            return False
        if shapely.is_empty(missing.shape):
            name = self._within_file(feature.name)
            place = self._within_file(feature.place)
            example = "" if name == place else name
            unread = Unread(self.path.name, missing.words, place, example, may_limit=True, remedy=missing.remedy)
            self.unread.append(unread)
            return True
        (shape,), (is_near,) = to_plane([missing.shape], self.frame)
        if is_near:
            self.pass_over(feature, shape, Reason(missing.words, True, missing.remedy), NOT_READ)
        return bool(is_near)

    def _within_file(self, place: str) -> str:
        return place.removeprefix(f"{self.path}: ")


def count_passed_over(things: Iterable[PassedOver]) -> Iterator[PassedCount]:
    def kind(thing: PassedOver) -> tuple[bool, str, str]:
        return not thing.may_be_obstacle, thing.file, thing.reason

    for _, group in groupby(sorted(things, key=kind), key=kind):
        first, *_ = several = list(group)
        names = tuple(thing.name for thing in several[:MOST_NAMED])
        yield PassedCount(first.file, first.reason, first.may_be_obstacle, len(several), names, first.code)
