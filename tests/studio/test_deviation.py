import queue
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pydantic")

from ipoa_mission import Forecast, read_mission, read_scenario
from ipoa_mission.flight import procedure
from ipoa_mission.forecast.conformance import ConformanceMonitor
from ipoa_mission.studio.flight_answers import Landed, Loaded, Seen, State
from ipoa_mission.studio.flight_worker import FlightWorker
from ipoa_mission.studio.handed import HandedOver

MISSIONS = Path(__file__).parents[2] / "missions"
MISSION = read_mission(MISSIONS / "sitl.plan")


def flown(folder: Path, forecast: Forecast, order_at: Any) -> list[Any]:
    """Return the page's messages of a flight; `order_at` gives its orders."""
    HandedOver("sitl", forecast, "proof").write(folder / "flight")
    beside: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    told, ordered = list[Any](), list[str]()

    def answer(said: Any) -> None:
        told.append(said)
        if isinstance(said, Loaded):
            beside.put({"vehicle": said.vehicle, "mission": said.mission, "proof": said.proof})
        elif not ordered and (what := order_at(said)):
            ordered.append(what)
            beside.put({"what": what})

    order = {"file": str(folder / "flight"), "log": str(folder / "a.tlog"), "link": None, "system": None, "revision": 1}
    FlightWorker(beside).fly(order | {"speedup": 1e9, "set_params": False}, answer)
    assert ordered
    return told


def words_of(told: list[Any]) -> list[str]:
    return [said.words for said in told if isinstance(said, State)]


def test_an_ordered_return_is_no_failure_and_offers_hold_and_land(tmp_path: Path) -> None:
    forecast = Forecast(MISSION, read_scenario(MISSIONS / "sitl.toml"))
    told = flown(tmp_path, forecast, lambda said: isinstance(said, Seen) and said.done >= 3 and "rtl")
    landed = next(said for said in told if isinstance(said, Landed))
    assert (landed.completed, landed.ordered) == (False, "rtl")
    assert words_of(told)[-2:] == ["it returns, as ordered", "landed, as ordered"]
    returning = told[told.index(State(phase="flying", words="it returns, as ordered")) :]
    orders = [order for said in returning if isinstance(said, Seen) for order in said.orders]
    assert {order.what for order in orders} == {"hold", "land"}
    known = [order for order in orders if order.clear is not None]
    assert len(known) == len(orders)
    assert all(order.clear for order in known if order.what == "hold")
    assert any("here: clear" in order.words for order in known if order.what == "land")


def test_a_deviation_is_shown_the_vehicle_holds_and_the_page_offers_orders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lower = replace(MISSION, items=tuple(replace(item, altitude=item.altitude / 2) for item in MISSION.items))
    monitor = ConformanceMonitor(Forecast(lower))
    monkeypatch.setattr(procedure, "_monitor", lambda *_: monitor)
    told = flown(tmp_path, Forecast(MISSION), lambda said: isinstance(said, Seen) and said.held and "land")
    seen = [said for said in told if isinstance(said, Seen)]
    (deviation,) = {words for said in seen for words in said.deviations}
    assert "above" in deviation
    assert f"it holds, because {deviation}" in words_of(told)
    assert seen[-1].deviations == (deviation,)
    landed = next(said for said in told if isinstance(said, Landed))
    assert not landed.completed
    assert deviation in landed.why_not
