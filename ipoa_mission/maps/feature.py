import gc
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput

Corners: TypeAlias = NDArray[np.float64]  # (n, 2) longitude, latitude [deg]
Made = TypeVar("Made")
BATCH = 4096  # features handled together
EMPTY_SHAPE = shapely.GeometryCollection()
DEEPEST = 16  # nested collections; shapely fails at thousands


class Missing(NamedTuple):
    """An unread part [deg]; with an empty `shape` it may be anywhere, unless `elsewhere`."""

    words: str
    shape: Any
    remedy: str = ""
    elsewhere: bool = False


class Feature(NamedTuple):
    """A geometry [deg, WGS 84], maybe invalid or empty; `blank` are keys without a value.

    `drawn`: greatest altitude above the ground, and above the sea [m].
    """

    place: str
    shape: Any
    tags: Mapping[str, str]
    blank: frozenset[str] = frozenset()
    missing: Missing | None = None
    drawn: tuple[float, float] = (-math.inf, -math.inf)

    @property
    def name(self) -> str:
        keys = ("name", "Name", "NAME", "addr:housename", "identifier", "@id", "id", "osm_way_id", "osm_id")
        return make_printable(next((name for key in keys if (name := self.tags.get(key))), self.place))


def is_altitude(number: float) -> bool:
    return abs(number) < 10_000.0  # [m]; else a time or a measure


def make_printable(name: str) -> str:
    return name if name.isprintable() else "".join(letter if letter.isprintable() else " " for letter in name)


def on_earth(corners: Corners, place: str, hint: str = "export the file in WGS 84 (EPSG:4326)") -> Corners:
    outside = ~(np.abs(corners) <= (360.0, 90.0)).all(axis=1)
    if outside.any():
        x, y = corners[outside][0]
        words = f"expected longitude and latitude in degrees, not {x:g}, {y:g}"
        raise BadInput(words, hint=hint, code="not-degrees", place=place)
    return corners


class Mistakes:
    def __init__(self) -> None:
        self._first: list[BadInput] = []
        self._more = 0

    def attempt(self, act: Callable[..., Made], *arguments: Any) -> Made | None:
        try:
            return act(*arguments)
        except BadInput as mistake:
            if len(self._first) < 10:
                self._first.append(mistake)
            else:
                self._more += 1
            return None

    def raise_all(self) -> None:
        if self._first:
            more = (f"and {self._more} more of this kind",) if self._more else ()
            raise self._first[0].followed_by(*map(str, self._first[1:]), *more)


def read_all(read: Callable[..., Made], items: Iterable[tuple[Any, ...]]) -> tuple[Made, ...]:
    mistakes = Mistakes()
    made = [mistakes.attempt(read, *arguments) for arguments in items]
    mistakes.raise_all()
    return tuple(each for each in made if each is not None)


@contextmanager
def many_objects() -> Iterator[None]:
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
