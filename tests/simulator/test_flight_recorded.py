"""The built-in autopilot against missions that real autopilots flew, from take-off done to the last waypoint."""

import json
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.mission.files import read_mission
from ipoa_mission.mission.items import Command
from ipoa_mission.simulator.flight import Flight
from ipoa_mission.vehicle import Autopilot

FLIGHTS = Path(__file__).parent.parent / "flights"
#: Where PX4's recorded flights are slower than ours by more than 5 %: their height estimate jumps by a metre, which
#: holds them up at dense and climbing waypoints; the built-in one sees its true height. Measured, with some room.
SLOWER = {"corners": 0.05, "corners_brisk": 0.05, "survey": 0.05, "survey_again": 0.05, "long": 0.05, "straight": 0.06}


def within(name: str, autopilot: Autopilot) -> float:
    """What the flown time may be off by, as a share."""
    return 0.03 if autopilot is Autopilot.ARDUPILOT else SLOWER.get(name, 0.25)


def recorded(folder: Path, first: int, last: int) -> float:
    """Mean seconds from item `first` to item `last`, or to completion where the last one was not reported."""
    told = json.loads((folder / "flight.json").read_text(encoding="utf-8"))
    runs = [{int(k): v for k, v in run.items()} for run in (told["item_done_s"], *told.get("repeats_item_done_s", []))]
    completed = [told.get("complete_s"), *told.get("repeats_complete_s", [])]
    spans = [run.get(last, end) - run[first] for run, end in zip(runs, completed, strict=True) if first in run]
    return float(np.mean(spans))


@pytest.mark.parametrize("folder", sorted(FLIGHTS.iterdir()), ids=lambda folder: folder.name)
def test_a_recorded_mission_takes_about_as_long(folder: Path) -> None:
    name, autopilot = folder.name.rsplit("-", 1)
    mission = read_mission(folder / "mission.waypoints", Autopilot(autopilot))
    told = json.loads((folder / "flight.json").read_text(encoding="utf-8"))
    flight = Flight(mission.autopilot, mission.home, {k: float(v) for k, v in told["params"].items()})
    flight.load(mission.items)
    flight.arm()
    flight.start()
    while flight.armed:
        flight.advance(flight.time_s + 1.0)
        assert flight.time_s < 1.5 * told["end_s"]
    done = {reached.index + 1: reached.time_s for reached in flight.reached}
    waypoints = {Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT}
    last = max(seq for seq, item in enumerate(mission.items, start=1) if item.command in waypoints)
    first = 1 if mission.autopilot is Autopilot.ARDUPILOT else 3
    flown = done[last] - done[first]
    assert flown == pytest.approx(recorded(folder, first, last), rel=within(name, mission.autopilot))
    assert flight.landed
