"""Change flight logs: cuts, holes, damaged, doubled or moved blocks, renamed fields, lost records."""

import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.link.codec import read_tlog
from ipoa_mission.logs.flight_log import LoggedFlight, read_flights
from tools import REPOSITORY
from tools.fuzz.outcome import Reading

LOGS = REPOSITORY / "tests" / "logs"
SOURCES = {
    ".tlog": ("sitl-ardupilot.tlog", "twice-ardupilot.tlog", "other_vehicle-0.tlog"),
    ".bin": ("sitl-ardupilot.bin", "twice-ardupilot.bin", "n4_slow-ardupilot.bin"),
    ".ulg": ("sitl-px4.ulg",),
}
#: Names in the files' own definitions, and others of the same length.
RENAMED = {
    ".bin": (b"Lat", b"Lng", b"RelHomeAlt", b"ModeNum", b"CTot", b"Prm1", b"POS", b"MODE", b"MISE", b"PARM", b"CMD",
             b"XKF1"),
    ".ulg": (b"vehicle_status", b"vehicle_global_position", b"vehicle_local_position", b"mission_result",
             b"home_position", b"nav_state", b"arming_state", b"seq_reached", b"lat", b"alt", b"timestamp",
             b"armed_time"),
}  # fmt: skip


class Flown:
    def __init__(self, flights: tuple[LoggedFlight, ...]) -> None:
        self.flights = [_told(flight) for flight in flights]

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Flown)
            and len(self.flights) == len(other.flights)
            and all(map(_alike, self.flights, other.flights))
        )

    __hash__ = None  # type: ignore[assignment]


def _told(flight: LoggedFlight) -> dict[str, Any]:
    record = flight.record(flight.mission)
    path = np.array([(at.time_s, at.latitude_deg * 1e5, at.longitude_deg * 1e5, at.height) for at in record.path])
    return {
        "path": path.reshape(-1, 4), "items": record.item_reached_s, "total": record.total_s, "done": record.completed,
        "mission": flight.mission and repr(flight.mission.items), "parameters": dict(flight.parameters),
        "in mission": flight.in_mission,
    }  # fmt: skip


def _alike(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Return whether two flights agree: times to 0.5 s, places to about 3 m."""
    same = all(before[key] == after[key] for key in ("mission", "parameters", "in mission", "done"))
    same = same and before["items"].keys() == after["items"].keys() and abs(before["total"] - after["total"]) < 0.5
    same = same and all(abs(before["items"][seq] - time) < 0.5 for seq, time in after["items"].items())
    if not same or len(before["path"]) < 2 or len(after["path"]) < 2:
        return same and len(before["path"]) == len(after["path"])
    at = np.arange(before["path"][0, 0], before["path"][-1, 0], 1.0)
    paths = [
        np.column_stack([np.interp(at, path[:, 0], axis) for axis in path[:, 1:].T])
        for path in (before["path"], after["path"])
    ]
    return bool((np.abs(paths[0] - paths[1]) < 3.0).all())


def read_log(path: Path) -> Reading:
    log = read_flights(path)
    unknown = [f"flight {n}: no mission" for n, f in enumerate(log.flights) if f.in_mission and f.mission is None]
    return Reading(Flown(log.flights), frozenset([*log.remarks, *unknown]))  # `compare` and `learn` report the latter


@cache
def _bytes(name: str) -> bytes:
    return (LOGS / name).read_bytes()


@cache
def _records(name: str) -> list[bytes]:
    return [round(record.unix_s * 1e6).to_bytes(8, "big") + record.frame for record in read_tlog(LOGS / name)]


def changed(suffix: str, chance: random.Random, _: Path) -> tuple[str, bytes, bytes]:
    name = chance.choice(SOURCES[suffix])
    data = _bytes(name)
    # .bin and .ulg have no checksums: one wrong byte of a value is not detectable
    at, size = chance.randrange(8, len(data)), chance.choice([1, 16, 200, 2000] if suffix == ".tlog" else [200, 2000])
    change = chance.choice(["cut", "hole", "zeros", "noise", "double", "late", "records", "rename", "again"])
    match change:
        case "cut":
            return change, data, data[:at]
        case "late":
            return change, data, data[at:]
        case "hole":
            return change, data, data[:at] + data[at + size :]
        case "zeros" | "noise":
            block = bytes(size) if change == "zeros" else chance.randbytes(size)
            return change, data, (data[:at] + block + data[at + size :])[: len(data)]
        case "double":
            return change, data, data[: at + size] + data[at:]
        case "records" if suffix == ".tlog":
            return change, data, _other_records(name, chance)
        case "rename" if suffix in RENAMED:
            key = chance.choice(RENAMED[suffix])
            return change, data, data.replace(key, key[:-2] + key[-1:] + key[-2:-1])
        case _:
            return "again", data, data + data


def _other_records(name: str, chance: random.Random) -> bytes:
    """Return a `.tlog` with records lost, doubled, moved, or added from another vehicle."""
    records = list(_records(name))
    at, count = chance.randrange(1, len(records) - 1), chance.choice([1, 3, 20])
    match chance.randrange(4):
        case 0:
            del records[at : min(at + count, len(records) - 1)]  # not the end, whose loss is not detectable
        case 1:
            records[at:at] = records[at : at + count]
        case 2:
            records[at - 1 : at + 1] = records[at - 1 : at + 1][::-1]
        case _:
            others = _records("again-px4.tlog")
            return b"".join(record for pair in zip(records, others, strict=False) for record in pair)
    return b"".join(records)
