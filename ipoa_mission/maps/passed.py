"""Collect map features that a scenario does not use: named, counted by reason, and located for the check."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, TypeAlias

import shapely

from ipoa_mission.maps.feature import Feature, Missing
from ipoa_mission.maps.kinds import Reason
from ipoa_mission.maps.planar import MapExtent, to_plane
from ipoa_mission.unread import Unread
from ipoa_mission.world.frame import LocalFrame

MOST_NAMED = 3
# Key of a count: whether it is certainly no obstacle, file, reason.
Key: TypeAlias = tuple[bool, str, str]
NOT_UNDERSTOOD, NOT_READ = "map-not-understood", "not-read"
NONE: Mapping[Key, int] = {}
WITHOUT = "without a geometry"
FAR_FROM_HOME = Reason("more than 100 km from home", False)


@dataclass(frozen=True, eq=False, slots=True)
class PassedOver:
    """A feature of the map `file` that is no obstacle, and why; `shape` is local, east, north [m], or empty.

    `may_stand` marks a possible obstacle, `remedy` describes how to settle it. `heights` are keys of the map's section
    that give it a height. `code` is that of the finding: `not-read` may also mean a higher obstacle than was taken.
    """

    file: str
    name: str
    reason: str
    shape: Any
    may_stand: bool
    remedy: str = ""
    code: str = NOT_UNDERSTOOD
    heights: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class PassedCount:
    """The number of features of a map passed over for one reason, with the `names` of the first."""

    file: str
    reason: str
    may_stand: bool
    count: int
    names: tuple[str, ...]
    code: str = NOT_UNDERSTOOD

    def words(self) -> str:
        """Return the count in words, without a full stop."""
        dots = ", ..." if self.count > len(self.names) else ""
        how = "not read" if self.code == NOT_READ else "passed over"
        return f"{self.file}: {self.count} {how}, {self.reason}: {', '.join(self.names)}{dots}"


def passed_over(feature: Feature, shape: Any, why: Reason, path: Path) -> PassedOver:
    """Return a feature of the map `path` as passed over, with its local shape."""
    name = feature.name.removeprefix(f"{path}: ")
    return PassedOver(path.name, name, why.words, shape, why.may_stand, why.remedy, heights=why.heights)


def not_read(feature: Feature, frame: LocalFrame, path: Path) -> PassedOver | Unread | None:
    """Return the unread part of a feature of the map `path`: with its place, or as `Unread` if it may be anywhere.

    None if nothing is missing, or if it is certainly elsewhere.
    """
    if feature.missing is None and not shapely.is_empty(feature.shape):
        return None
    missing = feature.missing or Missing(WITHOUT, feature.shape, "give it a geometry in the map, or take it out")
    if missing.elsewhere:
        return None
    name = feature.name.removeprefix(f"{path}: ")
    if shapely.is_empty(missing.shape):
        place = feature.place.removeprefix(f"{path}: ")
        example = "" if name == place else name
        return Unread(path.name, missing.words, place, example, may_limit=True, remedy=missing.remedy)
    (shape,), (near,) = to_plane([missing.shape], [feature.place], MapExtent(frame))
    return PassedOver(path.name, name, missing.words, shape, True, missing.remedy, NOT_READ) if near else None


def count_passed_over(things: Iterable[PassedOver], left_out: Mapping[Key, int] = NONE) -> Iterator[PassedCount]:
    """Yield counts by file and reason, possible obstacles first; `left_out` adds to them."""
    for key, several in groupby(sorted(things, key=key_of), key=key_of):
        every = list(several)
        names = tuple(thing.name for thing in every[:MOST_NAMED])
        count = len(every) + left_out.get(key, 0)
        yield PassedCount(every[0].file, every[0].reason, not key[0], count, names, every[0].code)


def key_of(thing: PassedOver) -> Key:
    """Return the key by which a feature is counted."""
    return not thing.may_stand, thing.file, thing.reason
