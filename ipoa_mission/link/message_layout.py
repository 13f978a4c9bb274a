from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any, Generic, TypeAlias, TypeVar

from ipoa_mission.link.messages import Message

M = TypeVar("M", bound=Message)
Fields: TypeAlias = Mapping[str, Any]
Conversion: TypeAlias = Callable[[Any], Any]


@dataclass(frozen=True)
class MessageLayout(Generic[M]):
    """A message's name, and the conversions to and from its fields."""

    name: str
    kind: type[M]
    write: Callable[[M], Fields]
    read: Callable[[Any], M]


@dataclass(frozen=True)
class Value:
    """One field, or several as a tuple."""

    names: tuple[str, ...]
    write: Conversion = lambda value: value
    read: Conversion = lambda raw: raw


def plain(name: str, kind: type[M], also: Fields | None = None, /, **placed: str | Value) -> MessageLayout[M]:
    """MAVLink's own values, except for those `placed` (name or `Value`); `also` are constants."""
    values: list[tuple[str, Value]] = []
    for field in fields(kind):
        place = placed.get(field.name, field.name)
        values.append((field.name, Value((place,)) if isinstance(place, str) else place))
    alone = [(ours, value.names[0], value.write) for ours, value in values if len(value.names) == 1]
    several = [(ours, value) for ours, value in values if len(value.names) != 1]
    readers = [(attrgetter(*value.names), value.read) for _, value in values]

    def write(message: M) -> Fields:
        written = dict(also or {})
        for ours, theirs, to_wire in alone:
            written[theirs] = to_wire(getattr(message, ours))
        for ours, value in several:
            written.update(zip(value.names, value.write(getattr(message, ours)), strict=True))
        return written

    def read(raw: Any) -> M:
        return kind(*[from_wire(get(raw)) for get, from_wire in readers])

    return MessageLayout(name, kind, write, read)
