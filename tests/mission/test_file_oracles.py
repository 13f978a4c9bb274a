import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.mission_io import write_mission
from ipoa_mission.mission.stored_mission import fence_to_wire, home_item, rally_to_wire
from tests.mission_strategies import missions

mavwp = pytest.importorskip("pymavlink.mavwp")


def as_mavsdk_has_it(item: Item, params: bool = True) -> list[float | None]:
    """Frame, command, autocontinue, param1 to param4, x, y, z."""
    p = [None if math.isnan(value) else float(np.float32(value)) for value in item.params]
    x, y = (round(degrees * 1e7) for degrees in (item.latitude_deg, item.longitude_deg))
    return [item.frame, item.command, int(item.autocontinue), *p, x, y, float(np.float32(item.altitude))]


def read_by_mavsdk(rows: list[list[Any]]) -> list[list[float | None]]:
    return [[frame, command, on, *rest] for _, frame, command, _, on, *rest in rows]


@given(mission=missions())
def test_mavsdk_reads_our_plans_and_agrees_item_by_item(mission: Mission, mavsdk: Any, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "oracle.plan"
    write_mission(mission, path)
    got = mavsdk.read(path.read_text(), "plan", mission.autopilot)
    rows = read_by_mavsdk(got["mission"])
    assert [row[0] for row in got["mission"]] == list(range(len(rows)))
    if mission.autopilot is Autopilot.ARDUPILOT:
        home = as_mavsdk_has_it(home_item(mission.home))
        assert rows.pop(0) == [5, *home[1:]]
    assert rows == [as_mavsdk_has_it(item) for item in mission.items]
    without_autocontinue = slice(3, None)
    for name, ours in (("fence", fence_to_wire(mission.fence)), ("rally", rally_to_wire(mission.rally))):
        theirs = read_by_mavsdk(got[name])
        assert [row[1] for row in theirs] == [item.command for item in ours]
        assert [r[without_autocontinue] for r in theirs] == [as_mavsdk_has_it(i)[without_autocontinue] for i in ours]


@given(mission=missions(frames=(0, 3), fences=False))
def test_mavsdk_reads_our_waypoints_and_agrees_item_by_item(
    mission: Mission, mavsdk: Any, tmp_path_factory: Any
) -> None:
    path = tmp_path_factory.getbasetemp() / "oracle.waypoints"
    write_mission(mission, path)
    got = mavsdk.read(path.read_text(), "waypoints", mission.autopilot)
    rows = read_by_mavsdk(got["mission"])
    if mission.autopilot is Autopilot.ARDUPILOT:
        rows.pop(0)  # MAVSDK adds home to an ArduPilot list
    assert rows == [as_mavsdk_has_it(item) for item in (home_item(mission.home), *_as_written(mission))]


@given(mission=missions(frames=(0, 3), fences=False))
def test_mavwp_reads_our_waypoints_and_agrees_item_by_item(mission: Mission, tmp_path_factory: Any) -> None:
    path: Path = tmp_path_factory.getbasetemp() / "oracle.waypoints"
    write_mission(mission, path)
    loader = mavwp.MAVWPLoader()
    assert loader.load(str(path)) == len(mission.items) + 1
    for seq, item in enumerate((home_item(mission.home), *_as_written(mission))):
        theirs = loader.wp(seq)
        assert (theirs.seq, theirs.frame, theirs.command, theirs.autocontinue) == (
            seq,
            item.frame,
            item.command,
            int(item.autocontinue),
        )
        got = [theirs.param1, theirs.param2, theirs.param3, theirs.param4, theirs.x, theirs.y, theirs.z]
        ours = [*item.params, item.latitude_deg, item.longitude_deg, item.altitude]
        assert str(got) == str([float(value) for value in ours]), "to the last bit"


def _zeroed(item: Item) -> tuple[float, float, float, float]:
    one, two, three, four = (0.0 if math.isnan(p) else p for p in item.params)
    return one, two, three, four


def _as_written(mission: Mission) -> list[Item]:
    """NaN is only in a file for PX4: ArduPilot's ground stations cannot read it."""
    if mission.autopilot is Autopilot.PX4:
        return list(mission.items)
    zeros = (_zeroed(item) for item in mission.items)
    return [
        Item(item.command, item.frame, p, item.latitude_deg, item.longitude_deg, item.altitude, item.autocontinue)
        for item, p in zip(mission.items, zeros, strict=True)
    ]
