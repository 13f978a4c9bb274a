from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.deviation.proximity import ProximityRisks
from ipoa_mission.planning.obstruction import NoPath
from ipoa_mission.routing.seek import TooNarrow, expect_wide, least_reach, plan_with_margins
from ipoa_mission.scenario import Scenario
from tests.refused import refuses


@pytest.mark.parametrize("wind", [0.0, 5.0])
@pytest.mark.parametrize("chance", [0.2, 0.1, 0.01, 0.002])
@pytest.mark.parametrize("autopilot", registered())
def test_one_passage_nearer_than_the_least_reach_breaks_the_promise(
    autopilot: Autopilot, chance: float, wind: float
) -> None:
    law, required = law_of(autopilot, wind), 2.0
    least = least_reach(law, chance)
    for aside, above, is_over in (
        (1.0, -5.0, True),
        (1.0, 0.0, False),
        (-3.0, 1.0, True),
        (-3.0, 1.0, False),
        (0.7, 0.7, True),
        (0.9, 0.4, False),
    ):
        away = (required + least - 0.005) / float(np.hypot(max(aside, 0.0), max(above, 0.0)))
        unit = np.ones(1)
        passed = ProximityRisks(
            law,
            np.zeros(1, np.intp),
            np.zeros(1, np.intp),
            unit,
            unit * aside * away,
            unit * above * away,
            np.array([is_over]),
            unit,
            unit,
        )
        assert passed.chance(required) > chance


def gate(width: float, autopilot: str, confidence: float | str = 0.99) -> dict[str, Any]:
    """80 m east over a via point, through a gate between two walls above the ceiling."""
    wall = {"kind": "box", "east": 40.0, "width": 4.0, "depth": 60.0, "height": 60.0}
    return {
        "home": {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0},
        "start": {"east": 0.0, "north": 0.0, "up": 10.0},
        "via": [{"east": 20.0, "north": 5.0, "up": 10.0}],
        "goal": {"east": 80.0, "north": 0.0, "up": 10.0},
        "bounds": {"east": (-20, 100), "north": (-60, 60), "up": (0, 40)},
        "safety_distance": 2.0,
        "safety": {"confidence": confidence},
        "vehicle": {"autopilot": autopilot, "radius": 0.5},
        "route": {"ending": "land"},
        "obstacles": [
            wall | {"name": "left", "north": 30.0 + width / 2},
            wall | {"name": "right", "north": -30.0 - width / 2},
        ],
    }


def test_a_gap_too_narrow_is_named_with_its_leg_before_any_search(monkeypatch: pytest.MonkeyPatch) -> None:
    def sought(*_: object) -> None:
        raise AssertionError("a path was sought")

    monkeypatch.setattr("ipoa_mission.routing.seek.plan_path", sought)
    narrow = Scenario.model_validate(gate(5.6, "px4"))
    with pytest.raises(NoPath) as refused:
        plan_with_margins(narrow, 0, lambda *_: None)
    words = str(refused.value)
    assert words.startswith("a path exists, but fewer than 99 % of flights on px4 would keep its limits: the gap")
    assert "the gap between left and right is 5.60 m wide, and it needs 7.34 m at least" in words
    assert "on the leg from via[0] to goal" in words
    assert "these changes did not help: vehicle.cruise_speed" in words
    assert refused.value.hint == "reduce safety_distance, or move the places of this leg"


@pytest.mark.parametrize(
    "scene",
    [
        gate(7.4, "px4"),
        gate(5.6, "ardupilot"),
        gate(5.6, "px4", "nominal"),
        gate(4.8, "px4"),  # not even the required distance: the planner names that
        gate(5.6, "px4") | {"via": [{"east": 37.0, "north": 0.0, "up": 10.0}]},  # of a given place less is promised
    ],
    ids=["wide", "small bound", "no bound", "closed", "given place"],
)
def test_only_what_is_certain_is_refused_without_a_search(scene: dict[str, Any]) -> None:
    expect_wide(Scenario.model_validate(scene))


def test_legs_of_a_narrow_gap_are_counted_without_a_repeated_via_point() -> None:
    scene = gate(5.6, "px4") | {"via": [{"east": 0.0, "north": 0.0, "up": 10.0}]}
    with pytest.raises(TooNarrow) as refused:
        expect_wide(Scenario.model_validate(scene))
    assert "on the leg" not in str(refused.value)
    expect_wide(Scenario.model_validate(scene | {"obstacles": gate(7.4, "px4")["obstacles"]}))


def test_a_gap_a_little_too_narrow_is_certain() -> None:
    with refuses("too-narrow", "", "7.30", "7.34"):
        expect_wide(Scenario.model_validate(gate(7.3, "px4")))
