from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Unread:
    """Things of one kind that a reader skipped.

    Attributes:
        file: its name.
        what: thing and reason: `tag "hgt", which may be a height`.
        place: of the first one: `features[3]`.
        example: its spelling, or empty.
        may_limit: may be an obstacle, a zone or another limit of the flight: an error.
        remedy: advice to the user.

    Example:
        >>> tags = [Unread("town.shp", 'tag "hgt"', f"row[{n}]", "12") for n in (4, 7)]
        >>> [thing.words for thing in gathered(tags)]
        ['town.shp: not read: tag "hgt": 2 times, first row[4] ("12")']
    """

    file: str
    what: str
    place: str
    example: str = ""
    count: int = 1
    may_limit: bool = False
    remedy: str = ""

    @property
    def words(self) -> str:
        times = f"{self.count} times, first " if self.count > 1 else ""
        example = f' ("{self.example[:40]}")' if self.example else ""
        return f"{self.file}: not read: {self.what}: {times}{self.place}{example}"


def gathered(things: Iterable[Unread]) -> tuple[Unread, ...]:
    """Count each kind; those that may limit the flight first."""
    kinds: dict[tuple[str, str, bool], Unread] = {}
    for thing in things:
        key = (thing.file, thing.what, thing.may_limit)
        first = kinds.get(key)
        kinds[key] = thing if first is None else replace(first, count=first.count + thing.count)
    return tuple(sorted(kinds.values(), key=lambda thing: not thing.may_limit))


def unread_as_json(things: Iterable[Unread]) -> list[dict[str, Any]]:
    return [asdict(thing) for thing in things]
