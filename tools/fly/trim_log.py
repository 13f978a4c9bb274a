"""Cut a real log down to the input of `compare` and `learn`, for the tests.

    python -m tools.fly.trim_log LOG TRIMMED [--every S]

Positions, attitudes and batteries (except those of a .tlog) are thinned out to one every S seconds of the vehicle's
clock (default 0.5). Arming, modes, items, texts, home, version and the models' parameters stay, byte for byte.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.link.codec import Codec, read_tlog
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.messages import Attitude, Current, LocalPosition, ParamValue, Position, SystemTime
from ipoa_mission.vehicles.arducopter.log import BATTERIES, FMT, HEAD, KINDS
from ipoa_mission.vehicles.px4_multicopter.log import ATTITUDE, BATTERY, POSITION, TOPICS, VELOCITY
from tools import command_line

TABLES = [vehicle.parameter_table for vehicle in registered()]
PARAMETERS = {"LOG_DISARMED", "SDLOG_MODE"}.union(*(table.moving.keys() | table.renamed.keys() for table in TABLES))
THINNED = (Position, Attitude, LocalPosition, SystemTime)
KEPT = {
    "HEARTBEAT", "STATUSTEXT", "EVENT", "COMMAND_LONG", "COMMAND_INT", "COMMAND_ACK", "MISSION_COUNT",
    "MISSION_REQUEST_LIST", "MISSION_ITEM", "MISSION_ITEM_INT", "MISSION_ACK", "MISSION_CLEAR_ALL", "MISSION_CURRENT",
    "MISSION_ITEM_REACHED", "FILE_TRANSFER_PROTOCOL", "AUTOPILOT_VERSION", "HOME_POSITION", "PARAM_VALUE", "TIMESYNC",
    "SYS_STATUS", "BATTERY_STATUS",
}  # fmt: skip


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("log", type=Path)
    parser.add_argument("trimmed", type=Path)
    parser.add_argument("--every", type=float, default=0.5, metavar="S")
    asked = parser.parse_args()
    trim = {".tlog": trim_tlog, ".bin": trim_dataflash, ".ulg": trim_ulog}[asked.log.suffix.lower()]
    data = b"".join(trim(asked.log, asked.every))
    asked.trimmed.write_bytes(data)
    print(f"{asked.trimmed}: {len(data)} bytes of {asked.log.stat().st_size}")


def trim_tlog(path: Path, every: float) -> Iterator[bytes]:
    codec = Codec(255, 190)
    due: dict[type, float] = {}
    before: object = None
    current: Current | None = None
    for record in read_tlog(path):
        heard = codec.decode(record.frame)
        message = heard.message if heard else None
        if message is None or (isinstance(message, ParamValue) and message.param_id not in PARAMETERS):
            continue
        if isinstance(message, THINNED):
            time = message.boot_s if isinstance(message, SystemTime) else message.time_s
            if time < due.get(type(message), 0.0):
                continue
            due[type(message)] = time + every
        elif wire_name(record.frame) not in KEPT or message in (before, current):
            continue
        before, current = message, message if isinstance(message, Current) else current
        yield round(record.unix_s * 1e6).to_bytes(8, "big") + record.frame


def wire_name(frame: bytes) -> str | None:
    return message_name(int.from_bytes(frame[7:10], "little") if frame[0] == 0xFD else frame[5])


def trim_dataflash(path: Path, every: float) -> Iterator[bytes]:
    data = path.read_bytes()
    formats = {FMT: (89, b"FMT")}
    due: dict[bytes, int] = {}
    at = 0
    while (at := data.find(HEAD, at)) >= 0 and at + 3 <= len(data):
        length, name = formats.get(data[at + 2], (0, b""))
        record = data[at : at + length]
        if not length or len(record) < length:
            at += 1
            continue
        at += length
        if record[2] == FMT:
            name = record[5:9].rstrip(b"\0")
            formats[record[3]] = (record[4], name)
        elif name.decode() in {"POS", "XKF1", "ATT", *BATTERIES}:
            time = int.from_bytes(record[3:11], "little")
            if (name == b"XKF1" and record[11]) or time < due.get(name, 0):
                continue
            due[name] = time + int(every * 1e6)
        elif name == b"PARM" and record[11:27].rstrip(b"\0").decode() not in PARAMETERS:
            continue
        if name == b"FMT" or name.decode() in KINDS:
            yield record


def trim_ulog(path: Path, every: float) -> Iterator[bytes]:
    data = path.read_bytes()
    yield data[:16]
    at = 16
    wanted: dict[int, str] = {}
    due: dict[int, int] = {}
    before: dict[int, bytes] = {}
    while at + 3 <= len(data):
        size, kind = struct.unpack_from("<HB", data, at)
        record, body = data[at : at + 3 + size], data[at + 3 : at + 3 + size]
        at += 3 + size
        match chr(kind):
            case "F" if body.split(b":")[0].decode() not in TOPICS:
                continue
            case "I" | "P" if not is_kept(body):
                continue
            case "M" | "Q" | "R" | "O" | "S" | "C":
                continue
            case "A":
                if body[0] or body[3:].decode() not in TOPICS:
                    continue
                wanted[int.from_bytes(body[1:3], "little")] = body[3:].decode()
            case "D":
                number, time = struct.unpack_from("<HQ", body)
                name = wanted.get(number, "")
                is_thinned = name in (POSITION, VELOCITY, ATTITUDE, BATTERY)
                if not name or (is_thinned and time < due.get(number, 0)) or before.get(number) == body[10:]:
                    continue
                due[number], before[number] = time + int(every * 1e6), body[10:]
        yield record


def is_kept(body: bytes) -> bool:
    name = body[1 : 1 + body[0]].decode().split()[-1]
    return name in PARAMETERS or name in {"sys_name", "ver_sw_release"}


if __name__ == "__main__":
    main()
