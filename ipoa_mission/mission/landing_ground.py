"""The ground where a mission lands: a `.plan` of ours holds it, NAME.json has it of the files written with it.

Ground stations pass over what a `.plan` says of it, and leave it out where they write the file anew.
"""

import json
import math
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from ipoa_mission.commands import Command
from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.items import Mission
from ipoa_mission.world.frame import Geodetic, LocalFrame
from ipoa_mission.world.ground import Ground, HighPlace

KEY = "landing_ground_m"
SAME_PLACE = 0.1  # [m]
LARGEST = 10_000_000  # of a NAME.json; a larger one is somebody's map [bytes]


def digest(text: str) -> str:
    """What NAME.json remembers of a file that was written with it."""
    return sha256(text.encode()).hexdigest()


def written_with(about: Path) -> dict[str, str]:
    """The digests of the files that NAME.json was written with, by name; none if it is not one of ours."""
    return _digests(_read(about))


def landing_ground(mission: Mission) -> float | None:
    """How high above home the ground is where it lands [m]; None where it does not land, or nothing is known of it."""
    place = landing_place(mission)
    return None if place is None or mission.ground.is_level else mission.ground.at(*place)


def told_in_plan(mission: Mission) -> dict[str, float]:
    """What a `.plan` says of it: where it lands, and how high above home the ground is there; nothing where level."""
    height, place = landing_ground(mission), landing_place(mission)
    if not height or place is None:
        return {}
    there = LocalFrame(mission.home).geodetic(np.array([*place, 0.0]))
    return {"aboveHome": height, "latitude": round(there.latitude_deg, 9), "longitude": round(there.longitude_deg, 9)}


def over_told_ground(mission: Mission, above_home: float, latitude: float, longitude: float) -> Mission:
    """The mission over the ground that its `.plan` tells, unless it now lands elsewhere."""
    place = landing_place(mission)
    there = LocalFrame(mission.home).local(Geodetic(latitude, longitude, mission.home.altitude))
    if place is None or math.dist(place, (float(there[0]), float(there[1]))) > SAME_PLACE:
        return mission
    return landing_on(mission, above_home)


def over_known_ground(mission: Mission, path: Path, text: str) -> Mission:
    """The mission that a file at `path` holds, over the ground that NAME.json knows of it, if that is of this text."""
    if not mission.ground.is_level:
        return mission
    told = _read(path.with_suffix(".json"))
    height = told.get(KEY)
    if not isinstance(height, float) or not math.isfinite(height) or _digests(told).get(path.name) != digest(text):
        return mission
    return landing_on(mission, height)


def landing_on(mission: Mission, height: float) -> Mission:
    """The mission where the ground is so high above home [m] where it lands, and as high as home elsewhere."""
    place = landing_place(mission)
    return mission if place is None else replace(mission, ground=Ground(HighPlace(place, height)))


def landing_place(mission: Mission) -> tuple[float, float] | None:
    """Where it lands, east and north of home [m]: by LAND, or by RTL at a rally point; None: at home, or nowhere."""
    commands = [item.command for item in mission.items]
    if Command.NAV_LAND in commands:
        return _last_place(mission, commands.index(Command.NAV_LAND))
    if Command.NAV_RETURN_TO_LAUNCH not in commands or not mission.rally:
        return None
    here = _last_place(mission, commands.index(Command.NAV_RETURN_TO_LAUNCH)) or (0.0, 0.0)
    parameters = mission.autopilot.book.complete(mission.parameters)
    rally = [(*_local(mission, place.latitude_deg, place.longitude_deg), 0.0) for place in mission.rally]
    chosen = mission.autopilot.goal_of_return(parameters, (*here, 0.0), rally)
    return None if chosen is None else rally[chosen][:2]


def _last_place(mission: Mission, index: int) -> tuple[float, float] | None:
    """The place of item `index`, or of the last one before it that has any."""
    for item in reversed(mission.items[: index + 1]):
        if item.has_position:
            return _local(mission, item.latitude_deg, item.longitude_deg)
    return None


def _local(mission: Mission, latitude: float, longitude: float) -> tuple[float, float]:
    east, north, _ = LocalFrame(mission.home).local(Geodetic(latitude, longitude, mission.home.altitude))
    return float(east), float(north)


def _read(about: Path) -> dict[str, object]:
    try:
        told = json.loads(read_text(about)) if about.is_file() and about.stat().st_size < LARGEST else {}
    except (BadInput, OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _digests(told: dict[str, object]) -> dict[str, str]:
    digests = told.get("sha256")
    return digests if isinstance(digests, dict) else {}
