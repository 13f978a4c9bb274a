"""Compute the mission time that QGroundControl shows, distance over speed.

* Take-off: its height over the ascent speed.
* Legs: great circles over the hover speed; DO_CHANGE_SPEED counts from the next item.
* RTL: the way home, and the height over the descent speed (4.4 has these swapped).
* Structure scan: its height as distance.
"""

import math

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.mission.items import Mission

COUNTED_TERMS = (
    "distance over speed, climb of the take-off, holds, RTL's descent; no take-off delay, no landing, no corner"
)
# QGroundControl's settings for planning without a vehicle [m/s].
HOVER_SPEED = 5.0
ASCENT_SPEED = 3.0
DESCENT_SPEED = 1.0
QT_EARTH_RADIUS = 6_371_007.0  # QGeoCoordinate::distanceTo [m]

DELAYS = frozenset({Command.NAV_WAYPOINT, Command.NAV_DELAY, Command.CONDITION_DELAY})


def qgroundcontrol_time(mission: Mission) -> float:
    speed = mission.cruise_speed or HOVER_SPEED
    here, height, total = (mission.home.latitude_deg, mission.home.longitude_deg), 0.0, 0.0
    taken_off, scanned = False, dict(mission.scanned)
    for index, item in enumerate(mission.items):
        total += scanned.get(index, 0.0) / speed
        if item.command == Command.NAV_RETURN_TO_LAUNCH:
            way_home = _great_circle(here, (mission.home.latitude_deg, mission.home.longitude_deg))
            return total + way_home / speed + abs(height) / DESCENT_SPEED
        if item.command == Command.NAV_TAKEOFF and not taken_off:
            total += abs(item.height(mission.home)) / ASCENT_SPEED
            taken_off = True
        if item.command in DELAYS and item.params[0] > 0:
            total += item.params[0]
        if item.has_position:
            there = (item.latitude_deg, item.longitude_deg)
            total += _great_circle(here, there) / speed
            here, height = there, item.height(mission.home)
        if item.command == Command.DO_CHANGE_SPEED and item.params[1] > 0:
            speed = item.params[1]
    return total


def _great_circle(one: tuple[float, float], other: tuple[float, float]) -> float:
    (lat1, lon1), (lat2, lon2) = (tuple(map(math.radians, place)) for place in (one, other))
    half = math.sin((lat2 - lat1) / 2) ** 2 + math.cos(lat1) * math.cos(lat2) * math.sin((lon2 - lon1) / 2) ** 2
    return 2 * QT_EARTH_RADIUS * math.asin(math.sqrt(half))
