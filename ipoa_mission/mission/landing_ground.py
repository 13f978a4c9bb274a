import math
from dataclasses import replace

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.returning import ReturnOrder
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.ground import FLAT_GROUND, Ground, HighPlace
from ipoa_mission.mission.items import Mission


def landing_height(mission: Mission) -> float | None:
    """Return height above home [m], if known."""
    known = mission.landing_ground
    place = landing_place(mission)
    if known is None or place is None:
        return None
    away_m = math.dist(place, _local(mission, known.latitude_deg, known.longitude_deg))
    return known.altitude if away_m <= 0.1 else None


def landing_ground_entry(mission: Mission) -> dict[str, float]:
    height = landing_height(mission)
    ground = landing_on(mission, height).landing_ground if height else None
    if ground is None:
        return {}
    latitude = round(ground.latitude_deg, 9)
    return {"aboveHome": ground.altitude, "latitude": latitude, "longitude": round(ground.longitude_deg, 9)}


def known_ground(mission: Mission) -> Ground:
    height = landing_height(mission)
    place = landing_place(mission)
    return FLAT_GROUND if height is None or place is None else Ground(HighPlace(place, height))


def landing_on(mission: Mission, height: float) -> Mission:
    place = landing_place(mission)
    if place is None:
        return mission
    there = mission.frame.geodetic(np.array([*place, 0.0]))
    return replace(mission, landing_ground=Geodetic(there.latitude_deg, there.longitude_deg, height))


def landing_over(mission: Mission, ground: Ground) -> Mission:
    place = None if ground.is_flat else landing_place(mission)
    return replace(mission, landing_ground=None) if place is None else landing_on(mission, ground.at(*place))


def landing_place(mission: Mission) -> tuple[float, float] | None:
    """Return east and north of home [m]; None: at home or nowhere."""
    commands = [item.command for item in mission.items]
    if Command.NAV_LAND in commands:
        return _last_place(mission, commands.index(Command.NAV_LAND))
    if Command.NAV_RETURN_TO_LAUNCH not in commands or not mission.rally:
        return None
    here = _last_place(mission, commands.index(Command.NAV_RETURN_TO_LAUNCH)) or (0.0, 0.0)
    parameters = mission.complete_parameters
    rally = [(*_local(mission, place.latitude_deg, place.longitude_deg), 0.0) for place in mission.rally]
    order = ReturnOrder((*here, 0.0), rally, version=mission.firmware_version)
    route = mission.autopilot.return_route(parameters, order)
    return None if route.rally is None else rally[route.rally][:2]


def _last_place(mission: Mission, index: int) -> tuple[float, float] | None:
    placed = (item for item in reversed(mission.items[: index + 1]) if item.has_position)
    return next((_local(mission, item.latitude_deg, item.longitude_deg) for item in placed), None)


def _local(mission: Mission, latitude: float, longitude: float) -> tuple[float, float]:
    east, north, _ = mission.frame.local(Geodetic(latitude, longitude, mission.home.altitude))
    return float(east), float(north)
