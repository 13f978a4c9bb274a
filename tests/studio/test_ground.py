import pickle
import queue
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.checks.check import check
from ipoa_mission.finding import Finding
from ipoa_mission.flight import procedure
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.scenario import read_scenario
from ipoa_mission.studio.flight_worker import FlightWorker
from ipoa_mission.studio.plan_worker import PlanWorker
from tests.quick_search import search_quickly

MISSIONS = Path(__file__).parents[2] / "missions"
SHIPPED = sorted(MISSIONS.glob("*.toml"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_ground_of_a_scenario_goes_to_another_process(path: Path) -> None:
    ground = read_scenario(path).ground
    there = pickle.loads(pickle.dumps(ground))
    places = np.random.default_rng(0).uniform(-100.0, 300.0, (50, 2))
    assert there.is_flat == ground.is_flat
    assert np.array_equal(there(places), ground(places))
    assert [there.at(east, north) for east, north in places[:5].tolist()] == there(places[:5]).tolist()


@pytest.mark.parametrize(
    "path",
    [path if path.stem == "campus" else pytest.param(path, marks=pytest.mark.long) for path in SHIPPED],
    ids=[path.stem for path in SHIPPED],
)
def test_a_shipped_scenario_is_planned_handed_over_uploaded_and_flown(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    search_quickly(monkeypatch.setattr)
    planner, messages = PlanWorker(), list[Any]()
    planner.plan({"revision": 1, "text": path.read_text(), "path": str(path), "seed": 0}, messages.append)
    handed = tmp_path / "flight"
    planner.hand_over({"path": str(path), "file": str(handed), "flight": 0}, messages.append)
    beside: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    order = {"file": str(handed), "log": str(tmp_path / "a.tlog"), "link": None, "system": None, "revision": 1}

    def answer(message: Any) -> None:
        messages.append(message)
        if message.kind == "loaded":
            beside.put({"vehicle": message.vehicle, "mission": message.mission, "proof": message.proof})

    checked = list[Forecast]()

    def recorded(forecast: Forecast, ignore: Iterable[str]) -> tuple[Finding, ...]:
        checked.append(forecast)
        return check(forecast, ignore)

    monkeypatch.setattr(procedure, "check", recorded)
    FlightWorker(beside).fly(order | {"speedup": 1e9, "set_params": False}, answer)
    landed = next(message for message in messages if message.kind == "landed")
    assert landed.completed, landed.why_not
    assert checked
    assert checked[-1].mission_as_read.firmware_version is not None  # the vehicle's
