"""Count what planning a shipped scenario computes: no count may rise over its limit in planning_work.toml."""

import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission import plan_flight, read_scenario
from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.deviation import clearance_guarantee
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.planning import _path_model, planner

LIMITS = tomllib.loads(Path(__file__).with_name("planning_work.toml").read_text(encoding="utf-8"))
SHIPPED = Path(__file__).parents[2] / "missions"


def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    counts = Counter[str]()

    def count(name: str, place: Any, attribute: str) -> None:
        computed: Callable[..., Any] = getattr(place, attribute)

        def counting(*args: Any, **options: Any) -> Any:
            counts[name] += 1
            return computed(*args, **options)

        monkeypatch.setattr(place, attribute, counting)

    for autopilot in registered():
        count("forecasts", type(autopilot.part(FlightModel)), "predicted")
    count("clearance_guarantees", clearance_guarantee, "clearance_guarantee_of")
    count("contingency_batches", ContingencyPaths, "_at")
    count("searches", planner, "minimize")
    count("polishing_stages", _path_model, "minimize_path_model")
    return counts


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(LIMITS))
def test_planning_computes_no_more_than_before(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    counts = counted(monkeypatch)
    plan_flight(read_scenario(SHIPPED / f"{name}.toml"))
    assert {key: count for key, count in counts.items() if count > LIMITS[name][key]} == {}
    assert counts.keys() == LIMITS[name].keys()
