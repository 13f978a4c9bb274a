"""Read the NAME.json that the planner writes next to a mission."""

import json
import math
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text

LANDING_GROUND_KEY = "landing_ground_m"


def digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def written_with(about: Path) -> tuple[dict[str, str], object]:
    """Return the digests of NAME.json by file name, and its parameters; nothing if it is not ours."""
    record = _read(about)
    return _digests(record), record.get("parameters", {})


class MissionRecord(NamedTuple):
    """`landing_height`: above home [m]; `planned`: the NAME.json's name and flight time [s]."""

    landing_height: float | None = None
    planned: tuple[str, float] | None = None
    autopilot: str | None = None


def mission_record(path: Path, text: str) -> MissionRecord:
    """Return the data of the NAME.json next to `path`, if its digest matches `text`."""
    same_name = path.with_suffix(".json")
    for about in (same_name, path.with_name(f"{path.stem.rpartition('-')[0]}.json")):
        record = _read(about)
        if not record or _digests(record).get(path.name) != digest(text):
            continue
        height, flights, estimate = record.get(LANDING_GROUND_KEY), record.get("flights"), record.get("estimate")
        parts = [part for part in flights if isinstance(part, dict)] if isinstance(flights, list) else []
        times = [part.get("time_s") for part in parts if part.get("file") == path.with_suffix(".plan").name]
        times += [estimate.get("total_s")] if isinstance(estimate, dict) and not parts else []
        time_s = next(map(_finite, times), None)
        planned = None if time_s is None else (about.name, time_s)
        firmware = record.get("firmware")
        autopilot = firmware.get("autopilot") if isinstance(firmware, dict) else None
        autopilot = autopilot if isinstance(autopilot, str) else None
        return MissionRecord(_finite(height) if about == same_name else None, planned, autopilot)
    return MissionRecord()


def _finite(value: object) -> float | None:
    return value if isinstance(value, float) and math.isfinite(value) else None


def _read(about: Path) -> dict[str, object]:
    try:
        record = json.loads(read_text(about)) if about.is_file() and about.stat().st_size < 10_000_000 else {}
    except (BadInput, OSError, ValueError, RecursionError):
        return {}
    return record if isinstance(record, dict) else {}


def _digests(record: dict[str, object]) -> dict[str, str]:
    digests = record.get("sha256")
    return digests if isinstance(digests, dict) else {}
