"""MAVLink's messages by number and name: pymavlink's ardupilotmega, and newer messages and fields of PX4."""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from pymavlink.dialects import v20 as dialects
from pymavlink.dialects.v20 import ardupilotmega

from ipoa_mission.errors import BadInput

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element


@dataclass(frozen=True)
class Definition:
    number: int
    name: str
    layout: struct.Struct
    names: tuple[str, ...]
    lengths: tuple[int, ...]  # values per field
    seed: bytes  # CRC_EXTRA, one byte

    def pack(self, fields: Mapping[str, Any]) -> bytes:
        """Return the payload without trailing zeros."""
        values: list[Any] = []
        for name, length, blank in zip(self.names, self.lengths, self._blanks, strict=True):
            value = fields.get(name, blank)
            values.extend(value) if length > 1 else values.append(value)
        try:
            return self.layout.pack(*values).rstrip(b"\0") or b"\0"
        except (struct.error, OverflowError) as error:
            raise BadInput(f"expected values that fit its fields: {error}", place=self.name) from error

    def unpack(self, payload: bytes) -> SimpleNamespace:
        """Decode a payload cut by MAVLink 2 (trailing zeros) or 1 (extensions)."""
        size = self.layout.size
        values = self.layout.unpack(payload[:size].ljust(size, b"\0"))
        if len(values) == len(self.names):
            return SimpleNamespace(**dict(zip(self.names, values, strict=True)))
        fields = {}
        at = 0
        for name, length in zip(self.names, self.lengths, strict=True):
            fields[name] = values[at] if length == 1 else values[at : at + length]
            at += length
        return SimpleNamespace(**fields)

    @cached_property
    def _blanks(self) -> tuple[Any, ...]:
        return tuple(vars(self.unpack(b"")).values())


_PX4_DEFINITIONS = (  # without fields that nobody reads
    Definition(
        300, "PROTOCOL_VERSION", struct.Struct("<HHH16x"), ("version", "min_version", "max_version"), (1,) * 3, b"\xd9"
    ),
    Definition(410, "EVENT", struct.Struct("<I8xB40s"), ("id", "log_levels", "arguments"), (1,) * 3, b"\xa0"),
)


def _definitions() -> Iterator[Definition]:
    # extension fields newer than the stable dialects: 32-bit numbers
    added = {"MISSION_ACK": ("opaque_id",), "MISSION_CURRENT": ("mission_id", "fence_id", "rally_points_id")}
    for kind in ardupilotmega.mavlink_map.values():
        names = tuple(kind.ordered_fieldnames)
        types = dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
        lengths = tuple(1 if types[name] == "char" else n for name, n in zip(names, kind.lengths, strict=True))
        new = tuple(name for name in added.get(kind.msgname, ()) if name not in names)
        layout = struct.Struct(kind.unpacker.format + "I" * len(new))
        seed = bytes((kind.crc_extra,))
        yield Definition(kind.id, kind.msgname, layout, names + new, lengths + (1,) * len(new), seed)


DEFINITIONS = {definition.number: definition for definition in (*_PX4_DEFINITIONS, *_definitions())}
_BY_NAME = {definition.name: definition for definition in DEFINITIONS.values()}


def definition_of(name: str) -> Definition:
    return _BY_NAME[name]


def message_name(number: int) -> str | None:
    return DEFINITIONS[number].name if number in DEFINITIONS else None


def unit_and_type(message: str, field: str) -> tuple[str, str]:
    """Return MAVLink's unit of a field ("": none) and its type."""
    kind = ardupilotmega.mavlink_map.get(_BY_NAME[message].number)
    if kind is None:  # of PX4's own
        return "", ""
    return kind.fieldunits_by_name.get(field, ""), kind.fieldtypes[kind.fieldnames.index(field)]


@cache
def labeled_params(command: int) -> dict[int, tuple[str, str, str]]:
    """Return label, unit and description of the labeled params, by number from 1."""
    entry = _commands().get(command)
    params = () if entry is None else entry.iterfind("param[@label]")
    return {int(one.attrib["index"]): (one.attrib["label"], one.get("units", ""), one.text or "") for one in params}


@cache
def _commands() -> "dict[int, Element]":
    from xml.etree import ElementTree  # slow import

    files = [Path(str(dialects.__file__)).with_name(f"{name}.xml") for name in ("common", "ardupilotmega")]
    entries = (ElementTree.parse(file).iterfind("enums/enum[@name='MAV_CMD']/entry") for file in files)
    return {int(entry.attrib["value"]): entry for entry in chain.from_iterable(entries)}
