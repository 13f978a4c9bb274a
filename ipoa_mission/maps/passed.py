"""Describe map features that are no obstacle, or may be one."""

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
NOT_UNDERSTOOD, NOT_READ = "map-not-understood", "not-read"
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


def passed_over(feature: Feature, shape: Any, why: Reason, path: Path) -> PassedOver:
    name = feature.name.removeprefix(f"{path}: ")
    return PassedOver(path.name, name, why.words, shape, why.may_be_obstacle, why.remedy, heights=why.heights)


def not_read(feature: Feature, frame: LocalFrame, path: Path) -> PassedOver | Unread | None:
    """Return the unread part of a feature, as `Unread` if it may be anywhere."""
    if feature.missing is None and not shapely.is_empty(feature.shape):
        return None
    missing = feature.missing or Missing(
        "without a geometry", feature.shape, "give it a geometry in the map, or take it out"
    )
    if missing.elsewhere:
        return None
    name = feature.name.removeprefix(f"{path}: ")
    if shapely.is_empty(missing.shape):
        place = feature.place.removeprefix(f"{path}: ")
        example = "" if name == place else name
        return Unread(path.name, missing.words, place, example, may_limit=True, remedy=missing.remedy)
    (shape,), (near,) = to_plane([missing.shape], frame)
    return PassedOver(path.name, name, missing.words, shape, True, missing.remedy, NOT_READ) if near else None


def count_passed_over(things: Iterable[PassedOver]) -> Iterator[PassedCount]:
    def kind(thing: PassedOver) -> tuple[bool, str, str]:
        return not thing.may_be_obstacle, thing.file, thing.reason

    for _, group in groupby(sorted(things, key=kind), key=kind):
        first, *_ = several = list(group)
        names = tuple(thing.name for thing in several[:MOST_NAMED])
        yield PassedCount(first.file, first.reason, first.may_be_obstacle, len(several), names, first.code)
