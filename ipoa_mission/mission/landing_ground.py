"""The ground where a mission lands: no mission file holds it, so NAME.json has it of the files written with it."""

import json
import math
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from ipoa_mission.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.items import Mission
from ipoa_mission.world.frame import Geodetic, LocalFrame
from ipoa_mission.world.ground import Ground, HighPlace

KEY = "landing_ground_m"
LARGEST = 10_000_000  # of a NAME.json; a larger one is somebody's map [bytes]


def digest(text: str) -> str:
    """What NAME.json remembers of a file that was written with it."""
    return sha256(text.encode()).hexdigest()


def written_with(about: Path) -> dict[str, str]:
    """The digests of the files that NAME.json was written with, by name; none if it is not one of ours."""
    return _digests(_read(about))


def landing_ground(mission: Mission) -> float | None:
    """How high above home the ground is where it lands [m]; None where it does not land, or nothing is known of it."""
    place = _landing_place(mission)
    return None if place is None or mission.ground.is_level else mission.ground.at(*place)


def over_known_ground(mission: Mission, path: Path, text: str) -> Mission:
    """The mission that a file at `path` holds, over the ground that NAME.json knows of it, if that is of this text."""
    told = _read(path.with_suffix(".json"))
    height = told.get(KEY)
    if not isinstance(height, float) or not math.isfinite(height) or _digests(told).get(path.name) != digest(text):
        return mission
    return landing_on(mission, height)


def landing_on(mission: Mission, height: float) -> Mission:
    """The mission where the ground is so high above home [m] where it lands, and as high as home elsewhere."""
    place = _landing_place(mission)
    return mission if place is None else replace(mission, ground=Ground(HighPlace(place, height)))


def _landing_place(mission: Mission) -> tuple[float, float] | None:
    commands = [item.command for item in mission.items]
    if Command.NAV_LAND not in commands:
        return None
    for item in reversed(mission.items[: commands.index(Command.NAV_LAND) + 1]):
        if item.has_position:
            there = Geodetic(item.latitude_deg, item.longitude_deg, mission.home.altitude)
            east, north, _ = LocalFrame(mission.home).local(there)
            return float(east), float(north)
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
