"""NAME.json, as far as it is read again: digests of the files written with it, where they land, what time they take."""

import json
import math
from hashlib import sha256
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text

KEY = "landing_ground_m"
LARGEST = 10_000_000  # of a NAME.json; a larger one is somebody's map [bytes]


def digest(text: str) -> str:
    """What NAME.json remembers of a file that was written with it."""
    return sha256(text.encode()).hexdigest()


def written_with(about: Path) -> dict[str, str]:
    """The digests of the files that NAME.json was written with, by name; none if it is not one of ours."""
    return _digests(_read(about))


def landing_height_beside(path: Path, text: str) -> float | None:
    """How high above home NAME.json has the ground where the mission at `path` lands, if it is of this very text."""
    told = _read(path.with_suffix(".json"))
    height = told.get(KEY)
    is_of_it = _digests(told).get(path.name) == digest(text)
    return height if is_of_it and isinstance(height, float) and math.isfinite(height) else None


def planned_time_beside(path: Path, text: str) -> tuple[str, float] | None:
    """Which NAME.json was written with the mission at `path`, if it is of this very text, and how long that has it [s].

    Of a flight that was split there is one about all its parts.
    """
    for about in (path.with_suffix(".json"), path.with_name(f"{path.stem.rpartition('-')[0]}.json")):
        told = _read(about)
        if _digests(told).get(path.name) != digest(text):
            continue
        flights, whole = told.get("flights"), told.get("estimate")
        parts = [one for one in flights if isinstance(one, dict)] if isinstance(flights, list) else []
        times = [one.get("time_s") for one in parts if one.get("file") == path.with_suffix(".plan").name]
        times += [whole.get("total_s")] if isinstance(whole, dict) and not parts else []
        if times and isinstance(times[0], int | float) and math.isfinite(times[0]):
            return about.name, float(times[0])
    return None


def _read(about: Path) -> dict[str, object]:
    try:
        told = json.loads(read_text(about)) if about.is_file() and about.stat().st_size < LARGEST else {}
    except (BadInput, OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _digests(told: dict[str, object]) -> dict[str, str]:
    digests = told.get("sha256")
    return digests if isinstance(digests, dict) else {}
