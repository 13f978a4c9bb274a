"""MAVLink's messages: number, name, fields, checksum. The tables are pymavlink's, of any dialect."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType, SimpleNamespace
from typing import Any

from pymavlink.dialects import v20 as dialects
from pymavlink.dialects.v20 import ardupilotmega

from ipoa_mission.errors import BadInput
from ipoa_mission.link.message_layout import Fields

NOT_USED = ("Empty", "Reserved", "empty", "reserved", "Unused")  # as MAVLink says it of a param


@dataclass(frozen=True)
class Definition:
    """One MAVLink message: its payload in wire order, and what its checksum is seeded with."""

    number: int
    name: str
    layout: struct.Struct
    names: tuple[str, ...]
    lengths: tuple[int, ...]  # values of each field in the layout
    crc_extra: int

    @cached_property
    def seed(self) -> bytes:
        """CRC_EXTRA as a byte: the last that the checksum sees."""
        return bytes((self.crc_extra,))

    def pack(self, fields: Fields) -> bytes:
        """The payload without the zeros at its end; a field that is not given is zero.

        Raises:
            BadInput: a value does not fit.
        """
        values: list[Any] = []
        for name, length, blank in zip(self.names, self.lengths, self._blanks(), strict=True):
            value = fields.get(name, blank)
            values.extend(value) if length > 1 else values.append(value)
        try:
            return self.layout.pack(*values).rstrip(b"\0") or b"\0"
        except (struct.error, OverflowError) as error:
            raise BadInput(f"expected values that fit its fields: {error}", place=self.name) from error

    def unpack(self, payload: bytes) -> SimpleNamespace:
        """The fields of a payload; MAVLink 2 cuts it at its trailing zeros, MAVLink 1 before its extensions."""
        size = self.layout.size
        values = self.layout.unpack(payload[:size].ljust(size, b"\0"))
        if len(values) == len(self.names):
            return SimpleNamespace(**dict(zip(self.names, values, strict=True)))
        fields, at = {}, 0
        for name, length in zip(self.names, self.lengths, strict=True):
            fields[name] = values[at] if length == 1 else values[at : at + length]
            at += length
        return SimpleNamespace(**fields)

    def _blanks(self) -> tuple[Any, ...]:
        return _blanks(self.number)


@cache
def _blanks(number: int) -> tuple[Any, ...]:
    fields = vars(DEFINITIONS[number].unpack(b""))
    return tuple(fields.values())


#: PX4's, which ArduPilot's dialect does not have.
_OTHERS = (
    Definition(
        300,
        "PROTOCOL_VERSION",
        struct.Struct("<HHH8B8B"),
        ("version", "min_version", "max_version", "spec_version_hash", "library_version_hash"),
        (1, 1, 1, 8, 8),
        217,
    ),
    Definition(
        410,
        "EVENT",
        struct.Struct("<IIHBBB40s"),
        (
            *("id", "event_time_boot_ms", "sequence"),
            *("destination_component", "destination_system", "log_levels", "arguments"),
        ),
        (1,) * 7,
        160,
    ),
)
#: Fields that MAVLink has added behind messages since the stable dialects: 32-bit numbers.
_ADDED = {"MISSION_ACK": ("opaque_id",), "MISSION_CURRENT": ("mission_id", "fence_id", "rally_points_id")}


def _extended(definition: Definition) -> Definition:
    new = tuple(name for name in _ADDED.get(definition.name, ()) if name not in definition.names)
    return replace(
        definition,
        layout=struct.Struct(definition.layout.format + "I" * len(new)),
        names=definition.names + new,
        lengths=definition.lengths + (1,) * len(new),
    )


def _definitions(dialect: ModuleType) -> Iterator[Definition]:
    for kind in dialect.mavlink_map.values():
        names, kinds = tuple(kind.ordered_fieldnames), dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
        lengths = tuple(1 if kinds[name] == "char" else n for name, n in zip(names, kind.lengths, strict=True))
        layout = struct.Struct(kind.unpacker.format)
        yield _extended(Definition(kind.id, kind.msgname, layout, names, lengths, kind.crc_extra))


_IN_USE = [ardupilotmega]
DEFINITIONS = {one.number: one for one in (*_OTHERS, *_definitions(ardupilotmega))}
_NUMBERS = {definition.name: definition.number for definition in DEFINITIONS.values()}


def add_dialect(dialect: str | ModuleType) -> None:
    """Understand the messages of another dialect too.

    Args:
        dialect: one of pymavlink's by its name, or a module that it generated.

    Raises:
        BadInput: there is no such dialect, or it has another message under a number that is in use.

    Example:
        >>> from ipoa_mission import add_dialect
        >>> add_dialect("storm32")
    """
    module = _dialect(dialect) if isinstance(dialect, str) else dialect
    new = {one.number: one for one in _definitions(module)}
    for number, one in new.items():
        known = DEFINITIONS.get(number)
        if known is not None and (known.name, known.crc_extra) != (one.name, one.crc_extra):
            raise BadInput(f"its message {number} is {one.name}, which is {known.name} here", place="dialect")
    for number, one in new.items():
        DEFINITIONS.setdefault(number, one)
        _NUMBERS.setdefault(one.name, number)
    if module not in _IN_USE:
        _IN_USE.append(module)


def dialect_of(number: int) -> Any:
    """The module of pymavlink's that has this message.

    Raises:
        BadInput: none that is in use.
    """
    for module in _IN_USE:
        if number in module.mavlink_map:
            return module
    raise BadInput("expected one of a dialect that is in use", code="unknown-dialect", place=f"message {number}")


def _dialect(name: str) -> ModuleType:
    try:
        return import_module(f"pymavlink.dialects.v20.{name}")
    except ImportError:
        there = sorted(one.name for one in iter_modules(dialects.__path__))
        words = f"expected one of pymavlink's, not {name!r}"
        raise BadInput(words, hint=", ".join(there), code="unknown-dialect", place="dialect") from None


def message_number(name: str) -> int:
    """MAVLink's number of a message name."""
    return _NUMBERS[name]


def message_name(number: int) -> str | None:
    """MAVLink's name of a message number, where it is known."""
    return DEFINITIONS[number].name if number in DEFINITIONS else None


def params_in_words(command: int) -> dict[int, str]:
    """What MAVLink says of param1 to param7 of a command, where it uses them; nothing of one that it does not know.

    >>> params_in_words(177)
    {1: 'Sequence number', 2: 'Repeat count'}
    """
    known = ardupilotmega.enums["MAV_CMD"].get(command)
    told = {} if known is None else known.param
    return {number: words for number, words in sorted(told.items()) if words and not words.startswith(NOT_USED)}


def definition_of(name: str) -> Definition:
    """The message of this name."""
    return DEFINITIONS[_NUMBERS[name]]
