import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.vehicles.px4_multicopter.log import items_begun

COLUMNS = ("timestamp", "sequence_current", "nav_cmd", "altitude_is_relative", "latitude", "longitude", "altitude")
#: Two steps each of take-off and landing, a speed, a waypoint; at the end PX4 reports item 5.
STEPS = [
    (1e6, 0, 22, False, 47.4, 8.5, 503.0),
    (5e6, 0, 16, True, 47.40001, 8.5, 15.0),
    (8e6, 1, 178, False, 0.0, 0.0, 0.0),
    (9e6, 2, 16, False, 47.401, 8.501, 520.0),
    (20e6, 3, 16, False, 47.402, 8.502, 520.0),
    (30e6, 3, 21, True, 47.402, 8.502, 0.0),
    (60e6, 4, 0, True, 47.402, 8.502, 0.0),
]


def topics(steps: Sequence[tuple[float, ...]], total: int) -> tuple[dict[str, Any], dict[str, Any]]:
    data: dict[str, Any] = {
        name: np.array(column) for name, column in zip(COLUMNS, zip(*steps, strict=True), strict=True)
    }
    data |= {name: np.zeros(len(steps)) for name in ("time_inside", "acceptance_radius", "loiter_radius")}
    data["yaw"] = np.full(len(steps), math.nan)
    data["acceptance_radius"][data["nav_cmd"] == 178] = 7.0
    data["yaw"][3] = math.pi / 2
    return data, {"timestamp": np.array([0.0, 50e6]), "seq_total": np.array([total, total])}


def test_items_are_put_together_of_their_steps() -> None:
    begun_at = {begun.seq: (time, begun.item) for time, begun in items_begun(*topics(STEPS, 4))}
    assert {seq: time for seq, (time, _) in begun_at.items()} == {0: 1.0, 1: 8.0, 2: 9.0, 3: 20.0}
    climb, speed, there, down = (begun_at[seq][1] for seq in range(4))
    assert (climb.command, climb.frame) == (Command.NAV_TAKEOFF, Frame.GLOBAL_RELATIVE_ALT)
    assert (climb.latitude_deg, climb.altitude) == (47.40001, 15.0)
    assert (speed.command, speed.frame, speed.params[1]) == (Command.DO_CHANGE_SPEED, Frame.MISSION, 7.0)
    assert (there.frame, there.altitude) == (Frame.GLOBAL, 520.0)
    assert there.params[3] == pytest.approx(90.0)
    assert (down.command, down.altitude) == (Command.NAV_LAND, 0.0)


def test_a_log_without_the_topics_tells_of_none() -> None:
    data, result = topics(STEPS, 4)
    assert not list(items_begun(None, result))
    assert not list(items_begun(data, None))


def test_an_item_beyond_the_mission_s_end_is_none() -> None:
    assert [begun.seq for _, begun in items_begun(*topics(STEPS, 3))] == [0, 1, 2]
