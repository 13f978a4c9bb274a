"""What a map has and a scenario does not take: named, counted by reason, and kept in its place for the check."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, TypeAlias

from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.kinds import Reason

MOST_NAMED = 3
#: What things are counted by: whether they are nothing for sure, file, reason.
Key: TypeAlias = tuple[bool, str, str]
NONE: Mapping[Key, int] = {}
FAR = Reason("more than 100 km from home", False)


@dataclass(frozen=True, eq=False, slots=True)
class PassedOver:
    """One thing of the map `file` that is no obstacle, and why; `shape` is local, east, north [m], or empty.

    `may_stand`: it may be in the way all the same, because nothing says that it is not; `remedy` says what to do then.
    """

    file: str
    name: str
    reason: str
    shape: Any
    may_stand: bool
    remedy: str = ""


@dataclass(frozen=True)
class PassedCount:
    """How many things of a map were passed over for one reason; `names` are those of the first."""

    file: str
    reason: str
    may_stand: bool
    count: int
    names: tuple[str, ...]

    def words(self) -> str:
        """The count in a sentence without a full stop."""
        dots = ", ..." if self.count > len(self.names) else ""
        return f"{self.file}: {self.count} passed over, {self.reason}: {', '.join(self.names)}{dots}"


def passed_over(feature: Feature, shape: Any, why: Reason, path: Path) -> PassedOver:
    """A feature of the map `path`, `shape` in the local plane, that is not taken."""
    return PassedOver(path.name, feature.name.removeprefix(f"{path}: "), why.words, shape, why.may_stand, why.remedy)


def count_passed_over(things: Iterable[PassedOver], left_out: Mapping[Key, int] = NONE) -> Iterator[PassedCount]:
    """By file and reason, those that may stand in the way first; `left_out` are more of the kind of some of them."""
    for key, several in groupby(sorted(things, key=key_of), key=key_of):
        every = list(several)
        names = tuple(thing.name for thing in every[:MOST_NAMED])
        yield PassedCount(every[0].file, every[0].reason, not key[0], len(every) + left_out.get(key, 0), names)


def key_of(thing: PassedOver) -> Key:
    """By what it is counted."""
    return not thing.may_stand, thing.file, thing.reason
