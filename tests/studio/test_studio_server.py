"""What the page asks is done, told to every window, and nothing of it is lost."""

from pathlib import Path

import pytest

from ipoa_mission import read_scenario
from tests.studio.conftest import MEADOW, Studio

pytestmark = pytest.mark.xdist_group("studio server")

PUT_SPEED = {"op": "put", "path": ["vehicle", "cruise_speed"], "value": 9.0}


def test_a_window_is_shown_the_scenario_and_a_first_path(studio: Studio) -> None:
    with studio.window() as talk:
        document = talk.wait("document")
        world, sketch = talk.wait("world"), talk.wait("sketch")
    assert document["scenario"]["goal"] == {"east": 60.0, "north": 0.0, "up": 10.0}
    assert len(world["bodies"]) == len(read_scenario(studio.scenario).airspace.obstacles)
    assert [spot["name"] for spot in world["spots"]] == ["home", "start", "goal"]
    assert sketch["holds"]
    assert sketch["clearance"] >= world["required"]


def test_a_change_is_told_to_every_window_and_saved_with_its_comments(studio: Studio) -> None:
    before = studio.scenario.read_text()
    with studio.window() as one, studio.window() as other:
        document = one.wait("document")
        other.wait("document")
        one.say(kind="edit", seen=document["revision"], label="slower", changes=[PUT_SPEED])
        told = one.wait("document")
        assert told["scenario"] == other.wait("document")["scenario"]
        assert told["scenario"]["vehicle"]["cruise_speed"] == 9.0
        assert told["unsaved"]
        assert studio.scenario.read_text() == before
        other.say(kind="do", what="save")
        assert not one.wait("document")["unsaved"]
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


def test_what_makes_no_sense_is_told_to_the_window_that_asked_it(studio: Studio) -> None:
    with studio.window() as talk:
        seen = talk.wait("document")["revision"]
        talk.wait("world")
        talk.say(kind="edit", seen=seen, label="x", changes=[{"op": "take", "path": ["obstacles", 99]}])
        assert "obstacles.99" in talk.wait_for_trouble("edit")["message"]
        talk.say(kind="launch the rocket")
        assert "makes no sense" in talk.wait_for_trouble("edit")["message"]
        talk.say(kind="edit", seen=seen, label="x", changes=[PUT_SPEED | {"value": -3.0}])
        assert "vehicle.cruise_speed: expected" in talk.wait_for_trouble("scenario")["message"]
        talk.say(kind="do", what="undo")
        talk.wait("world")


def test_a_change_of_lists_that_were_numbered_anew_is_refused(studio: Studio) -> None:
    first = {"op": "take", "path": ["obstacles", 0]}
    with studio.window() as one, studio.window() as other:
        seen = one.wait("document")["revision"]
        other.wait("document")
        one.say(kind="edit", seen=seen, label="barn removed", changes=[first])
        document = other.wait("document", lambda told: told["revision"] > seen)
        other.say(kind="edit", seen=seen, label="barn removed", changes=[first])
        assert "changed elsewhere" in other.wait_for_trouble("edit")["message"]
    assert [body["name"] for body in document["scenario"]["obstacles"]] == ["silo"]


def test_what_another_program_writes_is_taken_and_can_be_undone(studio: Studio) -> None:
    with studio.window() as talk:
        talk.wait("sketch")
        Path(studio.scenario).write_text(studio.scenario.read_text().replace("east = 60.0", "east = 59.0"))
        assert talk.wait("document")["scenario"]["goal"]["east"] == 59.0
        talk.say(kind="do", what="undo")
        document = talk.wait("document")
    assert document["scenario"]["goal"]["east"] == 60.0
    assert document["unsaved"]
