"""MAVLink's messages: number, name, fields, checksum.

Their table is pymavlink's. A wheel carries it, made when that was built: pymavlink brings 50 dialects, and 105 MB with
what it needs. A checkout takes it from pymavlink itself.
"""

import json
import struct
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.link.layout import Fields

TABLE = "messages.json"
Row = list[Any]  # number, name, layout as `struct` has it, names of the fields, how many values each has, CRC_EXTRA


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
            raise BadInput(f"{self.name}: expected values that fit its fields: {error}") from error

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


def _table() -> list[Row]:
    made = Path(__file__).with_name(TABLE)
    if made.is_file():
        return json.loads(made.read_text(encoding="utf-8"))  # type: ignore[no-any-return]
    return rows()


def rows() -> list[Row]:
    """The table as pymavlink has it.

    Raises:
        MissionError: it is not installed.
    """
    try:
        from pymavlink.dialects.v20 import ardupilotmega as dialect
    except ImportError:
        raise MissionError(
            "this copy of ipoa_mission has no table of MAVLink's messages, and pymavlink is not installed",
            hint="pip install pymavlink",
        ) from None
    return [_row(kind) for kind in dialect.mavlink_map.values()]


def _row(kind: Any) -> Row:
    names, is_text = list(kind.ordered_fieldnames), dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
    lengths = [1 if is_text[name] == "char" else length for name, length in zip(names, kind.lengths, strict=True)]
    return [kind.id, kind.msgname, kind.unpacker.format, names, lengths, kind.crc_extra]


def _definition(number: int, name: str, layout: str, names: list[str], lengths: list[int], crc: int) -> Definition:
    return Definition(number, name, struct.Struct(layout), tuple(names), tuple(lengths), crc)


DEFINITIONS = {row[0]: _extended(_definition(*row)) for row in _table()}
DEFINITIONS = {one.number: one for one in _OTHERS} | DEFINITIONS
_NUMBERS = {definition.name: definition.number for definition in DEFINITIONS.values()}


def message_number(name: str) -> int:
    """MAVLink's number of a message name."""
    return _NUMBERS[name]


def message_name(number: int) -> str | None:
    """MAVLink's name of a message number, where it is known."""
    return DEFINITIONS[number].name if number in DEFINITIONS else None


def definition_of(name: str) -> Definition:
    """The message of this name."""
    return DEFINITIONS[_NUMBERS[name]]
