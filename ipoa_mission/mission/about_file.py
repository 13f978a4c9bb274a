"""NAME.json, as far as it is read again: digests of the files written with it, where they land, what time they take."""

import json
import math
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

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


class Told(NamedTuple):
    """What a NAME.json says of a mission file that was written with it.

    `landing_height`: how high above home [m] the ground is where it lands; `planned`: which NAME.json, and how long
    that has the flight [s]; `autopilot`: for which it was written.
    """

    landing_height: float | None = None
    planned: tuple[str, float] | None = None
    autopilot: str | None = None


def told_beside(path: Path, text: str) -> Told:
    """What the NAME.json beside the mission at `path` says of it, if it is of this very text.

    Of a flight that was split there is one about all its parts, which knows where the whole lands.
    """
    own = path.with_suffix(".json")
    for about in (own, path.with_name(f"{path.stem.rpartition('-')[0]}.json")):
        told = _read(about)
        if not told or _digests(told).get(path.name) != digest(text):
            continue
        height, flights, whole = told.get(KEY), told.get("flights"), told.get("estimate")
        parts = [one for one in flights if isinstance(one, dict)] if isinstance(flights, list) else []
        times = [one.get("time_s") for one in parts if one.get("file") == path.with_suffix(".plan").name]
        times += [whole.get("total_s")] if isinstance(whole, dict) and not parts else []
        time_s = next(map(_finite, times), None)
        planned = None if time_s is None else (about.name, time_s)
        firmware = told.get("firmware")
        autopilot = firmware.get("autopilot") if isinstance(firmware, dict) else None
        named = autopilot if isinstance(autopilot, str) else None
        return Told(_finite(height) if about == own else None, planned, named)
    return Told()


def _finite(value: object) -> float | None:
    return value if isinstance(value, float) and math.isfinite(value) else None


def _read(about: Path) -> dict[str, object]:
    try:
        told = json.loads(read_text(about)) if about.is_file() and about.stat().st_size < LARGEST else {}
    except (BadInput, OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _digests(told: dict[str, object]) -> dict[str, str]:
    digests = told.get("sha256")
    return digests if isinstance(digests, dict) else {}
