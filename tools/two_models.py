"""Hold ArduCopter's estimate against the built-in autopilot over random missions: two models written apart.

python tools/two_models.py [FROM TO]          by default 0 to 200; prints every case that differs, and a summary

Both fly without noise. A case differs by more than 5 % and 0.5 s from take-off to the last waypoint, or by more than
8 % and a second and a half in take-off or landing. Same number, same case.
"""

import math
import random
import sys

import numpy as np

from ipoa_mission.autopilots.vehicle import Autopilot, Parameters
from ipoa_mission.commands import Command, Frame
from ipoa_mission.items import Item, Mission, change_speed, land, return_to_launch, takeoff
from ipoa_mission.itinerary.itinerary import itinerary
from ipoa_mission.simulator.flight import Flight
from ipoa_mission.timing.ardupilot import fly_arducopter
from ipoa_mission.world.frame import Geodetic, LocalFrame

HOME = Geodetic(39.101, 121.82, 20.0)
FRAME = LocalFrame(HOME)
KINDS = ("dense", "sparse", "steep", "back and forth", "tiny", "long", "vertical", "hold", "heading", "spline", "mixed")
SHARE, SECONDS = np.array([0.08, 0.05, 0.08]), np.array([1.5, 0.5, 1.5])  # take-off, mission, landing: worth a line
#: How often a parameter is moved, and between which values.
MOVED: dict[str, tuple[float, float, float]] = {
    "WP_SPD": (0.4, 2, 15), "WP_ACC": (0.4, 0.5, 5), "WP_JERK": (0.4, 0.5, 8), "WP_RADIUS_M": (0.4, 0.3, 10),
    "WP_SPD_UP": (0.4, 1, 5), "WP_SPD_DN": (0.4, 0.7, 3), "WP_ACC_Z": (0.3, 0.5, 3), "WP_ACC_CNR": (0.2, 0, 5),
    "LAND_SPD_MS": (0.4, 0.3, 1.2), "RTL_ALT_M": (0.4, 0, 60), "RTL_LOIT_TIME": (0.3, 0, 8000),
    "ATC_INPUT_TC": (0.3, 0.1, 0.4), "ATC_ANGLE_MAX": (0.3, 15, 45), "ATC_ACC_P_MAX": (0.2, 300, 1500),
}  # fmt: skip


def place(east: float, north: float) -> Geodetic:
    latitude, longitude, _ = FRAME.to_geodetic([[east, north, 0.0]])  # type: ignore[arg-type]
    return Geodetic(float(latitude[0]), float(longitude[0]), HOME.altitude)


def case(number: int) -> tuple[str, Mission, Parameters]:
    """A mission of one kind, and parameters."""
    chance = random.Random(number)
    kind = chance.choice(KINDS)
    height = chance.choice((5.0, 10.0, 20.0, 30.0, 60.0))
    items = [takeoff(HOME, height), waypoint(0.0, 0.0, height)]
    if chance.random() < 0.7:
        items.append(change_speed(chance.uniform(2, 15)))
    x = y = 0.0
    course = chance.uniform(0, 2 * math.pi)
    count = {"dense": 14, "tiny": 6, "long": 2}.get(kind, chance.randint(3, 7))
    for n in range(count):
        length = chance.choice((chance.uniform(3, 20), chance.uniform(20, 150)))
        length = {"dense": chance.uniform(1.5, 12), "tiny": 0.05, "long": 1000.0, "vertical": 0.0}.get(kind, length)
        turn = {"back and forth": math.pi, "dense": chance.gauss(0, 0.4)}.get(kind, chance.uniform(-2, 2))
        course += turn
        x, y = x + length * math.sin(course), y + length * math.cos(course)
        if kind in ("steep", "vertical", "mixed"):
            height = min(max(height + chance.uniform(-30, 30) * (0.3 if kind == "mixed" else 1.0), 4), 120)
        hold = chance.choice((0.0, chance.uniform(0.5, 9))) if kind in ("hold", "mixed") else 0.0
        yaw = chance.uniform(0, 360) if kind == "heading" and n > 0 else math.nan
        items.append(waypoint(x, y, height, hold, yaw, kind == "spline"))
        if kind == "mixed" and chance.random() < 0.25:
            items.append(change_speed(chance.uniform(2, 15)))
    items.append(land(place(x, y)) if chance.random() < 0.35 else return_to_launch())
    moved = {n: chance.uniform(a, b) for n, (share, a, b) in MOVED.items() if chance.random() < share}
    return kind, Mission(HOME, tuple(items), Autopilot.ARDUPILOT), moved


def waypoint(
    east: float, north: float, up: float, hold: float = 0.0, yaw: float = math.nan, spline: bool = False
) -> Item:
    there = place(east, north)
    command = Command.NAV_SPLINE_WAYPOINT if spline else Command.NAV_WAYPOINT
    params = (hold, 0.0, 0.0, yaw)
    return Item(command, Frame.GLOBAL_RELATIVE_ALT, params, there.latitude_deg, there.longitude_deg, up)


def parts(done: dict[int, float], mission: Mission, end_s: float) -> tuple[float, float, float]:
    """Seconds of the take-off, from there to the last waypoint, and of what follows."""
    last = len(mission.items) - 1
    while mission.items[last - 1].command == Command.DO_CHANGE_SPEED:
        last -= 1
    return done[2], done[last] - done[2], end_s - done[last]


def estimated(mission: Mission, parameters: Parameters) -> tuple[float, float, float]:
    route = itinerary(mission)
    found = fly_arducopter(route, parameters, fast=True)
    done = {visit.seq: float(at) for visit, at in zip(route.visits, found.done, strict=True)}
    return parts(done, mission, float(found.done[-1]))


def flown(mission: Mission, parameters: Parameters) -> tuple[float, float, float]:
    flight = Flight(mission.autopilot, mission.home, parameters)
    flight.load(mission.items)
    flight.arm()
    flight.start()
    while flight.armed and flight.time_s < 5000.0:
        flight.advance(flight.time_s + 1.0)
    done = {reached.index + 1: reached.time_s for reached in reversed(flight.reached)}
    lands = mission.items[-1].command == Command.NAV_LAND
    return parts(done, mission, done[len(mission.items)] if lands else flight.time_s)


def main() -> None:
    begin, end = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (0, 200)
    off = []
    for number in range(begin, end):
        kind, mission, parameters = case(number)
        ours, theirs = np.array(estimated(mission, parameters)), np.array(flown(mission, parameters))
        off.append(ours / theirs - 1)
        if (np.abs(ours - theirs) > np.maximum(SHARE * theirs, SECONDS)).any():
            print(number, kind, ours.round(1), theirs.round(1), {n: round(v, 2) for n, v in parameters.items()})
    share = np.quantile(np.abs(off), [0.5, 0.9], axis=0) * 100
    for name, half, most in zip(("take-off", "mission", "landing"), *share, strict=True):
        print(f"{name}: half of {len(off)} within {half:.1f} %, nine in ten within {most:.1f} %")


if __name__ == "__main__":
    main()
