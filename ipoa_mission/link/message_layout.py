"""How a message lies in MAVLink's fields: each of its values under one name there or several, in MAVLink's units."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any, Generic, TypeAlias, TypeVar

from ipoa_mission.link.messages import Message

M = TypeVar("M", bound=Message)
Fields: TypeAlias = Mapping[str, Any]
Way: TypeAlias = Callable[[Any], Any]


@dataclass(frozen=True)
class MessageLayout(Generic[M]):
    """One message on the wire: its MAVLink name, and the two ways between `M` and MAVLink's fields."""

    name: str
    kind: type[M]
    write: Callable[[M], Fields]
    read: Callable[[Any], M]


@dataclass(frozen=True)
class Value:
    """A value that MAVLink holds otherwise: under which names (several: as a tuple), and the two ways between."""

    names: tuple[str, ...]
    write: Way = lambda value: value
    read: Way = lambda raw: raw


def plain(name: str, kind: type[M], also: Fields | None = None, /, **placed: str | Value) -> MessageLayout[M]:
    """A message whose values MAVLink holds as they are, but for those `placed` under another name, or as a `Value`.

    `also` are fields that are always written alike.
    """
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
