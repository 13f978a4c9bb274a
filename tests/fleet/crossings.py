"""Missions of several vehicles about one place."""

from dataclasses import replace

import numpy as np

from ipoa_mission import Geodetic, Mission
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.items import change_speed, land, return_to_launch, takeoff, waypoint

HOME = Geodetic(47.397742, 8.545594, 488.0)
FRAME = LocalFrame(HOME)


def at(east: float, north: float) -> Geodetic:
    return replace(FRAME.geodetic(np.array([east, north, 0.0])), altitude=HOME.altitude)


def route(autopilot: str, *corners: tuple[float, float], up: float = 20.0, returns: bool = False) -> Mission:
    """Return a flight at 8 m/s through corners east and north [m], from the first one to the last, or back by RTL."""
    places = [at(*corner) for corner in corners]
    hold_s = 0.1 if autopilot == "px4" else 0.0
    passed = [waypoint(place, up, hold_s) for place in places[1:]]
    end = return_to_launch() if returns else land(places[-1])
    return Mission(places[0], (takeoff(places[0], up), change_speed(8.0), *passed, end), autopilot_named(autopilot))


def eastward(autopilot: str = "px4") -> Mission:
    return route(autopilot, (0, 0), (50, 0), (200, 0))


def northward(autopilot: str = "ardupilot") -> Mission:
    """Cross `eastward` 100 m east of its home, at about the same time after the departure."""
    return route(autopilot, (100, -100), (100, -50), (100, 100))
