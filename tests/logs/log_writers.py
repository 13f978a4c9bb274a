"""Write one flight as a ground station, ArduPilot and PX4 log it: FMT records, and ULog version 1."""

import struct
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link.codec import EVERYONE, Codec, TlogWriter
from ipoa_mission.link.messages import (
    ARMED_FLAG,
    NO_AUTOPILOT,
    CommandAck,
    CommandResult,
    Current,
    Heartbeat,
    Message,
    Position,
    Reached,
    Text,
)

ZERO = 100.0  # the autopilot's clock when the flight begins [s]
RATE = 10.0  # positions a second


@dataclass(frozen=True)
class Flown:
    """Times from arming [s], positions (n, 3) as degrees and height, speed north; done by item index."""

    times: NDArray[np.float64]
    latitude_deg: NDArray[np.float64]
    longitude_deg: NDArray[np.float64]
    height: NDArray[np.float64]
    velocity: NDArray[np.float64]  # (n, 3) north, east, down
    home_altitude: float
    done: Mapping[int, float]
    landed_s: float


def write_tlog(flown: Flown, path: Path, ardupilot: bool) -> None:
    """As our client: heartbeats once a second, start, reached items, positions."""
    first, firmware, mode = (
        (1, Autopilot.ARDUPILOT.mav_autopilot, 3) if ardupilot else (0, Autopilot.PX4.mav_autopilot, 4 << 16 | 4 << 24)
    )
    messages: list[tuple[float, Message]] = [(0.0, CommandAck(400, CommandResult.ACCEPTED))]
    for beat in np.arange(-2.63, flown.landed_s + 3.0, 1.0):
        armed = ARMED_FLAG if 0 <= beat < flown.landed_s else 0
        messages.append((beat, Heartbeat(2, firmware, armed | 1, mode if beat >= 0 else 0)))
    messages.append((flown.landed_s, Heartbeat(2, firmware, 1, mode)))
    for index, time in flown.done.items():
        messages += [(time, Reached(index + first)), (time, Current(index + first + 1))]
    messages.append((1.0, Text(6, "Takeoff")))
    messages += [(time, _position(flown, time)) for time, _ in messages]  # independent of the telemetry rate
    messages += [(float(time), _position(flown, float(time))) for time in flown.times]
    codec = Codec(7, 1)
    with closing(TlogWriter(path)) as log:
        log.write(Codec(245, 190).encode(Heartbeat(6, NO_AUTOPILOT), EVERYONE, 0.0), 1.7e9)
        for time, message in sorted(messages, key=lambda timed: (timed[0], not isinstance(timed[1], Position))):
            log.write(codec.encode(message, EVERYONE, 0.0), 1.7e9 + time)


def write_dataflash(flown: Flown, path: Path, executed: bool = True) -> None:
    """`executed`: with MISE (4.5 and later), otherwise with words only."""
    records: list[tuple[float, str, tuple[object, ...]]] = [(-3.0, "MODE", (0, 0, 2)), (-0.5, "MODE", (3, 3, 2))]
    records += [(0.0, "ARM", (1, 0xFFFF, 0, 0)), (flown.landed_s, "ARM", (0, 0, 0, 0))]
    begun = {0: 0.0} | {index + 1: time for index, time in flown.done.items()}
    for index, time in begun.items():
        if executed:
            records.append((time, "MISE", (len(begun) + 1, index + 1, 16, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, 3)))
        records.append((time, "MSG", (f"Mission: {index + 1} WP".encode(),)))
    records.append((1.0, "MSG", (b"Takeoff",)))
    for n, time in enumerate(flown.times):
        lat, lng = round(flown.latitude_deg[n] * 1e7), round(flown.longitude_deg[n] * 1e7)
        height = float(flown.height[n])
        records.append((float(time), "POS", (lat, lng, flown.home_altitude + height, height, height)))
        records.append((float(time), "XKF1", (0, *map(float, flown.velocity[n]))))
        records.append((float(time), "XKF1", (1, 9.0, 9.0, 9.0)))  # the other core's opinion
    head = b"\xa3\x95"
    data = b""
    for kind, (number, layout, form, columns) in FORMATS.items():
        length = 3 + struct.calcsize("<" + layout)
        data += head + struct.pack("<BBB4s16s64s", 128, number, length, kind.encode(), form.encode(), columns.encode())
    for time, kind, values in sorted(records, key=lambda record: record[0]):
        number, layout, *_ = FORMATS[kind]
        data += head + struct.pack("<B" + layout, number, round((ZERO + time) * 1e6), *values)
    path.write_bytes(data)


#: Number, struct layout, ArduPilot's format characters, columns.
FORMATS = {
    "FMT": (128, "BB4s16s64s", "BBnNZ", "Type,Length,Name,Format,Columns"),
    "POS": (11, "Qiifff", "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt"),
    "XKF1": (12, "QBfff", "QBfff", "TimeUS,C,VN,VE,VD"),
    "MODE": (13, "QBBB", "QMBB", "TimeUS,Mode,ModeNum,Rsn"),
    "ARM": (14, "QBIBB", "QBIBB", "TimeUS,ArmState,ArmChecks,Forced,Method"),
    "MSG": (15, "Q64s", "QZ", "TimeUS,Message"),
    "MISE": (16, "QHHHffffiifB", "QHHHffffLLfB", "TimeUS,CTot,CNum,CId,Prm1,Prm2,Prm3,Prm4,Lat,Lng,Alt,Frame"),
}


def write_ulog(flown: Flown, path: Path) -> None:
    """Padding at the end of a topic is in its format and not in its rows."""
    n = len(flown.times)
    places = zip(flown.times, flown.latitude_deg, flown.longitude_deg, flown.height + flown.home_altitude, strict=True)
    reached = [(0.0, (-1, 0)), *((time, (index, index + 1)) for index, time in flown.done.items())]
    topics: dict[str, tuple[str, str, list[tuple[float, ...]]]] = {
        "vehicle_global_position": (
            "double lat;double lon;float alt;uint8_t[4] _padding0;",
            "<Qddf",
            [(_us(t), lat, lon, alt) for t, lat, lon, alt in places],
        ),
        "vehicle_local_position": (
            "float vx;float vy;float vz;uint8_t[4] _padding0;",
            "<Qfff",
            [(_us(flown.times[i]), *map(float, flown.velocity[i])) for i in range(n)],
        ),
        "vehicle_status": (
            "uint8_t arming_state;uint8_t nav_state;uint8_t[6] _padding0;",
            "<QBB",
            [(_us(t), *state) for t, state in ((-1.0, (1, 3)), (0.0, (2, 3)), (flown.landed_s, (1, 3)))],
        ),
        "mission_result": (
            "int32_t seq_reached;uint16_t seq_current;uint16_t seq_total;bool finished;uint8_t[7] _padding0;",
            "<QiHHB",
            [(_us(t), *seqs, len(flown.done), False) for t, seqs in reached],
        ),
        "home_position": (
            "double lat;double lon;float alt;uint8_t[4] _padding0;",
            "<Qddf",
            [(_us(-1.0), flown.latitude_deg[0], flown.longitude_deg[0], flown.home_altitude)],
        ),
    }
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", _us(-2.0))
    data += _ulog_record(b"B", bytes(40))
    for name, (fields, _, _) in topics.items():
        data += _ulog_record(b"F", f"{name}:uint64_t timestamp;{fields}".encode())
    for number, name in enumerate(topics):
        data += _ulog_record(b"A", struct.pack("<BH", 0, number) + name.encode())
    rows = [
        (row[0], struct.pack("<H", number) + struct.pack(layout, *row))
        for number, (_, layout, written) in enumerate(topics.values())
        for row in written
    ]
    for _, row in sorted(rows, key=lambda timed: timed[0]):
        data += _ulog_record(b"D", row)
    data += _ulog_record(b"L", b"6" + struct.pack("<Q", _us(1.0)) + b"Takeoff")
    path.write_bytes(data)


WRITERS: Mapping[str, Callable[[Flown, Path], None]] = {
    "ardupilot.tlog": lambda flown, path: write_tlog(flown, path, ardupilot=True),
    "px4.tlog": lambda flown, path: write_tlog(flown, path, ardupilot=False),
    "ardupilot.bin": write_dataflash,
    "ardupilot-words.bin": lambda flown, path: write_dataflash(flown, path, executed=False),
    "px4.ulg": write_ulog,
}


def _us(time: float) -> int:
    return round((ZERO + float(time)) * 1e6)


def _ulog_record(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<H", len(content)) + kind + content


def _position(flown: Flown, time: float) -> Position:
    columns = (flown.latitude_deg, flown.longitude_deg, flown.home_altitude + flown.height, flown.height)
    place = [float(np.interp(time, flown.times, column)) for column in columns]
    north, east, down = (float(np.interp(time, flown.times, axis)) for axis in flown.velocity.T)
    return Position(ZERO + time, place[0], place[1], place[2], place[3], (north, east, down))
