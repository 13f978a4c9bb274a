import queue
import threading
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pydantic")

from ipoa_mission import Forecast, read_mission
from ipoa_mission.link import vehicle as verbs
from ipoa_mission.studio.flight_answers import Landed, Loaded, Seen, State
from ipoa_mission.studio.flight_worker import FlightWorker
from ipoa_mission.studio.handed import HandedOver
from tests.cut_link import cut_link
from tests.link.conftest import running
from tests.quick_link import hurry

MISSION = Path(__file__).parents[2] / "missions" / "sitl.plan"


def test_a_flight_goes_on_on_the_page_after_its_link_was_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch.setattr)
    monkeypatch.setattr(verbs, "SILENT_S", 0.5)
    mission = read_mission(MISSION)
    HandedOver("sitl", Forecast(mission), "proof").write(tmp_path / "flight")
    beside: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    heard, cut = list[Any](), list[bool]()
    with running(mission.autopilot, 20.0, "tcpin", home=mission.home) as far, cut_link(far.port) as link:

        def answer(message: Any) -> None:
            heard.append(message)
            match message:
                case Loaded():
                    beside.put({"vehicle": message.vehicle, "mission": message.mission, "proof": message.proof})
                case Seen(up=up) if up > 5.0 and not cut:
                    cut.append(True)
                    link.cut()
                case State(lost_s=0):
                    beside.put({"what": "rtl"})
                    threading.Timer(1.2, link.join).start()

        order = {"file": str(tmp_path / "flight"), "log": str(tmp_path / "flight.tlog"), "revision": 1, "speedup": None}
        order |= {"link": f"tcp:127.0.0.1:{link.port}", "system": None, "set_params": False}
        FlightWorker(beside).fly(order, answer)
    landed = next(message for message in heard if isinstance(message, Landed))
    assert landed.completed, landed.why_not
    states = [message for message in heard if isinstance(message, State) and message.phase == "flying"]
    lost = [state for state in states if state.lost_s is not None]
    assert [state.lost_s for state in lost] == sorted(state.lost_s or 0.0 for state in lost)
    assert lost[0].words.startswith("the link is lost: the other side closed the connection")
    assert any("AUTO.RTL was not ordered: the link is lost" in state.words for state in lost)
    assert states[-1].lost_s is None
    at = heard.index(lost[-1])
    assert sum(isinstance(message, Seen) for message in heard[at:]) > 20
