"""The plainest model that deserves the name: every leg from rest to rest, speed a trapezoid over time.

The first word on a mission's time, until the models of the two autopilots take over.
"""

import math

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.mission.items import Command
from ipoa_mission.timing.itinerary import Itinerary
from ipoa_mission.timing.prediction import Prediction, Track
from ipoa_mission.vehicle import Autopilot, Parameters

SPOOL_UP = 4.0  # from arming to airborne [s]
LANDING_DETECTION = 2.0  # [s]


def fly_trapezoids(route: Itinerary, autopilot: Autopilot, parameters: Parameters) -> Prediction:
    """Fly the itinerary leg by leg under cruise, climb and acceleration limits."""
    p = parameters
    if autopilot is Autopilot.ARDUPILOT:
        cruise, accel = p["WPNAV_SPEED"] / 100, p["WPNAV_ACCEL"] / 100
        up, down, landing = p["WPNAV_SPEED_UP"] / 100, p["WPNAV_SPEED_DN"] / 100, p["LAND_SPEED"] / 100
        return_height, slow_below, takeoff = p["RTL_ALT"] / 100, p["LAND_ALT_LOW"] / 100, up
        loiter, top = p["RTL_LOIT_TIME"] / 1000, math.inf
    else:
        cruise, accel, top = p["MPC_XY_CRUISE"], p["MPC_ACC_HOR"], p["MPC_XY_VEL_MAX"]
        up, down, landing = p["MPC_Z_V_AUTO_UP"], p["MPC_Z_V_AUTO_DN"], p["MPC_LAND_SPEED"]
        return_height, slow_below, takeoff = p["RTL_RETURN_ALT"], p["MPC_LAND_ALT2"], p["MPC_TKO_SPEED"]
        loiter = p["RTL_LAND_DELAY"]

    here, now = np.zeros(3), 0.0
    times, points, done, reasons = [0.0], [here], [], []

    def wait(seconds: float) -> None:
        nonlocal now
        now += max(seconds, 0.0)
        times.append(now)
        points.append(here)

    def go(there: np.ndarray, climb: float) -> bool:
        nonlocal here
        leg = there - here
        flat, rise = float(np.hypot(leg[0], leg[1])), abs(float(leg[2]))
        time = max(_trapezoid(flat, cruise, accel), _trapezoid(rise, climb if leg[2] > 0 else down, accel))
        here = there
        wait(time)
        return flat > 0 and flat < cruise**2 / accel

    def come_down() -> None:
        nonlocal here
        low = min(float(here[2]), slow_below)
        go(np.array([here[0], here[1], low]), up)
        here = np.array([here[0], here[1], 0.0])
        wait(low / landing + LANDING_DETECTION)

    for visit, place in zip(route.visits, route.places, strict=True):
        item, why = visit.item, ""
        there = np.where(np.isnan(place), here, place)
        match item.command:
            case Command.NAV_TAKEOFF:
                wait(SPOOL_UP)
                go(there, takeoff)
            case Command.NAV_WAYPOINT | Command.NAV_SPLINE_WAYPOINT | Command.NAV_LOITER_TIME:
                if go(there, up):
                    why = "leg shorter than its braking distance"
                if item.params[0] > 0:
                    wait(item.params[0])
                    why = "hold"
            case Command.NAV_DELAY:
                wait(item.params[0])
            case Command.DO_CHANGE_SPEED if item.params[1] > 0:
                cruise = min(item.params[1], top)
            case Command.NAV_RETURN_TO_LAUNCH:
                go(np.array([here[0], here[1], max(here[2], return_height)]), up)
                go(np.array([0.0, 0.0, here[2]]), up)
                wait(loiter)
                come_down()
            case Command.NAV_LAND:
                go(np.array([there[0], there[1], here[2]]), up)
                come_down()
            case Command.NAV_LOITER_UNLIM:
                raise BadInput(f"items[{visit.seq - 1}]: loiters without end, so the flight has no time")
        done.append(now)
        reasons.append(why)
    track = np.array(points)
    steps = np.diff(times, prepend=-1.0)
    lengths = np.linalg.norm(np.diff(track, axis=0, prepend=track[:1]), axis=1)
    speeds = np.divide(lengths, steps, out=np.zeros_like(lengths), where=steps > 0)
    return Prediction(tuple(done), tuple(reasons), Track(np.array(times), track, speeds))


def _trapezoid(distance: float, speed: float, accel: float) -> float:
    if distance <= 0:
        return 0.0
    return distance / speed + speed / accel if distance > speed**2 / accel else 2 * math.sqrt(distance / accel)
