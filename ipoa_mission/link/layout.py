"""How a message lies in MAVLink's fields: its name there, and the two ways between them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

from ipoa_mission.link.messages import Message

M = TypeVar("M", bound=Message)
Fields = Mapping[str, Any]
_SAME_NAMES: Fields = {}


@dataclass(frozen=True)
class Layout(Generic[M]):
    """One message on the wire: its MAVLink name, and the two ways between `M` and MAVLink's fields."""

    name: str
    kind: type[M]
    write: Callable[[M], Fields]
    read: Callable[[Any], M]


def plain(name: str, kind: type[M], renamed: Fields = _SAME_NAMES) -> Layout[M]:
    """A message whose fields MAVLink holds as they are, some under another name."""
    names = {field.name: renamed.get(field.name, field.name) for field in fields(kind)}
    return Layout(
        name,
        kind,
        lambda message: {theirs: getattr(message, ours) for ours, theirs in names.items()},
        lambda raw: kind(**{ours: getattr(raw, theirs) for ours, theirs in names.items()}),
    )
