import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from ipoa_mission import read_scenario
from ipoa_mission.files import write_atomically
from ipoa_mission.link.codec import EVERYONE, Codec
from ipoa_mission.link.messages import Heartbeat
from tests.studio.conftest import HOST, MEADOW, TOKEN, Studio

GOAL_HEIGHT = {"op": "put", "path": ["goal", "up"]}
PUT_SPEED = {"op": "put", "path": ["vehicle", "cruise_speed"], "value": 9.0}


def test_a_window_is_shown_the_scenario_and_a_first_path(studio: Studio) -> None:
    with studio.window() as talk:
        document = talk.wait("document")
        world, sketch = talk.wait("world"), talk.wait("sketch")
    assert document["scenario"]["goal"] == {"east": 60.0, "north": 0.0, "up": 10.0}
    assert len(world["bodies"]) == len(read_scenario(studio.scenario).airspace.obstacles)
    assert [spot["name"] for spot in world["spots"]] == ["home", "start", "goal"]
    assert sketch["is_proved"]
    assert sketch["clearance"] >= world["required"]


def test_a_change_is_told_to_every_window_and_saved_with_its_comments(studio: Studio) -> None:
    before = studio.scenario.read_text()
    with studio.window() as first, studio.window() as second:
        document = first.wait("document")
        second.wait("document")
        first.say(kind="edit", seen=document["revision"], label="slower", changes=[PUT_SPEED])
        changed_document = first.wait("document")
        assert changed_document["scenario"] == second.wait("document")["scenario"]
        assert changed_document["scenario"]["vehicle"]["cruise_speed"] == 9.0
        assert changed_document["unsaved"]
        assert studio.scenario.read_text() == before
        second.say(kind="do", what="save")
        assert not first.wait("document")["unsaved"]
    assert studio.scenario.read_text() == before.replace("cruise_speed = 8.0", "cruise_speed = 9.0")


def test_a_drag_is_answered_and_changes_nothing(studio: Studio) -> None:
    shift = {"op": "shift", "path": ["goal"], "taken": [8.5, 47.3], "put_down": [8.5001, 47.3001]}
    with studio.window() as talk:
        still = talk.wait("sketch")
        talk.say(kind="drag", number=5, changes=[shift])
        moved = talk.wait("sketch", lambda answer: answer["number"] == 5)
        talk.say(kind="do", what="undo")
    assert moved["line"]["points"][-1] != still["line"]["points"][-1]
    assert not [answer for answer in talk.heard if answer["kind"] == "document"][1:]
    assert studio.scenario.read_bytes() == MEADOW.read_bytes()


def test_errors_go_to_the_window_that_asked(studio: Studio) -> None:
    with studio.window() as talk:
        seen = talk.wait("document")["revision"]
        talk.wait("world")
        talk.say(kind="edit", seen=seen, label="x", changes=[{"op": "take", "path": ["obstacles", 99]}])
        assert "obstacles.99" in talk.wait_for_trouble("edit")["message"]
        talk.say(kind="launch the rocket")
        assert "expected a valid message" in talk.wait_for_trouble("edit")["message"]
        talk.say(kind="edit", seen=seen, label="x", changes=[PUT_SPEED | {"value": -3.0}])
        assert "vehicle.cruise_speed: expected" in talk.wait_for_trouble("scenario")["message"]
        talk.say(kind="do", what="undo")
        talk.wait("world")


def test_a_change_of_lists_that_were_numbered_anew_is_refused(studio: Studio) -> None:
    first = {"op": "take", "path": ["obstacles", 0]}
    with studio.window() as first_window, studio.window() as second:
        seen = first_window.wait("document")["revision"]
        second.wait("document")
        first_window.say(kind="edit", seen=seen, label="barn removed", changes=[first])
        document = second.wait("document", lambda message: message["revision"] > seen)
        second.say(kind="edit", seen=seen, label="barn removed", changes=[first])
        assert "changed elsewhere" in second.wait_for_trouble("edit")["message"]
    assert [body["name"] for body in document["scenario"]["obstacles"]] == ["silo"]


def test_changes_by_another_program_are_taken_and_can_be_undone(studio: Studio) -> None:
    with studio.window() as talk:
        talk.wait("sketch")
        write_atomically(studio.scenario, studio.scenario.read_text().replace("east = 60.0", "east = 59.0"))
        assert talk.wait("document")["scenario"]["goal"]["east"] == 59.0
        talk.say(kind="do", what="undo")
        document = talk.wait("document")
    assert document["scenario"]["goal"]["east"] == 60.0
    assert document["unsaved"]


def test_cancelled_planning_is_resumed_and_a_place_is_found(studio: Studio) -> None:
    with studio.window() as talk:
        talk.wait("sketch")
        talk.say(kind="do", what="cancel")
        assert talk.wait_for_trouble("plan")["message"] == "planning was cancelled"
        talk.say(kind="do", what="plan")
        talk.wait("plan")
        with studio.window() as second:  # the server sends it the present state
            second.wait("plan")
            second.say(kind="find", place="47.3656, 8.5249")
            place = second.wait("found")["place"]
    assert place == pytest.approx([8.5249, 47.3656], abs=1e-3)


def test_contingencies_follow_the_plan_and_expire_after_a_change(studio: Studio) -> None:
    with studio.window() as talk:
        plan = talk.has("plan")
        strip = talk.wait("contingencies", lambda message: any(bar["costs"] for bar in message["bars"]))
        assert (strip["revision"], strip["flight"]) == (plan["revision"], 0)
        assert [bar["contingency"] for bar in strip["bars"]] == ["rtl", "land", "smart_rtl", "hold"]
        kinds = [message["kind"] for message in talk.heard]
        assert [kind for kind in kinds if kind in ("plan", "contingencies")][:1] == ["plan"]
        with studio.window() as second:  # the server sends it the present state
            assert second.wait("contingencies") == strip
        talk.say(kind="edit", seen=plan["revision"], label="slower", changes=[PUT_SPEED])
        document = talk.wait("document", lambda message: message["revision"] > plan["revision"])
        with studio.window() as second:
            assert second.wait("contingencies")["revision"] == document["revision"]


def test_a_mission_is_flown_only_after_it_was_named(studio: Studio) -> None:
    with studio.window() as talk:
        seen_at = talk.wait("document")["revision"]
        talk.say(kind="edit", seen=seen_at, label="higher", changes=[GOAL_HEIGHT | {"value": 12.0}])
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        assert "no proved plan" in talk.wait_for_trouble("flight")["message"]
        plan = talk.wait("plan", lambda plan: plan["revision"] > seen_at)
        talk.say(kind="start", vehicle="anything", mission=plan["name"], proof=plan["proof"])
        assert "no mission is loaded" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        named = {key: loaded[key] for key in ("vehicle", "mission", "proof")}
        assert named["proof"] == plan["proof"]
        talk.say(kind="start", **named | {"proof": "0123456789"})
        assert "not started: proof is" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="start", **named)
        landed = talk.wait("landed")
    seen = [answer for answer in talk.heard if answer["kind"] == "seen"]
    assert landed["completed"], landed["why_not"]
    assert abs(landed["flown_s"] - plan["total_s"]) < 0.05 * plan["total_s"]
    assert len(seen) > 100
    assert seen[-1]["done"] >= plan["stops"][-2]["seq"]
    assert [stop["seq"] for stop in plan["stops"]] == list(range(1, len(plan["stops"]) + 1))
    assert plan["stops"][0]["words"] == "take off"
    assert [body["name"] for body in plan["nearby"] if body["look"] == "beside"] == ["barn"]
    assert studio.scenario.with_suffix(".tlog").stat().st_size > 10_000


@pytest.mark.parametrize("order", ["rtl", "land"])
def test_a_flight_is_ended_from_the_page_by_what_it_was_told(studio: Studio, order: str) -> None:
    with studio.window() as talk:
        talk.wait("plan")  # which may be there already, and is told once
        talk.say(kind="order", what=order)
        assert "no vehicle is flying" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="upload", link=None, system=None, speedup=10.0)
        loaded = talk.wait("loaded")
        talk.say(kind="start", **{key: loaded[key] for key in ("vehicle", "mission", "proof")})
        seen = talk.wait("seen", lambda seen: seen["done"] > 0 and seen["orders"])
        talk.say(kind="order", what=order)
        left = talk.wait("state", lambda state: "as ordered" in state["words"])
        landed = talk.wait("landed")
    orders = {order["what"]: order for order in seen["orders"]}
    assert set(orders) == {"hold", "rtl", "land"}
    assert all(order["words"] and order["clear"] for order in orders.values())
    assert all(orders[name]["seconds"] > 5.0 for name in ("rtl", "land"))
    assert left["words"] == {"rtl": "it returns, as ordered", "land": "it lands, as ordered"}[order]
    assert landed["ordered"] == order
    assert not landed["completed"]


def test_the_page_plans_uploads_and_flies_a_scenario_over_terrain(studio: Studio) -> None:
    text = (Path(__file__).parents[2] / "missions" / "campus.toml").read_text()
    assert studio.client.get(f"/{TOKEN}/", headers={"host": HOST}).status_code == 200
    with studio.window() as talk:
        seen_at = talk.wait("document")["revision"]
        talk.say(kind="rewrite", seen=seen_at, text=text)
        assert "heights" in talk.wait("document", lambda message: message["revision"] > seen_at)["scenario"]["terrain"]
        plan = talk.wait("plan", lambda plan: plan["revision"] > seen_at)
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        talk.say(kind="start", **{key: loaded[key] for key in ("vehicle", "mission", "proof")})
        landed = talk.wait("landed")
    assert loaded["proof"] == plan["proof"]
    assert landed["completed"], landed["why_not"]
    assert abs(landed["flown_s"] - plan["total_s"]) < 0.05 * plan["total_s"]


def test_a_flight_of_another_scenario_is_not_started(studio: Studio) -> None:
    with studio.window() as talk:
        talk.wait("plan")
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        talk.say(kind="edit", seen=loaded["revision"], label="higher", changes=[GOAL_HEIGHT | {"value": 11.0}])
        talk.wait("document")
        talk.say(kind="start", **{key: loaded[key] for key in ("vehicle", "mission", "proof")})
        assert "changed after the upload" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="do", what="abandon")
        talk.wait("state", lambda state: state["phase"] == "idle")


@contextmanager
def beating(port: int, firmware: int, mav_type: int) -> Iterator[set[bytes]]:
    """Send heartbeats of a vehicle to a port; yield its messages."""
    heard, codec, is_over = set[bytes](), Codec(1, 1), threading.Event()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.settimeout(0.05)
        own.bind(("127.0.0.1", 0))

        def beat() -> None:
            while not is_over.is_set():
                own.sendto(codec.encode(Heartbeat(mav_type, firmware), EVERYONE, 0.0), ("127.0.0.1", port))
                with suppress(OSError):
                    heard.add(own.recv(300))

        thread = threading.Thread(target=beat)
        thread.start()
        yield heard
        is_over.set()
        thread.join()


def test_one_that_is_not_flown_is_refused_by_name_and_its_frames_are_kept(studio: Studio) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    with studio.window() as talk, beating(port, 3, 1) as heard:
        talk.wait("plan")
        talk.say(kind="upload", link=f"udpin:127.0.0.1:{port}", system=None, speedup=1.0)
        trouble = talk.wait_for_trouble("flight")
        words = talk.wait("state", lambda state: state["phase"] == "idle")["words"]
        talk.say(kind="upload", link=None, system=None, speedup=1.0)  # which who opens a window later is told of
        talk.wait("loaded")
        talk.say(kind="do", what="abandon")
        talk.wait("state", lambda state: state["phase"] == "idle")
        frames = [frame for frame in map(Codec(1, 1).decode, heard) if frame is not None]
    assert trouble["message"].startswith("vehicle 1 is an ArduPilot plane;")
    assert {type(frame.message) for frame in frames} == {Heartbeat}
    log = studio.scenario.with_name(words.removeprefix("every frame up to there is in "))
    assert log.suffix == ".tlog"
    assert log.stat().st_size > 0
    log.unlink()


def test_an_extract_that_is_dropped_stands_on_the_map(studio: Studio, tmp_path: Path) -> None:
    osmium = pytest.importorskip("osmium")
    with osmium.SimpleWriter(tmp_path / "town.osm.pbf") as writer:
        for number, place in enumerate([(8.5, 47.3002), (8.5001, 47.3002), (8.5001, 47.3003)], 1):
            writer.add_node(osmium.osm.mutable.Node(id=number, location=place))
        writer.add_way(osmium.osm.mutable.Way(id=1, nodes=[1, 2, 3, 1], tags={"building": "yes", "name": "Smithy"}))
    content = (tmp_path / "town.osm.pbf").read_bytes()
    answer = studio.client.post(
        f"/{TOKEN}/drop/town.osm.pbf", content=content, headers={"host": HOST, "origin": f"http://{HOST}"}
    )
    assert answer.json() == {"kind": "map", "file": "town.osm.pbf", "changes": []}
    assert (studio.scenario.parent / "town.osm.pbf").read_bytes() == content
    added = {"op": "add", "to": "maps", "table": {"kind": "buildings", "file": "town.osm.pbf"}}
    with studio.window() as talk:
        seen = talk.wait("document")["revision"]
        talk.say(kind="edit", seen=seen, label="map", changes=[added | {"place": None, "ring": None, "at": None}])
        talk.wait("world", lambda world: "Smithy" in [body["name"] for body in world["bodies"]])
