import json
from pathlib import Path

from ipoa_mission import MissionError, Scenario, plan_flight
from ipoa_mission.errors import Remedy
from ipoa_mission.planning.planner import sketch_path
from ipoa_mission.routing.refusal import ChangeTrials
from ipoa_mission.scenario.scenario_file import parse_scenario, parse_toml
from ipoa_mission.studio.edits import changed
from ipoa_mission.studio.remedies import plan_trouble
from ipoa_mission.studio.requests import Put
from ipoa_mission.studio.view import world_of
from ipoa_mission.studio.vocabulary import as_on_map
from tests.refused import refuses
from tests.studio.conftest import MEADOW

WOOD = [[[8.5002, 47.3002], [8.5004, 47.3002], [8.5004, 47.3003], [8.5002, 47.3002]]]
HOUSE = [[[8.5006, 47.2998], [8.5007, 47.2998], [8.5007, 47.2999], [8.5006, 47.2998]]]


def test_numbered_things_are_called_as_on_the_map() -> None:
    assert as_on_map("item 3: leaves fence[0] near via[1]") == "item 3: leaves fence 1 near via 2"


def test_a_place_that_is_too_low_is_offered_a_height_at_which_it_can_be() -> None:
    text = MEADOW.read_text() + "\n[[via]]\neast = 30.0\nnorth = 0.0\nheight_above_ground = 2.0\n"
    with refuses("place-blocked", "via[0]") as caught:
        sketch_path(parse_scenario(text, MEADOW))
    trouble = plan_trouble(caught.value, parse_scenario(text, MEADOW))
    assert trouble.message.startswith("via 1: nothing can fly there")
    (remedy,) = trouble.remedies
    assert remedy.label.startswith("Via 1 to ")
    mended = parse_scenario(changed(text, remedy.changes), MEADOW)
    assert sketch_path(mended).proof.is_proved


def test_a_change_that_was_tried_is_offered() -> None:
    text = MEADOW.read_text()
    scenario = parse_scenario(text, MEADOW)
    looks = ChangeTrials(scenario, lambda changed_scenario: None)
    for change, meant in looks.changes.items():
        (remedy,) = plan_trouble(MissionError("a path is there", remedies=(change,)), scenario).remedies
        assert parse_scenario(changed(text, remedy.changes), MEADOW) == meant
        assert remedy.label.endswith("(tried)")


def test_a_wood_without_a_height_is_drawn_and_can_be_given_one(tmp_path: Path) -> None:
    features = [
        {"type": "Feature", "id": name, "properties": tags, "geometry": {"type": "Polygon", "coordinates": ring}}
        for name, tags, ring in (("way/9", {"natural": "wood"}, WOOD), ("way/8", {"building": "yes"}, HOUSE))
    ]
    (tmp_path / "town.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    text = MEADOW.read_text() + '\n[[maps]]\nkind = "buildings"\nfile = "town.geojson"\n'
    scenario = Scenario.from_dict(parse_toml(text, MEADOW), tmp_path)
    (doubt,) = [body for body in world_of(scenario).bodies if body.doubt]
    assert doubt.name
    (thing,) = [thing for thing in scenario.passed_over if thing.may_be_obstacle]
    heights = tuple(Remedy(("maps", 0, key), value) for key, value in thing.heights)
    high, none = plan_trouble(MissionError("it crosses a wood", remedies=heights), scenario).remedies
    assert high.label == "Woods of town.geojson are 35 m high"
    for remedy, stand in ((high, 1), (none, 0)):
        mended = Scenario.from_dict(parse_toml(changed(text, remedy.changes), MEADOW), tmp_path)
        assert not mended.passed_over or not any(thing.may_be_obstacle for thing in mended.passed_over)
        assert len(mended.airspace.obstacles) == len(scenario.airspace.obstacles) + stand


def test_an_unclear_return_offers_a_higher_one_a_planned_one_or_none() -> None:
    text = MEADOW.read_text().replace('ending = "land"', 'ending = "rtl"').replace("height = 25.0", "height = 70.0")
    scenario = parse_scenario(text, MEADOW)
    with refuses("unsafe", "", "barn") as caught:
        plan_flight(scenario, seed=7)
    planned, landed = plan_trouble(caught.value, scenario).remedies
    assert (planned.label, landed.label) == ("Plan the way home too", "Land at the goal")
    for remedy in (planned, landed):
        plan_flight(parse_scenario(changed(text, remedy.changes), MEADOW), seed=7)
    changes = (Remedy(("vehicle", "parameters", "RTL_ALT"), 5000.0), *caught.value.remedies)
    higher, *_ = plan_trouble(MissionError("item 4: the way home", remedies=changes), scenario).remedies
    mended = parse_scenario(changed(text, higher.changes), MEADOW)
    assert mended.vehicle.parameters == {**scenario.vehicle.parameters, "RTL_ALT": 5000.0}


def test_unread_features_can_be_ignored() -> None:
    scenario = parse_scenario(MEADOW.read_text(), MEADOW).ignoring(["wind-not-measured"])
    error = MissionError("zones.kml: not read: NetworkLink: zones [not-read]")
    error.known = {"codes": ["not-read"]}
    (remedy,) = plan_trouble(error, scenario).remedies
    assert remedy.changes == (Put(path=("safety", "ignore"), value=["wind-not-measured", "not-read"]),)
