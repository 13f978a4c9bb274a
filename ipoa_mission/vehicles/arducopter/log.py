"""ArduPilot's own log (`.bin`), by its FMT records; pymavlink's reader takes hours for a file of zeros."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np

from ipoa_mission.autopilot.commands import Frame
from ipoa_mission.autopilot.parameters import REAL32
from ipoa_mission.errors import BadInput, Unreadable, WrongFormat
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Matrix, Points, Vector
from ipoa_mission.link.messages import INFO, Current, HomePosition, Message, ParamValue, Text
from ipoa_mission.logs.logged import Battery, Begun, Held, Log, LogFormat, Measured, in_order, item_begun, presence
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.arducopter.vehicle import ARDUCOPTER

HEAD = b"\xa3\x95"
FMT = 0x80
#: Battery number by record name: BAT has an instance since 4.0; CURR before 3.7.
BATTERIES = {"BAT": 0, "CURR": 0, "BAT2": 1, "CUR2": 1, "BAT3": 2, "BAT4": 3}
KINDS = frozenset({*BATTERIES, "POS", "XKF1", "NKF1", "ATT", "MODE", "ARM", "EV", "MISE", "CMD", "MSG", "PARM", "ORGN"})


#: Struct's code by format letter.
CODES: Mapping[str, str] = {
    **dict(zip("bBhHiIfdqQ", "bBhHiIfdqQ", strict=True)),
    "g": "e", "M": "B", "a": "64s", "n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i",
}  # fmt: skip
UNITS: Mapping[str, float] = {**dict.fromkeys("cCeE", 100), "L": 1e7}  # by format letter


def _text(raw: bytes) -> str:
    return raw.split(b"\0")[0].decode("utf-8", "replace")


def _converted(letter: str, value: Any) -> Any:
    if letter in UNITS:
        return value / UNITS[letter]
    return _text(value) if letter in "nNZ" else value


@dataclass(frozen=True)
class RecordKind:
    name: str
    layout: Struct
    letters: str
    columns: tuple[str, ...]

    def read(self, data: bytes, offset: int) -> dict[str, Any]:
        """Return the values by column, in degrees, meters and unscaled units."""
        rows = zip(self.columns, self.letters, self.layout.unpack_from(data, offset), strict=True)
        return {name: _converted(letter, value) for name, letter, value in rows}


def read_records(
    path: Path, wanted: frozenset[str], torn: Counter[str] | None = None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Read the wanted kinds of records in order, as (kind, values by column).

    Damaged bytes are skipped; `torn` counts them, by kind or as "bytes".

    Raises:
        BadInput: the file cannot be read, or is no log.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Unreadable(f"cannot be read as an ArduPilot log: {error.strerror}", place=path) from error
    if not data.startswith(HEAD + bytes((FMT,))):
        raise WrongFormat("expected an ArduPilot log, but it does not start like one", place=path)
    described = Struct("<BB4s16s64s")  # kind, size, name, letters, columns
    lengths: dict[int, int] = {FMT: 3 + described.size}
    kinds: dict[int, RecordKind] = {}
    torn = Counter() if torn is None else torn
    offset = ends = 0
    while (offset := data.find(HEAD, offset)) >= 0 and offset + 3 <= len(data):
        number = data[offset + 2]
        length = lengths.get(number)
        if length is None or offset + length > len(data):
            offset += 1
            continue
        torn["bytes"] += offset - ends
        ends = offset + length
        if number == FMT:
            number, size, *texts = described.unpack_from(data, offset + 3)
            name, letters, columns = map(_text, texts)
            kind = _kind(name, letters, columns)
            if size >= 3 and number != FMT:
                lengths[number] = size
                kinds.pop(number, None)
                if kind is not None and name in wanted and kind.layout.size == size - 3:
                    kinds[number] = kind
                elif name in wanted:
                    torn[name] += 1
        elif number in kinds:
            yield kinds[number].name, kinds[number].read(data, offset + 3)
        offset += length
    torn["bytes"] += len(data) - ends


def _kind(name: str, letters: str, columns: str) -> RecordKind | None:
    names = tuple(columns.split(","))
    if len(names) != len(letters) or not set(letters) <= CODES.keys():
        return None
    return RecordKind(name, Struct("<" + "".join(CODES[letter] for letter in letters)), letters, names)


@dataclass
class _Gathered:
    fixes: list[tuple[float, ...]] = field(default_factory=list)
    velocities: list[tuple[float, ...]] = field(default_factory=list)
    events: list[tuple[float, Message]] = field(default_factory=list)
    arming: list[tuple[float, bool]] = field(default_factory=list)
    modes: list[tuple[float, int]] = field(default_factory=list)
    items: dict[int, Item] = field(default_factory=dict)
    batteries: dict[int, list[Battery]] = field(default_factory=dict)
    attitude: list[tuple[float, ...]] = field(default_factory=list)
    kinds: set[str] = field(default_factory=set)
    begins: float | None = None
    opened_by_arming: bool = True
    vehicle: str = ""
    version: str = ""


def read_copter_log(path: Path) -> Log:
    """Read positions (POS), arming, modes, items begun (MISE; before 4.5 MSG), mission, parameters; raise BadInput."""
    gathered = _Gathered()
    torn = Counter[str]()
    for kind, values in read_records(path, KINDS, torn):
        gathered.kinds.add(kind)
        try:
            _note(gathered, kind, values)
        except (KeyError, TypeError, ValueError):  # damaged layout
            torn[kind] += 1
    if gathered.vehicle and gathered.vehicle != "Copter":
        words = f"expected the log of a copter, not of ArduPilot's {gathered.vehicle}"
        raise BadInput(words, code="other-vehicle", place=path)
    if len(gathered.fixes) < 2:
        words = "expected an ArduPilot log with positions (POS), but there are none"
        raise BadInput(words, code="log-incomplete", place=path)
    fixes = _fixes(np.array(gathered.fixes), np.array(gathered.velocities))
    measured = Measured.of(_batteries(gathered), gathered.attitude)
    events = (*_states(gathered), *gathered.events)
    return Log(ARDUCOPTER, fixes, events, gathered.version, tuple(_remarks(gathered, torn)), measured)


def _remarks(gathered: _Gathered, torn: Counter[str]) -> Iterator[str]:
    if count := torn.pop("bytes", 0):
        yield f"{count} bytes of the log are not whole records: it is damaged or truncated"
    for kind, count in sorted(torn.items()):
        yield f"{count} records {kind} do not have ArduPilot's layout and are not read"
    needed = {
        "PARM": "its parameters are unknown",
        "MODE": "its modes are unknown",
        "XKF1 NKF1": "speeds are derived from positions",
    }
    for kinds, lacks in needed.items():
        if not gathered.kinds & set(kinds.split()):
            yield f"the log has no records {kinds.replace(' ', ' or ')}: {lacks}"
    if not gathered.vehicle:
        yield "the log does not name its firmware, as ArduPilot's do when they begin: records are missing"
    changes = sorted(gathered.arming)
    twice = [a for a, b in pairwise(changes) if a[1] == b[1] and b[0] - a[0] > 1.0]  # ARM and EV of one arming
    if twice:
        yield f"the log lacks {count_words(len(twice), 'change')} of arming, the first after {twice[0][0]:.1f} s"


def _note(gathered: _Gathered, kind: str, values: dict[str, Any]) -> None:
    time = values["TimeUS"] / 1e6
    if gathered.begins is None:
        gathered.begins = time
    messages: list[Message] = []
    match kind:
        case "POS":
            gathered.fixes.append((time, *(values[name] for name in ("Lat", "Lng", "Alt", "RelHomeAlt"))))
        case "XKF1" | "NKF1" if values.get("C", 0) == 0:
            gathered.velocities.append((time, values["VN"], values["VE"], values["VD"]))
        case "ATT":
            angles = [math.radians(values[name]) for name in ("Roll", "Pitch", "Yaw")]
            gathered.attitude.append((time, *angles))
        case _ if kind in BATTERIES:
            number = values.get("Inst", values.get("Instance", BATTERIES[kind]))
            unit = 0.01 if "Throttle" in values else 1.0  # 3.3 wrote hundredths
            gathered.batteries.setdefault(number, []).append((time, values["Volt"] * unit, values["Curr"] * unit))
        case "MODE":
            gathered.modes.append((time, values["ModeNum"]))
        case "ARM":
            gathered.arming.append((time, bool(values["ArmState"])))
        case "EV" if values["Id"] in (10, 11):  # armed, disarmed: before 4.1
            gathered.arming.append((time, values["Id"] == 10))
        case "MISE":
            begins = Begun(values["CNum"], values["CTot"], _item(values))
            messages = [begins, Current(begins.seq, begins.total)]
        case "CMD":
            messages = _list(gathered.items, values)
        case "ORGN" if values["Type"] == 1:  # home
            messages = [HomePosition(values["Lat"], values["Lng"], values["Alt"])]
        case "PARM":
            messages = [ParamValue(values["Name"], values["Value"], REAL32, 0, 0)]
            if values["Name"] == "LOG_DISARMED":
                gathered.opened_by_arming = values["Value"] == 0
        case "MSG":
            text = values["Message"]
            begun = item_begun(text)
            messages = [*([begun] if begun else []), Text(INFO, text)]
            # as in "ArduCopter V4.7.0-dev (6a8c9b91)"; before 4.0 "APM:Copter V3.5.7"
            if firmware := re.match(r"(?:Ardu|APM:)(\w+) V(\d[\w.-]*)", text):
                gathered.vehicle, gathered.version = firmware.groups()
    gathered.events += [(time, message) for message in messages]


def _batteries(gathered: _Gathered) -> list[list[Battery]]:
    secondhand = {9, 10, 11, 12, 18, 24, 27}  # BATTn_MONITOR of other batteries (ESCs, sum), or of fuel
    monitors = {message.param_id: message.param_value for _, message in gathered.events if type(message) is ParamValue}
    names = {number: f"BATT{number + 1 if number else ''}_MONITOR" for number in gathered.batteries}
    direct = [rows for number, rows in gathered.batteries.items() if monitors.get(names[number]) not in secondhand]
    return direct or list(gathered.batteries.values())


def _list(items: dict[int, Item], values: dict[str, Any]) -> list[Message]:
    """The vehicle logs all items, home first, with each new list."""
    seq = values["CNum"]
    if seq == 0:
        items.clear()
    items[seq] = _item(values)
    in_order = [items[n] for n in range(values["CTot"]) if n in items]
    return [Held(tuple(in_order))] if len(in_order) == values["CTot"] == seq + 1 else []


def _item(values: dict[str, Any]) -> Item:
    """Before 4.1 altitudes are assumed above home."""
    frame = values.get("Frame", Frame.GLOBAL if values["CNum"] == 0 else Frame.GLOBAL_RELATIVE_ALT)
    params = (values["Prm1"], values["Prm2"], values["Prm3"], values["Prm4"])
    return Item(values["CId"], frame, params, values["Lat"], values["Lng"], values["Alt"])


def _states(gathered: _Gathered) -> list[tuple[float, Message]]:
    """Return a heartbeat for each change; with LOG_DISARMED 0 the log begins armed."""
    begins = gathered.begins or 0.0
    armed = not gathered.arming[0][1] if gathered.arming else gathered.opened_by_arming
    mode = 0
    states: list[tuple[float, Message]] = []
    if not armed or gathered.opened_by_arming:
        states.append((begins, presence(ARDUCOPTER, False, mode)))
    if armed:
        states.append((begins, presence(ARDUCOPTER, True, mode)))
    changes: list[tuple[float, bool | None, int | None]] = [(time, to, None) for time, to in gathered.arming]
    changes += [(time, None, to) for time, to in gathered.modes]
    for time, arming, turned in sorted(changes, key=lambda change: change[0]):
        armed = armed if arming is None else arming
        mode = mode if turned is None else turned
        states.append((time, presence(ARDUCOPTER, armed, mode)))
    return states


def _fixes(rows: Matrix, velocities: Points) -> Matrix:
    rows = in_order(rows)
    times, latitude, longitude, altitude, _ = rows.T
    if len(velocities) > 1:
        velocity = np.column_stack([np.interp(times, velocities[:, 0], axis) for axis in velocities[:, 1:].T])
    else:
        velocity = _differences(times, latitude, longitude, altitude)
    return np.column_stack([rows, velocity])


def _differences(times: Vector, latitude: Vector, longitude: Vector, altitude: Vector) -> Points:
    start = Geodetic(float(latitude[0]), float(longitude[0]), float(altitude[0]))
    places = LocalFrame(start).to_local(latitude, longitude, altitude)
    speeds = np.zeros((len(times), 3))
    sound = np.isfinite(places).all(axis=1)
    if sound.sum() > 1:
        speeds[sound] = np.gradient(places[sound], times[sound], axis=0)
    east, north, up = speeds.T
    return np.column_stack([north, east, -up])


FORMAT = LogFormat(".bin", read_copter_log, "the log does not contain the whole list of flown items")
