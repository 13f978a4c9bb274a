import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission import BadInput, estimate, read_mission
from ipoa_mission.studio.edits import mission_changed
from ipoa_mission.studio.requests import InsertItem, MoveItem, PutItem
from ipoa_mission.studio.session import Session
from ipoa_mission.studio.sessions import Sessions
from ipoa_mission.studio.web_server import application
from tests.refused import refuses
from tests.studio.conftest import HOST, TOKEN, Studio, testclient

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    folder = tmp_path_factory.mktemp("missions")
    for name in ("sitl.plan", "sitl.toml"):
        shutil.copy(MISSIONS / name, folder / name)
    sessions = Sessions()
    sessions.hosts[TOKEN] = Session(folder / "sitl.plan")
    with testclient.TestClient(application(sessions, folder, HOST), base_url=f"http://{HOST}") as client:
        yield Studio(client, folder / "sitl.plan")


def edit(talk: Any, seen: int, *changes: dict[str, Any]) -> dict[str, Any]:
    talk.say(kind="edit", seen=seen, label="changed", changes=list(changes))
    document = talk.wait("document")
    return dict(talk.wait("mission", lambda message: message["revision"] == document["revision"]))


def test_mission_is_opened_checked_and_timed_without_a_scenario(opened: Studio) -> None:
    with opened.window() as talk:
        assert talk.wait("document")["of"] == "mission"
        mission = talk.wait("mission")
        assert mission["scenario"] is None
        assert [item["words"] for item in mission["items"]][:2] == ["take off", "speed 8 m/s"]
        checked, plan = talk.wait("checked"), talk.wait("plan")
        assert (checked["timeless"], plan["kept"]) == (None, None)
        assert plan["total_s"] == pytest.approx(estimate(read_mission(MISSIONS / "sitl.plan")).total_s, abs=0.01)


def test_items_are_moved_put_in_and_taken_out_and_undone(opened: Studio) -> None:
    before = opened.scenario.read_bytes()
    with opened.window() as talk:
        revision = talk.wait("document")["revision"]
        items = talk.wait("mission")["items"]
        moved = edit(talk, revision, {"op": "move_item", "seq": 4, "place": [8.546, 47.398]})
        assert moved["items"][3]["place"] == [8.546, 47.398]
        more = edit(talk, moved["revision"], {"op": "insert_item", "seq": 4, "command": 16, "place": [8.5461, 47.3981]})
        assert len(more["items"]) == len(items) + 1
        talk.say(kind="edit", seen=revision, label="late", changes=[{"op": "take_item", "seq": 5}])
        assert "changed elsewhere" in talk.wait_for_trouble("edit")["message"]  # which is meant by 5?
        talk.wait("document")
        edit(talk, more["revision"], {"op": "take_item", "seq": 5})
        talk.say(kind="do", what="save")
        talk.wait("document", lambda message: not message["unsaved"])
        assert len(read_mission(opened.scenario).items) == len(items)
        assert read_mission(opened.scenario).items[3].latitude_deg == 47.3981
        for _ in range(3):
            talk.say(kind="do", what="undo")
        talk.wait("document", lambda message: message["undo"] is None)
        talk.say(kind="do", what="save")
        talk.wait("document", lambda message: not message["unsaved"])
    assert opened.scenario.read_bytes() == before


def test_edit_after_an_undo_that_renumbers_nothing_is_applied(opened: Studio) -> None:
    with opened.window() as talk:
        revision = talk.wait("document")["revision"]
        talk.wait("mission")
        moved = edit(talk, revision, {"op": "move_item", "seq": 4, "place": [8.546, 47.398]})
        for what in ("undo", "redo"):
            talk.say(kind="do", what=what)
            talk.wait("document")
        higher = edit(talk, moved["revision"], {"op": "put_item", "seq": 4, "what": "param7", "value": 31.5})
        for _ in range(2):
            talk.say(kind="do", what="undo")
        talk.wait("document", lambda message: message["undo"] is None)
    assert higher["items"][3]["values"][6] == 31.5


def test_kept_clearance_is_told_in_a_scenario_s_world(opened: Studio) -> None:
    with opened.window() as talk:
        world = talk.wait("mission")["worlds"][0]
        talk.say(kind="set_scenario", scenario=world, autopilot=None)
        assert talk.wait("mission", lambda message: message["scenario"] is not None)["scenario"].endswith("sitl.toml")
        assert talk.wait("plan", lambda message: message["kept"] is not None)["required"] > 0
        talk.say(kind="set_scenario", scenario=None, autopilot=None)
        talk.wait("mission", lambda message: message["scenario"] is None)


BATTERY = """
[vehicle.battery]
capacity_wh = 60.0
reserve = 0.25

[vehicle.airframe]
mass_kg = 2.0
rotor_diameter = 0.3
"""


def within(talk: Any, world: Path | None) -> int:
    talk.say(kind="set_scenario", scenario=None if world is None else str(world), autopilot=None)
    asked = talk.wait("document", lambda message: not message["unsaved"])["revision"]
    return int(talk.wait("checked", lambda message: message["revision"] == asked)["revision"])


def uploaded(talk: Any, speedup: float) -> dict[str, str]:
    talk.say(kind="upload", link=None, system=None, speedup=speedup)
    loaded = talk.wait("loaded")
    return {key: loaded[key] for key in ("vehicle", "mission", "proof")}


def test_mission_is_flown_in_a_scenario_s_world_held_and_sent_on(opened: Studio) -> None:
    world = opened.scenario.with_name("battery.toml")
    world.write_text((MISSIONS / "sitl.toml").read_text() + BATTERY)
    with opened.window() as talk:
        talk.wait("document")
        within(talk, world)
        named = uploaded(talk, 1000.0)
        within(talk, None)  # it is judged otherwise than what was uploaded
        talk.say(kind="start", **named)
        assert "changed after the upload" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="do", what="abandon")
        talk.wait("state", lambda state: state["phase"] == "idle")
        revision = within(talk, world)
        plan = talk.wait("plan", lambda message: message["revision"] == revision)
        assert uploaded(talk, 8.0) == named  # the same mission in the same world
        talk.say(kind="start", **named)
        flies = talk.wait("seen", lambda seen: seen["done"] > 2 and seen["orders"])
        talk.say(kind="order", what="hold")
        holding = talk.wait("seen", lambda seen: seen["held"] and seen["speed"] < 0.1 and len(seen["orders"]) == 3)
        stays = talk.wait("seen", lambda seen: seen["time_s"] > holding["time_s"] + 20.0)
        talk.say(kind="order", what="go_on")
        landed = talk.wait("landed")
    assert [order["what"] for order in flies["orders"]] == ["hold", "rtl", "land"]
    assert flies["orders"][0]["words"].startswith("here: clear, ")
    assert [order["what"] for order in stays["orders"]] == ["go_on", "rtl", "land"]
    assert stays["orders"][0]["words"].startswith("as planned with item ")
    for before, after in zip(holding["orders"][1:], stays["orders"][1:], strict=True):  # as long as it stays there
        assert (after["what"], after["clear"]) == (before["what"], before["clear"])
        assert after["seconds"] == pytest.approx(before["seconds"], abs=1.5)
    assert abs(stays["place"][1] - holding["place"][1]) * 111e3 < 2.0
    assert flies["reserve"]["reserve"] == 0.25
    least, likely, most = flies["reserve"]["lands"]
    assert least < likely < most
    assert likely < flies["reserve"]["planned"] <= 1.0
    assert landed["completed"], landed["why_not"]
    assert landed["flown_s"] > plan["total_s"] + 15.0


def test_mission_flies_without_a_scenario_and_names_unknowns(opened: Studio) -> None:
    with opened.window() as talk:
        talk.wait("document")
        within(talk, None)
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        talk.say(kind="start", **{key: loaded[key] for key in ("vehicle", "mission", "proof")})
        seen = talk.wait("seen", lambda seen: seen["orders"])
        landed = talk.wait("landed")
    assert "no scenario gives the obstacles" in loaded["remarks"][0]
    assert [(order["clear"], order["seconds"]) for order in seen["orders"]] == [(None, None)] * 3
    assert landed["completed"], landed["why_not"]


def test_mission_is_saved_as_the_other_format_over_nothing(opened: Studio) -> None:
    with opened.window() as talk:
        for name in ("sitl.waypoints", "sitl-2.waypoints"):
            talk.say(kind="save_as", suffix=".waypoints")
            written = talk.wait("written")
            assert written["files"] == [name]
            assert "loses the take-off" in written["remarks"][0]
    assert len(read_mission(opened.scenario.with_name(name)).items) == len(read_mission(opened.scenario).items)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (PutItem(seq=4, what="frame", value=0.0), {"frame": 0, "Altitude": 508.0}),  # as high as before
        (PutItem(seq=4, what="param1", value=3.0), {"params": 3}),
        (InsertItem(seq=5, command=178), {"command": 178, "frame": 2}),
        (InsertItem(seq=5, command=21), {"command": 21, "Altitude": 0}),
    ],
)
def test_a_change_is_written_as_ground_stations_write_it(change: Any, expected: dict[str, Any]) -> None:
    document = json.loads((MISSIONS / "sitl.plan").read_text())
    document["mission"]["items"][3] |= {"Altitude": 20, "params": [*document["mission"]["items"][3]["params"][:6], 20]}
    text = mission_changed(json.dumps(document), Path("a.plan"), [change])
    item = json.loads(text)["mission"]["items"][change.seq - 1]
    values = {key: item["params"][0] if key == "params" else item[key] for key in expected}
    assert values == expected


def test_changes_of_missing_items_are_refused() -> None:

    text = (MISSIONS / "sitl.plan").read_text()
    with refuses("no-such-item", "item 99", kind=BadInput):
        mission_changed(text, Path("a.plan"), [MoveItem(seq=99, place=(8.5, 47.4))])


def test_one_with_an_error_is_not_uploaded(opened: Studio) -> None:
    with opened.window() as talk:
        talk.wait("document")
        revision = within(talk, opened.scenario.with_name("sitl.toml"))
        changes = [{"op": "put_item", "seq": 4, "what": "param7", "value": 1.0}]
        talk.say(kind="edit", seen=revision, label="far too low", changes=changes)
        changed = talk.wait("document", lambda message: message["revision"] > revision)
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        assert "not checked yet" in talk.wait_for_trouble("flight")["message"]
        checked = talk.wait("checked", lambda message: message["revision"] == changed["revision"])
        wrong = [flaw["message"] for flaw in checked["flaws"] if flaw["severity"] == "error"]
        assert wrong
        assert checked["timeless"] is None
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        assert wrong[0] in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="do", what="undo")
        talk.wait("checked", lambda message: message["revision"] > changed["revision"])
