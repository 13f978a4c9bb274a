import json
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.messages import CommandLong, Count, ItemAt, Reached
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.mission.stored_mission import to_wire
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.situation import Conditions
from tests.examples import some
from tests.link_pair import CLIENT
from tests.recorded_flights import FLOWN_ON

FLIGHTS = Path(__file__).parent.parent / "data" / "flights"


def flown(folder: Path) -> tuple[Mission, Mapping[int, tuple[float, float]], dict[str, object]]:
    """A recorded mission, the mock's place at each item (numbered as in the file), and the record."""
    flight = json.loads((folder / "flight.json").read_text(encoding="utf-8"))
    mission = read_mission(folder / "mission.waypoints", autopilot_named(folder.name.rsplit("-", 1)[1]))
    parameters = {name: float(value) for name, value in flight["params"].items()}
    conditions = Conditions(version=FLOWN_ON[mission.autopilot])
    mock = Mock(mission.autopilot, mission.home, parameters, conditions=conditions)
    first = int(mission.autopilot is Autopilot.ARDUPILOT)
    start = CommandLong(300) if first else CommandLong(176, (1.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0))
    items = to_wire(mission)
    orders = [Count(len(items)), *(ItemAt(seq, item) for seq, item in enumerate(items))]
    for message in (*orders, CommandLong(400, (1.0,) + (0.0,) * 6), start):
        mock.receive(message, CLIENT, 1.0)
    reached: dict[int, tuple[float, float]] = {}
    left = 50  # steps for messages after disarming
    while mock.flight.armed or left > 0:
        assert mock.flight.time_s < 1000.0, "it does not come down"
        left -= not mock.flight.armed
        mock.tick(mock.deadline)
        east, north, _ = mock.flight.place
        for message, _ in mock.outgoing():
            if isinstance(message, Reached):
                reached.setdefault(message.seq + 1 - first, (float(east), float(north)))
    return mission, reached, flight


@pytest.mark.parametrize("name", some(1, ["land-px4", "corners-px4", "hold-px4"]))
def test_px4_tells_of_the_items_that_the_real_one_told_of(name: str) -> None:
    _, reached, recorded = flown(FLIGHTS / name)
    assert set(reached) == {int(seq) for seq in recorded["item_done_s"]}  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["corners-ardupilot", "ways_dp4-ardupilot"])
def test_ardupilot_tells_of_a_waypoint_where_the_real_one_did(name: str) -> None:
    mission, reached, recorded = flown(FLIGHTS / name)
    frame = LocalFrame(mission.home)
    times, latitudes, longitudes = np.loadtxt(FLIGHTS / name / "trace.csv", delimiter=",", skiprows=1).T[:3]
    before = []
    for seq, item in enumerate(mission.items, start=1):
        if item.command != 16:
            continue
        at = float(recorded["item_done_s"][str(seq)])  # type: ignore[index]
        there = Geodetic(float(np.interp(at, times, latitudes)), float(np.interp(at, times, longitudes)))
        point, place = (frame.local(each)[:2] for each in (Geodetic(item.latitude_deg, item.longitude_deg), there))
        before.append(math.dist(point, place))
        assert math.dist(point, reached[seq]) == pytest.approx(before[-1], abs=0.4), seq
    assert max(before) > 0.5
