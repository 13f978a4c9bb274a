"""Take-offs of ArduCopter 4.8.0-dev (master of 21 March 2026), each flown once; nothing was fitted.

tests/data/takeoffs-4.8.csv: height, climb speed and end of the take-off, for the 25 missions of docs/lab/flown.md.
"""

import csv
from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint

TAKEOFFS = Path(__file__).parents[1] / "data" / "takeoffs-4.8.csv"
ROWS = list(csv.DictReader(TAKEOFFS.read_text(encoding="utf-8").splitlines()))
HOME, THERE = Geodetic(46.9232, 10.5127, 1050.0), Geodetic(46.9242, 10.5127, 1050.0)


def done_s(height: float, version: str) -> float:
    items = takeoff(HOME, height), waypoint(THERE, height), return_to_launch()
    mission = Mission(HOME, items, Autopilot.ARDUPILOT, firmware_version=Version.parsed(version))
    return estimate(mission).items[0].done_s


def off(version: str) -> np.ndarray:
    return np.array([done_s(float(row["height_m"]), version) - float(row["flown_s"]) for row in ROWS])


def test_4_8_brakes_its_climb_harder() -> None:
    assert abs(np.median(off("4.8"))) < 0.1
    assert np.abs(off("4.8")).max() < 0.25
    assert np.median(off("4.7")) > 0.45
