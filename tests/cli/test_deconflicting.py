"""`deconflict`: conflicts, repairs, files, and bad input."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission import Geodetic, Mission, read_mission, write_mission
from ipoa_mission.fleet.deconflict_verb import names_of_changed
from tests.cli.conftest import Run
from tests.fleet.crossings import FRAME, at, eastward, northward, route


def write(**missions: Mission) -> None:
    for name, mission in missions.items():
        write_mission(mission, Path(f"{name}.plan"))


@pytest.fixture(autouse=True)
def crossing(run: Run) -> None:
    write(east=eastward(), north=northward())


def test_conflict_is_named_by_pair_place_time_and_probability(run: Run) -> None:
    result = json.loads(run("deconflict east.plan north.plan --json").out)
    (conflict,) = result["conflicts"]
    crossing = at(100, 0)
    assert conflict["pair"] == ["east", "north"]
    assert conflict["latitude_deg"] == pytest.approx(crossing.latitude_deg, abs=2e-4)
    assert conflict["longitude_deg"] == pytest.approx(crossing.longitude_deg, abs=4e-4)
    assert conflict["altitude_amsl"] == pytest.approx(508.0, abs=1.0)
    assert 25.0 < conflict["second"] < 40.0
    assert 0.001 < conflict["probability"] < 1.0
    assert not [row for row in result["remaining"] if row["probability"] > 0.001]
    assert "possible losses of a separation of 10 m" in run("deconflict east.plan north.plan").out


def test_wind_changes_the_probability_of_a_conflict(run: Run) -> None:
    calm, windy = (json.loads(run(f"deconflict east.plan north.plan {air} --json").out) for air in ("", "--wind 8@270"))
    assert windy["conflicts"][0]["probability"] != pytest.approx(calm["conflicts"][0]["probability"], rel=0.01)
    assert not [row for row in windy["remaining"] if row["probability"] > 0.001]
    assert run("deconflict east.plan north.plan --wind north").code == 2


def test_the_written_timetable_has_no_conflict(run: Run) -> None:
    ended = run("deconflict east.plan north.plan --most-delay 0 --out repaired --json")
    assert ended.code == 0
    result = json.loads(ended.out)
    (changed,) = [slot for slot in result["timetable"] if slot["change"]]
    assert [Path(file).name for file in result["written"]] == [f"{changed['mission']}.plan", "timetable.json"]
    assert json.loads(Path("repaired/timetable.json").read_text())["timetable"] == result["timetable"]
    assert changed["added_s"] == pytest.approx(result["added_s"])
    again = json.loads(run(f"deconflict {' '.join(slot['file'] for slot in result['timetable'])} --json").out)
    assert all(conflict["probability"] <= 0.001 for conflict in again["conflicts"])
    assert again["added_s"] == 0.0


def test_a_departure_is_delayed_by_no_more_than_is_needed(run: Run) -> None:
    slots = json.loads(run("deconflict east.plan north.plan --json").out)["timetable"]
    times = [slot["departs_s"] for slot in slots]
    assert min(times) == 0.0 < max(times)
    for sooner_s, is_enough in ((0.0, True), (1.0, False)):
        departures = ",".join(f"{max(time - sooner_s, 0.0):g}" for time in times)
        again = json.loads(run(f"deconflict east.plan north.plan --departures {departures} --json").out)
        assert (again["added_s"] == 0.0) is is_enough


def test_pair_that_no_repair_keeps_apart_is_named(run: Run) -> None:
    write(near=route("ardupilot", (6, 0), (6, 80)))
    ended = run("deconflict east.plan north.plan near.plan --out repaired --json")
    result = json.loads(ended.out)
    assert ended.code == 1
    assert sorted(result["blocking"]) == ["east", "near"]
    assert "timetable" not in result
    assert not Path("repaired").exists()
    assert "keep east and near apart" in run("deconflict east.plan near.plan").out


def test_one_pad_is_used_by_one_mission_after_the_other(run: Run) -> None:
    write(again=route("px4", (0, 0), (0, 80)))
    slots = json.loads(run("deconflict east.plan again.plan --json").out)["timetable"]
    assert abs(slots[1]["departs_s"] - slots[0]["departs_s"]) > 8.0


FAR = Geodetic(40.0, 8.5, 100.0)


def edited(name: str, **changes: object) -> None:
    """Write `east.plan` with other values of its mission; None: without the key."""
    plan = json.loads(Path("east.plan").read_text())
    changed = plan["mission"] | changes
    plan["mission"] = {key: value for key, value in changed.items() if value is not None}
    Path(f"{name}.plan").write_text(json.dumps(plan))


@pytest.fixture
def bad_files(crossing: None) -> None:
    east = eastward()
    low = replace(east, home=replace(east.home, altitude=0.0))
    north = northward()
    write(
        far=replace(east, home=FAR, items=tuple(replace(item, latitude_deg=40.0) for item in east.items)),
        low=low,
        low_too=replace(north, home=replace(north.home, altitude=0.0)),
        endless=replace(east, items=tuple(replace(item, command=17) for item in east.items if item.is_waypoint)),
        waiting=replace(east, items=()),
    )
    edited("homeless", plannedHomePosition=None)
    edited("nowhere", plannedHomePosition=[None, None, None])
    edited("plane", vehicleType=1, firmwareType=3)
    edited("rover", vehicleType=10)
    edited("vtol", vehicleType=20)
    Path("alias.plan").symlink_to("east.plan")
    Path("folder.plan").mkdir()
    Path("empty.plan").touch()


@pytest.mark.usefixtures("bad_files")
@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("east.plan", "FILE: expected two missions or more"),
        ("east.plan ./east.plan", "expected each vehicle once"),
        ("east.plan north.plan alias.plan", "alias.plan: expected each vehicle once"),
        ("east.plan far.plan", "far.plan: expected a home within 50 km of east.plan's, not 822 km away"),
        ("east.plan low.plan", "low.plan: expected the altitude of home, not 0 m AMSL, as homes differ"),
        ("low_too.plan low.plan", "low_too.plan: expected the altitude of home, not 0 m AMSL, as homes differ"),
        ("east.plan homeless.plan", 'homeless.plan: mission: expected "plannedHomePosition"'),
        ("east.plan nowhere.plan", "nowhere.plan: mission.plannedHomePosition[0]: expected degrees"),
        ("east.plan plane.plan", "plane.plan: expected a mission of a multicopter, not of a plane"),
        ("east.plan rover.plan", "rover.plan: expected a mission of a multicopter, not of a rover"),
        ("east.plan vtol.plan", "vtol.plan: expected a mission of a multicopter, not of a VTOL"),
        ("east.plan endless.plan", "endless.plan: item 1: "),
        ("east.plan waiting.plan", "waiting.plan: the vehicle stays where it is"),
        ("east.plan fleet.toml", "fleet.toml: expected a mission (.plan, .waypoints), not a scenario"),
        ("east.plan folder.plan", "folder.plan"),
        ("east.plan empty.plan", "empty.plan"),
        ("east.plan none.plan", "none.plan"),
        ("east.plan north.plan --departures 0", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,1_0", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,-1", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,nan", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,inf", "--departures: expected 2 times of 0 s or more"),
        ("east.plan north.plan --departures 0,soon", "expected 2 times of 0 s or more, as 0,30, not 0,soon"),
        ("east.plan north.plan --separation 0", "--separation"),
        ("east.plan north.plan --separation nan", "--separation"),
        ("east.plan north.plan --separation inf", "--separation"),
        ("east.plan north.plan --confidence 1", "--confidence"),
        ("east.plan north.plan --most-delay -1", "--most-delay"),
        ("east.plan north.plan --most-delay inf", "--most-delay"),
    ],
)
def test_bad_input_is_named_and_nothing_is_written(words: str, message: str, run: Run) -> None:
    before = sorted(Path().iterdir())
    ended = run(f"deconflict {words} --out repaired")
    assert (ended.code, ended.out) == (2, "")
    assert message in ended.err
    assert sorted(Path().iterdir()) == before


def test_a_mission_is_never_written_over(run: Run) -> None:
    before = {file: file.read_bytes() for file in Path().glob("*.plan")}
    ended = run("deconflict east.plan north.plan --most-delay 0 --out . --force")
    assert (ended.code, ended.out) == (2, "")
    assert "nothing is written over them" in ended.err
    assert {file: file.read_bytes() for file in Path().iterdir()} == before


@pytest.mark.parametrize(
    ("stems", "names"),
    [
        (["a", "b"], ["a", "b"]),
        (["a", "a", "a"], ["a", "a-2", "a-3"]),
        (["a-3", "a", "a"], ["a-3", "a", "a-3-3"]),
        (["a", "a", "a-2"], ["a", "a-2", "a-2-3"]),
        (["a", "A"], ["a", "A-2"]),
    ],
)
def test_no_changed_mission_is_written_over_another(stems: list[str], names: list[str]) -> None:
    assert names_of_changed(stems) == names


def test_files_are_written_together_or_not_at_all(run: Run) -> None:
    Path("repaired").mkdir()
    Path("repaired/timetable.json").write_text("mine")
    ended = run("deconflict east.plan north.plan --most-delay 0 --out repaired")
    assert ended.code == 2
    assert [file.name for file in Path("repaired").iterdir()] == ["timetable.json"]
    assert Path("repaired/timetable.json").read_text() == "mine"


def test_contingency_that_may_meet_a_planned_flight_is_a_warning(run: Run) -> None:
    ended = run("deconflict east.plan north.plan --json")
    result = json.loads(ended.out)
    assert ended.code == 0
    holds = [
        row for row in result["contingencies"] if row["contingency"] == "hold" and row["pair"] == ["north", "east"]
    ]
    (hold,) = holds
    assert 20.0 < hold["from_s"] < hold["to_s"] < 45.0
    place = FRAME.local(Geodetic(hold["latitude_deg"], hold["longitude_deg"], hold["altitude_amsl"]))
    assert abs(place[1]) < 12.0
    unknown = {(row["vehicle"], row["contingency"]) for row in result["unknown_contingencies"]}
    assert unknown == {("north", "smart_rtl")}
    assert "unknown: smart_rtl of north" in run("deconflict east.plan north.plan").out


def test_written_missions_are_those_that_were_read_but_for_the_change(run: Run) -> None:
    write(north=northward().with_parameters({"WP_ACC": 2.0}))
    run("deconflict east.plan north.plan --most-delay 0 --out repaired")
    for file in Path("repaired").glob("*.plan"):
        before, after = read_mission(file.name), read_mission(file)
        assert (before.home, before.parameters) == (after.home, after.parameters)
        assert len(before.items) == len(after.items)
        assert before.items != after.items
