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
    messages, ordered = list[Any](), list[str]()

    def answer(message: Any) -> None:
        messages.append(message)
        if isinstance(message, Loaded):
            beside.put({"vehicle": message.vehicle, "mission": message.mission, "proof": message.proof})
        elif not ordered and (order := order_at(message)):
            ordered.append(order)
            beside.put({"what": order})

    order = {"file": str(folder / "flight"), "log": str(folder / "a.tlog"), "link": None, "system": None, "revision": 1}
    FlightWorker(beside).fly(order | {"speedup": 1e9, "set_params": False}, answer)
    assert ordered
    return messages


def words_of(messages: list[Any]) -> list[str]:
    return [message.words for message in messages if isinstance(message, State)]


def test_an_ordered_return_is_no_failure_and_offers_hold_and_land(tmp_path: Path) -> None:
    forecast = Forecast(MISSION, read_scenario(MISSIONS / "sitl.toml"))
    messages = flown(tmp_path, forecast, lambda message: isinstance(message, Seen) and message.done >= 3 and "rtl")
    landed = next(message for message in messages if isinstance(message, Landed))
    assert (landed.completed, landed.ordered) == (False, "rtl")
    assert words_of(messages)[-2:] == ["it returns, as ordered", "landed, as ordered"]
    returning = messages[messages.index(State(phase="flying", words="it returns, as ordered")) :]
    orders = [order for message in returning if isinstance(message, Seen) for order in message.orders]
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
    messages = flown(tmp_path, Forecast(MISSION), lambda message: isinstance(message, Seen) and message.held and "land")
    seen = [message for message in messages if isinstance(message, Seen)]
    (deviation,) = {words for message in seen for words in message.deviations}
    assert "above" in deviation
    assert f"it holds, because {deviation}" in words_of(messages)
    assert seen[-1].deviations == (deviation,)
    landed = next(message for message in messages if isinstance(message, Landed))
    assert not landed.completed
    assert deviation in landed.why_not
