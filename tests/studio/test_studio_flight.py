"""A flight from the page: uploaded, named, started, watched on the built-in autopilot; and refused where it must be."""

import pytest

from tests.studio.conftest import Studio

pytestmark = pytest.mark.xdist_group("studio flight")


def test_a_mission_is_flown_only_after_it_was_named(studio: Studio) -> None:
    with studio.window() as talk:
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        assert "no proved plan" in talk.wait_for_trouble("flight")["message"]
        plan = talk.wait("plan")
        talk.say(kind="start", vehicle="anything", mission=plan["name"], proof=plan["proof"])
        assert "no mission is loaded" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        named = {what: loaded[what] for what in ("vehicle", "mission", "proof")}
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
    assert studio.scenario.with_suffix(".tlog").stat().st_size > 10_000


def test_a_flight_of_another_scenario_is_not_started(studio: Studio) -> None:
    with studio.window() as talk:
        talk.wait("plan")
        talk.say(kind="upload", link=None, system=None, speedup=1000.0)
        loaded = talk.wait("loaded")
        change = {"op": "put", "path": ["goal", "up"], "value": 11.0}
        talk.say(kind="edit", seen=loaded["revision"], label="lower", changes=[change])
        talk.wait("document")
        talk.say(kind="start", **{what: loaded[what] for what in ("vehicle", "mission", "proof")})
        assert "changed after the upload" in talk.wait_for_trouble("flight")["message"]
        talk.say(kind="do", what="abandon")
        talk.wait("state", lambda state: state["phase"] == "idle")
