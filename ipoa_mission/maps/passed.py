"""What a map has and a scenario does not take: named, counted by reason, and kept in its place for the check."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, TypeAlias

import shapely

from ipoa_mission.maps.feature import Feature, Missing
from ipoa_mission.maps.kinds import Reason
from ipoa_mission.maps.planar import Whereabouts, to_plane
from ipoa_mission.unread import Unread
from ipoa_mission.world.frame import LocalFrame

MOST_NAMED = 3
#: What things are counted by: whether they are nothing for sure, file, reason.
Key: TypeAlias = tuple[bool, str, str]
NOT_UNDERSTOOD, NOT_READ = "map-not-understood", "not-read"
NONE: Mapping[Key, int] = {}
WITHOUT = "without a geometry"
FAR = Reason("more than 100 km from home", False)


@dataclass(frozen=True, eq=False, slots=True)
class PassedOver:
    """One thing of the map `file` that is no obstacle, and why; `shape` is local, east, north [m], or empty.

    `may_stand`: it may be in the way all the same, because nothing says that it is not; `remedy` says what to do then,
    `heights` are keys of its map's section that give it one, and `code` is that of the finding. What has the code
    `not-read` may be an obstacle, or a higher one than was taken.
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
    """How many things of a map were passed over for one reason; `names` are those of the first."""

    file: str
    reason: str
    may_stand: bool
    count: int
    names: tuple[str, ...]
    code: str = NOT_UNDERSTOOD

    def words(self) -> str:
        """The count in a sentence without a full stop."""
        dots = ", ..." if self.count > len(self.names) else ""
        how = "not read" if self.code == NOT_READ else "passed over"
        return f"{self.file}: {self.count} {how}, {self.reason}: {', '.join(self.names)}{dots}"


def passed_over(feature: Feature, shape: Any, why: Reason, path: Path) -> PassedOver:
    """A feature of the map `path`, `shape` in the local plane, that is not taken."""
    name = feature.name.removeprefix(f"{path}: ")
    return PassedOver(path.name, name, why.words, shape, why.may_stand, why.remedy, heights=why.heights)


def not_read(feature: Feature, frame: LocalFrame, path: Path) -> PassedOver | Unread | None:
    """What of a feature of the map `path` was not read: where it lies, or, if nobody knows, that it may be anywhere.

    None where nothing is missing, or it lies elsewhere for sure.
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
    (shape,), (near,) = to_plane([missing.shape], [feature.place], Whereabouts(frame))
    return PassedOver(path.name, name, missing.words, shape, True, missing.remedy, NOT_READ) if near else None


def count_passed_over(things: Iterable[PassedOver], left_out: Mapping[Key, int] = NONE) -> Iterator[PassedCount]:
    """By file and reason, those that may stand in the way first; `left_out` are more of the kind of some of them."""
    for key, several in groupby(sorted(things, key=key_of), key=key_of):
        every = list(several)
        names = tuple(thing.name for thing in every[:MOST_NAMED])
        count = len(every) + left_out.get(key, 0)
        yield PassedCount(every[0].file, every[0].reason, not key[0], count, names, every[0].code)


def key_of(thing: PassedOver) -> Key:
    """By what it is counted."""
    return not thing.may_stand, thing.file, thing.reason
