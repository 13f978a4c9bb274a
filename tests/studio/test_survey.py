import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from ipoa_mission import plan_survey
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingency.contingencies import Contingencies
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.survey.survey_section import survey_of, surveyed_area
from ipoa_mission.survey.survey_task import expect_survey
from tests.studio.conftest import HOST, MEADOW, Studio

from ipoa_mission.studio.answers import Remedy, Trouble  # isort: skip
from ipoa_mission.studio.edits import changed
from ipoa_mission.studio.flight_desk import BatteryGuard
from ipoa_mission.studio.plan_worker import look, sketch
from ipoa_mission.studio.remedies import plan_trouble
from ipoa_mission.studio.requests import Change, Corner, DrawArea, MapArea, OwnArea, Put, Shift, Take, Upload
from ipoa_mission.studio.vocabulary import LngLat
from tests.refused import refuses

OUTLINE: tuple[LngLat, ...] = ((8.5001, 47.2998), (8.5007, 47.2998), (8.5007, 47.3002), (8.5001, 47.3002))
HOLE: tuple[LngLat, ...] = ((8.5002, 47.2999), (8.5003, 47.2999), (8.5003, 47.3))
CAMPUS_LOG = Path(__file__).parents[2] / "missions/logs/campus-arducopter.tlog"
OWN = {"host": HOST, "origin": f"http://{HOST}"}
BESIDE: tuple[LngLat, ...] = tuple((east + 0.001, north) for east, north in OUTLINE)
WIDE = Put(path=("bounds",), value={"east": [-50.0, 250.0], "north": [-60.0, 60.0], "up": [-5.0, 80.0]})
FIRST: tuple[str | int, ...] = ("survey", "polygon", 0, 0)


def asked(key: str, value: Any) -> Put:
    """A key of [survey]."""
    return Put(path=("survey", key), value=value)


PHOTOS = asked("camera", "DJI Mavic 3E")
LARGE_BARN = [Put(path=("obstacles", 0, side), value=200.0) for side in ("width", "depth")]


#: The way home leads between barn and silo.
NARROW: list[Change] = [
    asked("polygon", [[-10, -30], [70, -30], [70, 30], [-10, 30]]),
    *(asked("line_spacing", 8.0), asked("height_above_ground", 20.0)),
]


def drawn(*changes: Change) -> str:
    return changed(MEADOW.read_text(), [WIDE, DrawArea(what="area", ring=OUTLINE), *changes])


def scenario(*changes: Change) -> Scenario:
    return parse_scenario(drawn(*changes), MEADOW)


def area(*changes: Change) -> Any:
    drawn = surveyed_area(scenario(*changes))
    assert drawn is not None
    return drawn.shape


def on_map(ring: tuple[LngLat, ...]) -> Any:
    """Convert to meters from the meadow's home, by plain geometry."""
    wide, high = 111_412.84 * np.cos(np.radians(47.3)) - 93.5 * np.cos(3 * np.radians(47.3)), 111_170.0
    return shapely.Polygon([((east - 8.5) * wide, (north - 47.3) * high) for east, north in ring])


# --- the text ---------------------------------------------------------------------------------------------------------


def test_an_area_that_is_drawn_stands_in_place_of_start_and_goal() -> None:
    text = drawn()
    flown = parse_scenario(text, MEADOW)
    assert area().symmetric_difference(on_map(OUTLINE)).area < 0.01 * area().area
    assert "[goal]" not in text
    assert "[start]" not in text
    assert flown.start_point.tolist() == flown.goal_point.tolist() == [0.0, 0.0, 40.0]
    assert "# Two barns on a meadow" in text
    assert text.count("[[obstacles]]") == 2


def test_holes_areas_and_corners_join_and_leave() -> None:
    hole = DrawArea(what="hole", ring=HOLE)
    assert len(area(hole).geoms[0].interiors) == 1
    both = area(hole, DrawArea(what="area", ring=BESIDE))
    assert [len(part.interiors) for part in both.geoms] == [1, 0]
    into = DrawArea(what="hole", ring=tuple((east + 0.001, north) for east, north in HOLE))
    assert [len(part.interiors) for part in area(DrawArea(what="area", ring=BESIDE), into).geoms] == [0, 1]
    more = area(Corner(op="add_corner", path=(*FIRST, 1), place=(8.5004, 47.2997)))
    assert more.area > area().area
    assert area(Corner(op="add_corner", path=(*FIRST, 1), place=(8.5004, 47.2997)), Take(path=(*FIRST, 1))).equals(
        area()
    )
    assert area(hole, Take(path=("survey", "polygon", 0, 1))).equals(area())
    single = area(DrawArea(what="area", ring=BESIDE), Take(path=FIRST))
    assert single.symmetric_difference(on_map(BESIDE)).area < 0.01 * single.area


def test_a_corner_is_moved_and_all_else_stays_byte_for_byte() -> None:
    text = drawn()
    moved = changed(text, [Corner(op="put_corner", path=(*FIRST, 2), place=(8.5008, 47.3003))])
    lines = [(old, new) for old, new in zip(text.splitlines(), moved.splitlines(), strict=True) if old != new]
    assert [line.split("=")[0] for pair in lines for line in pair] == ["polygon ", "polygon "]
    before, after = (np.array(json.loads(line.split("=")[1])) for line in lines[0])
    assert np.abs(before - after).max(axis=3).astype(bool).tolist() == [[[False, False, True, False]]]


def test_a_ring_that_is_written_closed_is_open_after_an_edit() -> None:
    closed = Put(path=("survey", "polygon"), value=[[10, 0], [50, 0], [50, 20], [10, 20], [10, 0]])
    for change in (Corner(op="put_corner", path=(*FIRST, 0), place=OUTLINE[0]), Take(path=(*FIRST, 0))):
        survey = survey_of(scenario(closed, change))
        assert survey is not None
        assert survey.polygon is not None
        ((ring,),) = survey.polygon
        assert len(ring) == (3 if isinstance(change, Take) else 4)
        assert (10, 0) not in [tuple(corner) for corner in ring]


def test_edits_that_leave_no_area_are_refused() -> None:
    for taken in ((*FIRST, 0), FIRST):
        with refuses("invalid-ring"):
            drawn(
                Corner(op="add_corner", path=(*FIRST, 1), place=(8.5004, 47.2997)),
                *[Take(path=(*FIRST, 1))] * 2,
                Take(path=taken),
            )
    with refuses("bad-input", "hole"):
        drawn(DrawArea(what="hole", ring=BESIDE))


def test_home_moves_alone_and_an_area_moves_whole() -> None:
    there = Shift(path=("home",), taken=(8.5, 47.3), put_down=(8.5002, 47.3001))
    step = on_map(((8.5, 47.3), (8.5002, 47.3001), (8.5, 47.3001))).exterior.coords[1]
    left = shapely.affinity.translate(area(), -step[0], -step[1])
    assert area(there).symmetric_difference(left).area < 0.01 * left.area
    along = Shift(path=("survey", "polygon"), taken=(8.5, 47.3), put_down=(8.5002, 47.3001))
    right = shapely.affinity.translate(area(), *step[:2])
    assert area(along).symmetric_difference(right).area < 0.01 * right.area


def test_a_corridor_and_a_map_take_the_area_s_place(tmp_path: Path) -> None:
    corridor = scenario(DrawArea(what="corridor", ring=OUTLINE[:2]))
    assert expect_survey(corridor)[0].polygon is None
    assert expect_survey(corridor)[1].shape.area == pytest.approx(40.0 * 45.4, rel=0.01)
    feature = {
        "type": "Feature",
        "properties": {},
        "geometry": {"type": "Polygon", "coordinates": [[*OUTLINE, OUTLINE[0]]]},
    }
    (tmp_path / "field.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    text = changed(MEADOW.read_text(), [WIDE, MapArea(file="field.geojson")])
    mapped = parse_scenario(text, tmp_path / "x.toml")
    assert expect_survey(mapped)[1].shape.symmetric_difference(area()).area < 0.01 * area().area
    own = parse_scenario(changed(text, [OwnArea(parts=((OUTLINE, HOLE),))]), tmp_path / "x.toml")
    assert expect_survey(own)[0].area is None
    assert len(expect_survey(own)[1].shape.geoms[0].interiors) == 1


# --- what is refused, and what helps ----------------------------------------------------------------------------------


def messages_of(job: Any, text: str) -> list[Any]:
    messages = list[Any]()
    order = {"text": text, "path": str(MEADOW), "revision": 1, "number": None, "changes": []}
    job(order, messages.append)
    return messages


def remedy(trouble: Any, label: str) -> Remedy:
    assert isinstance(trouble, Trouble)
    remedy_there: Remedy = next(remedy for remedy in trouble.remedies if label in remedy.label)
    return remedy_there


@pytest.mark.parametrize(
    ("wrong", "label"),
    [
        ([asked("height_above_ground", 1.0)], "m above ground"),
        ([asked("height_above_ground", 24.0), *LARGE_BARN], "over"),
        ([PHOTOS, asked("line_spacing", 90.0)], "apart"),
        ([PHOTOS, asked("front_overlap", 0.999)], "usual"),
    ],
)
def test_a_survey_that_is_refused_at_once_is_laid_with_its_remedy(wrong: list[Change], label: str) -> None:
    text = drawn(*wrong)
    trouble = messages_of(sketch, text)[-1]
    assert trouble.of == "sketch"
    assert "survey." not in trouble.message
    assert messages_of(sketch, changed(text, remedy(trouble, label).changes))[-1].kind == "coarse_survey"


@pytest.mark.parametrize(
    ("wrong", "label"),
    [
        ([asked("flights", 99)], "flights"),
        ([asked("flights", 99)], "As few"),
        ([Put(path=("bounds",), value={"up": [-5.0, 30.0]})], "Bounds"),
        pytest.param(NARROW, "over ", marks=pytest.mark.long),
    ],
)
def test_a_survey_that_is_refused_is_planned_with_its_remedy(
    wrong: list[Change], label: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(*wrong)
    wanted = parse_scenario(text, MEADOW)
    with monkeypatch.context() as hurried:
        hurried.setattr("ipoa_mission.survey.survey_plan.ROUNDS", 1)  # give no more room
        with pytest.raises(MissionError) as error:
            plan_survey(scenario=wanted)
    trouble = plan_trouble(error.value, wanted)
    mended = parse_scenario(changed(text, remedy(trouble, label).changes), MEADOW)
    assert plan_survey(scenario=mended).plan.coverage.share > 0.999


def test_an_area_that_makes_no_sense_is_shown_and_named_as_on_the_map() -> None:
    text = drawn(
        DrawArea(what="area", ring=BESIDE), Corner(op="put_corner", path=(*FIRST, 0), place=(8.5009, 47.30015))
    )
    shown, trouble = messages_of(look, text)
    assert [ring.name for ring in shown.rings] == ["area 1", "area 2"]
    assert len(shown.rings[0].places) == 4
    assert trouble.message.startswith("area 1: expected a ring that does not cross")
    away = Shift(path=("survey", "polygon", 0, 1), taken=HOLE[0], put_down=(8.51, 47.3))
    text = drawn(DrawArea(what="hole", ring=HOLE), away)
    _, trouble = messages_of(look, text)
    assert trouble.message.startswith("hole 1: expected a hole inside")
    assert messages_of(look, changed(text, remedy(trouble, "Take hole 1 out").changes))[-1].kind == "world"


# --- the server -------------------------------------------------------------------------------------------------------


def survey_text() -> str:
    return drawn(PHOTOS, asked("line_spacing", 12.0), asked("flights", 2))


def test_a_survey_is_laid_planned_dragged_and_written_as_plan_writes_it(studio: Studio, tmp_path: Path) -> None:
    text = survey_text()
    with studio.window() as talk:
        talk.say(kind="rewrite", seen=talk.wait("document")["revision"], text=text)
        assert talk.wait("area", lambda area: area["rings"])["rings"][0]["path"] == list(FIRST)
        planned, coarse = talk.has("survey"), talk.has("coarse_survey")
        own = planned["revision"]  # contingencies of what was there before may come late

        def of_flight(n: int) -> Any:
            return talk.has("contingencies", lambda message: (message["revision"], message["flight"]) == (own, n))

        strips = [of_flight(n) for n in (0, 1)]
        turn = {"op": "put", "path": ["survey", "direction_deg"], "value": 30.0}
        talk.say(kind="drag", number=7, changes=[turn])
        dragged = talk.wait("coarse_survey", lambda answer: answer["number"] == 7)
        talk.say(kind="do", what="export")
        written = talk.wait("written")["files"]
    survey = plan_survey(scenario=parse_scenario(text, studio.scenario))
    assert coarse["layout"]["share"] == planned["layout"]["share"] == survey.plan.coverage.share > 0.999
    assert [line["begin"] for line in coarse["layout"]["lines"]] == [
        line["begin"] for line in planned["layout"]["lines"]
    ]
    assert dragged["layout"]["degrees"] == pytest.approx(30.0, abs=0.5)
    assert planned["total_s"] == pytest.approx(survey.total_s, abs=0.01)
    assert [part["file"] for part in planned["flights"]] == ["meadow-1.plan", "meadow-2.plan"]
    assert sum(part["photos"] for part in planned["flights"]) == survey.plan.photos
    assert sum(len(line["photos"]) for line in planned["layout"]["lines"]) == survey.plan.photos
    assert len({part["plan"]["proof"] for part in planned["flights"]}) == 2
    for strip, forecast in zip(strips, survey.flights, strict=True):
        words = [stretch["words"] for bar in strip["bars"] for stretch in bar["stretches"]]
        assert words == [row.in_full for row in Contingencies(forecast).all_rows(timed=False)]
    survey.write(tmp_path)
    for file in sorted(path.name for path in tmp_path.iterdir()):
        assert file in written
        assert (studio.scenario.parent / file).read_bytes() == (tmp_path / file).read_bytes()
    assert {"meadow-1.html", "meadow-2.html"} <= set(written)


def test_the_flights_are_flown_one_after_the_other(studio: Studio) -> None:
    with studio.window() as talk:
        talk.say(kind="rewrite", seen=talk.wait("document")["revision"], text=survey_text())
        planned = talk.wait("survey", lambda survey: len(survey["flights"]) == 2)
        talk.say(kind="upload", link=None, system=None, speedup=1000.0, flight=2)
        assert "flight 3: expected one of 2" in talk.wait_for_trouble("flight")["message"]
        for n, part in enumerate(planned["flights"]):
            talk.say(kind="upload", link=None, system=None, speedup=1000.0, flight=n)
            loaded = talk.wait("loaded")
            assert (loaded["mission"], loaded["proof"]) == (f"meadow-{n + 1}", part["plan"]["proof"])
            talk.say(kind="start", **{key: loaded[key] for key in ("vehicle", "mission", "proof")})
            landed = talk.wait("landed")
            assert landed["completed"], landed["why_not"]
            talk.wait("state", lambda state: state["phase"] == "over")
            assert landed["log"].startswith(f"meadow-{n + 1}")  # another test may have flown a second meadow
            assert landed["flown_s"] == pytest.approx(part["plan"]["total_s"], rel=0.05)
            talk.say(kind="rest", logs=[landed["log"]])
            rest = talk.wait("survey")
            assert rest["flown"] == [landed["log"]]
            assert [flight["plan"]["name"] for flight in rest["flights"]] == ["meadow-rest"]
            assert rest["flights"][0]["lines"] == planned["flights"][1 - n]["lines"]
            talk.say(kind="rest", logs=[])
            again = talk.wait("survey")
            assert (again["flown"], again["total_s"]) == ([], planned["total_s"])
        talk.say(kind="rest", logs=["meadow.toml"])
        assert "meadow.toml: expected a log" in talk.wait_for_trouble("edit")["message"]
        shutil.copy(CAMPUS_LOG, studio.scenario.parent)
        talk.say(kind="rest", logs=[CAMPUS_LOG.name])
        remark = f"{CAMPUS_LOG.name}: no flight in it follows the lines of this survey"
        assert talk.wait_for_trouble("edit")["message"] == remark
        assert talk.wait("survey")["flown"] == []


def test_the_next_flight_on_a_link_waits_for_a_battery_of_the_same_vehicle() -> None:
    relay, on_link = BatteryGuard(), Upload(link="udpin:127.0.0.1:14550")
    assert relay.expect_charged(on_link, is_survey=True) == on_link
    relay.hear({"kind": "loaded", "mission": "field-1", "system": 7})
    again = relay.expect_charged(on_link, is_survey=True)  # nothing has turned yet
    assert again.system == 7
    relay.hear({"kind": "loaded", "mission": "field-1", "system": 7})
    relay.hear({"kind": "state", "phase": "flying"})
    following = on_link.model_copy(update={"flight": 1})
    with refuses("battery-flown", "", "field-1"):
        relay.expect_charged(following, is_survey=True)
    assert relay.expect_charged(Upload(), is_survey=True) == Upload()  # the built-in autopilot has no battery to change
    with refuses("battery-flown"):
        relay.expect_charged(following, is_survey=True)
    flown = relay.expect_charged(following.model_copy(update={"charged": True}), is_survey=True)
    assert flown.system == 7
    assert relay.expect_charged(on_link, is_survey=False) == on_link
