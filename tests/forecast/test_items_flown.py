"""Splines before other commands, circles, payloads, arcs: flights of ArduCopter 4.8.0-dev (531699d652, calm air).

A folder of tests/data/items_flown is one flight: mission, begin of each item, true position twice a second, 0.1 m
above the measured height. Only PLACED and LEVEL_OFF_TOLERANCE in vehicles/arducopter/dynamics were fitted.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.simulator.fly import fly_built_in

FOLDERS = sorted((Path(__file__).resolve().parents[1] / "data" / "items_flown").iterdir())
FLOWN = pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name.removesuffix("-ardupilot"))
WITHIN, SPLINES_WITHIN = 0.5, 0.45  # of the path [m]
SHARE, SECONDS = 0.025, 0.3  # from the end of the take-off; 2 % in all but loiter_to_alt


def read(folder: Path) -> tuple[Forecast, dict[int, float], NDArray[np.float64]]:
    """The forecast; when each item began [s]; the trace (n, 4): time, east, north, up."""
    document = json.loads((folder / "flight.json").read_text())
    mission = read_mission_file(folder / "mission.waypoints", Autopilot.ARDUPILOT).mission
    mission = mission.with_parameters(document["params"])
    forecast = Forecast(Forecast(mission).on(Version(4, 8)).mission_as_read)
    rows = np.loadtxt(folder / "trace.csv", delimiter=",", skiprows=1)
    flat = LocalFrame(mission.home).to_local(rows[:, 1], rows[:, 2], np.full(len(rows), mission.home.altitude))
    begins = {int(seq): float(at) for seq, at in document["item_begins_s"].items()}
    return forecast, begins, np.column_stack([rows[:, 0], flat[:, :2], rows[:, 3]])


def apart(points: Points, line: Points) -> NDArray[np.float64]:
    """Return distances of points (n, 3) from a line (m, 3) [m]."""
    begins, ways = line[:-1], np.diff(line, axis=0)
    beside = points[:, None] - begins
    share = np.clip((beside * ways).sum(axis=2) / np.maximum((ways**2).sum(axis=1), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(beside - share[..., None] * ways, axis=2).min(axis=1))


@FLOWN
def test_the_path_is_the_one_that_was_flown(folder: Path) -> None:
    forecast, begins, trace = read(folder)
    last = forecast.mission.items[-1].command == Command.NAV_RETURN_TO_LAUNCH
    end = begins.get(len(forecast.mission.items), np.inf) if last else np.inf
    flown = trace[(trace[:, 0] > begins[2]) & (trace[:, 0] < end) & (trace[:, 3] > 0.5), 1:]
    track = forecast.predicted(noise_free=True).track
    most = SPLINES_WITHIN if folder.name.startswith("spline") else WITHIN
    assert apart(flown, track.points).max() < most


@FLOWN
def test_every_item_is_done_when_it_was(folder: Path) -> None:
    forecast, begins, _ = read(folder)
    assert not forecast.unknown
    done = dict(zip((visit.seq for visit in forecast.itinerary.visits), forecast.expected.done.tolist(), strict=True))
    for seq, at in begins.items():
        before = max((earlier for earlier in done if earlier < seq), default=None)
        if before is not None and seq > 2:
            flown, estimated = at - begins[2], done[before] - done[1]
            assert abs(estimated - flown) < max(SHARE * flown, SECONDS), seq


@pytest.mark.parametrize("name", ["spline_land", "circle60", "circle_none", "payload_deep", "loiter_to_alt"])
def test_the_built_in_autopilot_flies_the_same(name: str) -> None:
    forecast, *_ = read(next(folder for folder in FOLDERS if folder.name == f"{name}-ardupilot"))
    reached = fly_built_in(forecast.mission).item_reached_s
    done = dict(zip((visit.seq for visit in forecast.itinerary.visits), forecast.expected.done.tolist(), strict=True))
    for seq in range(2, len(forecast.mission.items)):
        assert reached[seq - 1] - reached[0] == pytest.approx(done[seq] - done[1], abs=0.3), seq
