"""A feature of a map file: a shape on the Earth with its tags, and where in the file it stands."""

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput

Corners: TypeAlias = NDArray[np.float64]  # (n, 2) longitude, latitude [deg, WGS 84]
Made = TypeVar("Made")
NAMES = ("name", "addr:housename", "identifier", "@id", "id", "osm_way_id", "osm_id")
MANY = 10  # mistakes told at once
DEEPEST = 16  # collections in each other: nobody draws more, and shapely would not bear thousands


class Missing(NamedTuple):
    """A part of a feature that was not read: what it is, where it is [deg], and what can be done about it.

    `shape` is empty where nobody knows; the part may then be anywhere, unless it is `elsewhere` for sure.
    """

    words: str
    shape: Any
    remedy: str = ""
    elsewhere: bool = False


class Feature(NamedTuple):
    """`shape` is a shapely geometry in longitude, latitude [deg, WGS 84], as it stands in the file: it may be invalid.

    It is empty where the file gives none. `place` names file and feature for messages; `tags` are its properties as
    text, and `blank` the keys of those without a value.
    """

    place: str
    shape: Any
    tags: Mapping[str, str]
    blank: frozenset[str] = frozenset()
    missing: Missing | None = None

    @property
    def name(self) -> str:
        """What messages call the thing: its name, or else its number in OpenStreetMap, or its place in the file."""
        name = self.place
        for key in NAMES:
            if named := self.tags.get(key):
                name = named
                break
        return name if name.isprintable() else "".join(letter if letter.isprintable() else " " for letter in name)


def on_earth(corners: Corners, place: str, hint: str = "export the file in WGS 84 (EPSG:4326)") -> Corners:
    """The same corners, if they are longitudes and latitudes.

    Raises:
        BadInput: they are none.
    """
    outside = ~(np.abs(corners) <= (360.0, 90.0)).all(axis=1)
    if outside.any():
        x, y = corners[outside][0]
        words = f"expected longitude and latitude in degrees, not {x:g}, {y:g}"
        raise BadInput(words, hint=hint, code="not-degrees", place=place)
    return corners


def positions_of(values: Any, place: str) -> Corners:
    """The first two numbers of each position in a list of JSON, (n, 2).

    Raises:
        BadInput: it is no such list.
    """
    try:
        corners = np.array([position[:2] for position in values], float)
    except (TypeError, ValueError, KeyError, OverflowError):
        corners = np.zeros((0, 0))
    if corners.ndim != 2 or corners.shape[1] != 2 or not np.isfinite(corners).all():
        raise BadInput("expected positions as [longitude, latitude]", place=place)
    return corners


class Mistakes:
    """Collects what is wrong in a file, so that all of it is told at once."""

    def __init__(self) -> None:
        self._first: list[BadInput] = []
        self._count = 0

    def attempt(self, act: Callable[..., Made], *arguments: Any) -> Made | None:
        """What `act` makes of its arguments; or None, if it raised BadInput."""
        try:
            return act(*arguments)
        except BadInput as mistake:
            self._count += 1
            if self._count <= MANY:
                self._first.append(mistake)
            return None

    def tell(self) -> None:
        """Raise what was found, if anything was.

        Raises:
            BadInput: with a line for each mistake, but no more than ten.
        """
        if self._first:
            more = (f"and {self._count - MANY} more of this kind",) if self._count > MANY else ()
            raise self._first[0].followed_by(*map(str, self._first[1:]), *more)


def read_all(read: Callable[..., Feature | None], each: Iterable[tuple[Any, ...]]) -> tuple[Feature, ...]:
    """The features that `read` makes of each set of arguments; those of which it makes none are left out.

    Raises:
        BadInput: what is wrong with any of them.
    """
    mistakes = Mistakes()
    features = [mistakes.attempt(read, *arguments) for arguments in each]
    mistakes.tell()
    return tuple(feature for feature in features if feature is not None)


@contextmanager
def many_objects() -> Iterator[None]:
    """While very many objects are made that stay: Python does not search them for rings again and again."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
