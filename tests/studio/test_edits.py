import difflib
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.scenario import parse_scenario

pytest.importorskip("tomlkit")
from ipoa_mission.studio.dropped import changes_of, keep
from ipoa_mission.studio.edits import changed
from ipoa_mission.studio.requests import Add, Change, Put, Shift, Take
from ipoa_mission.studio.scenario_document import Document
from ipoa_mission.studio.vocabulary import Path as Path_
from tests.refused import refuses
from tests.studio.conftest import MEADOW

MISSIONS = MEADOW.parents[2] / "missions"
SCENARIOS = sorted(MISSIONS.rglob("*.toml"))
KEY = "safety_distance"


def difference(before: str, after: str) -> list[str]:
    lines = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in lines if line[0] in "+-"]


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_a_text_that_is_not_changed_is_the_same_byte_for_byte(file: Path) -> None:
    text = file.read_bytes().decode()
    assert changed(text, []) == text
    assert changed(text.replace("\n", "\r\n"), []) == text.replace("\n", "\r\n")


@pytest.mark.parametrize("file", [file for file in SCENARIOS if KEY in file.read_text()], ids=lambda file: file.stem)
def test_only_the_line_that_is_meant_is_changed_and_undone_it_is_as_before(file: Path) -> None:
    text, before = file.read_bytes().decode(), read_scenario(file).safety_distance
    changed_text = changed(text, [Put(path=(KEY,), value=before + 1)])
    assert len(difference(text, changed_text)) == 2
    assert changed(changed_text, [Put(path=(KEY,), value=before)]) == text


def test_a_whole_number_in_place_of_a_float_stays_a_float() -> None:
    assert changed("up = 10.0 # m\n", [Put(path=("up",), value=12)]) == "up = 12.0 # m\n"


def test_a_truth_value_in_place_of_a_float_stays_one() -> None:
    assert changed("up = 10.0 # m\n", [Put(path=("up",), value=True)]) == "up = true # m\n"


@pytest.mark.parametrize(
    "change",
    [
        Take(path=("via", 3)),
        Put(path=("obstacles", 9, "height"), value=1.0),
        Put(path=("safety_distance", "below"), value=1.0),
        Put(path=("safety_distance", "far", "below"), value=1.0),
    ],
)
def test_missing_things_cannot_be_changed(change: Change) -> None:
    with refuses("bad-input"):
        changed(MEADOW.read_text(), [change])


def test_moved_places_move_as_far_as_the_pointer() -> None:
    text, step = MEADOW.read_text(), np.array([7.57, 11.12])
    paths: list[Path_] = [("goal",), ("obstacles", 0), ("obstacles", 1)]
    shifts = [Shift(path=path, taken=(8.5, 47.3), put_down=(8.5001, 47.3001)) for path in paths]
    before, after = parse_scenario(text, MEADOW), parse_scenario(changed(text, shifts), MEADOW)
    moved = [after.goal_point[:2] - before.goal_point[:2]]
    for body, same in zip(before.airspace.obstacles, after.airspace.obstacles, strict=True):
        moved.append((same.bounds - body.bounds)[0, :2])
    for move in moved:
        assert move == pytest.approx(step, abs=0.02)


@pytest.mark.parametrize("name", ["campus", "downtown", "mountains", "sitl"])
def test_home_alone_moves_and_the_rest_stays_where_it_is_on_the_map(name: str) -> None:
    file = MISSIONS / f"{name}.toml"
    text, before = file.read_text(), read_scenario(file)
    home = before.home
    taken = (home.longitude_deg, home.latitude_deg)
    there = (home.longitude_deg + 1e-4, home.latitude_deg + 1e-4)
    after = parse_scenario(changed(text, [Shift(path=("home",), taken=taken, put_down=there)]), file)
    assert (after.home.longitude_deg, after.home.latitude_deg) == pytest.approx(there, abs=1e-7)
    for body, same in zip(before.airspace.obstacles, after.airspace.obstacles, strict=True):
        corners = [np.array([(*corner, 0.0) for corner in obstacle.bounds[:, :2]]) for obstacle in (body, same)]
        places = [scenario.frame.to_geodetic(c) for scenario, c in zip((before, after), corners, strict=True)]
        assert np.abs(np.subtract(places[0][:2], places[1][:2])).max() < 3e-7
    ends = [scenario.frame.geodetic(scenario.goal_point) for scenario in (before, after)]
    assert (ends[0].latitude_deg, ends[0].longitude_deg) == pytest.approx(
        (ends[1].latitude_deg, ends[1].longitude_deg), abs=3e-7
    )


def test_drawn_shapes_are_a_scenario_again() -> None:
    ring = ((8.5002, 47.3001), (8.5003, 47.3001), (8.5003, 47.3002))
    changes: list[Change] = [
        Add(to="obstacles", table={"kind": "prism", "name": '"]\n[evil]', "height": 9.0}, ring=ring),
        Add(to="fence", table={"inclusion": False}, ring=ring),
        Add(to="via", table={"up": 12.0}, place=(8.5001, 47.3001)),
        Add(to="via", table={"up": 13.0}, place=(8.5002, 47.3003), at=0),
    ]
    scenario = parse_scenario(changed(MEADOW.read_text(), changes), MEADOW)
    assert [body.name for body in scenario.airspace.obstacles] == ["barn", "silo", '"]\n[evil]', "fence[0]"]
    assert scenario.via_points[:, 2].tolist() == [13.0, 12.0]
    taken = changed(changed(MEADOW.read_text(), changes), [Take(path=("via", 0)), Take(path=("via", 0))])
    assert "via" not in taken


@pytest.mark.parametrize("name", ["campus", "oldtown"])
def test_a_mission_becomes_places_of_a_scenario(name: str) -> None:
    mission = read_mission(MISSIONS / f"{name}.plan")
    with refuses("too-far", "home"):  # barn and silo would stay where they are
        changes_of(mission, MEADOW.read_text())
    bare = changed(MEADOW.read_text(), [Take(path=("obstacles",)), Take(path=("bounds",))])
    text = changed(bare, changes_of(mission, bare))
    scenario = parse_scenario(text, MEADOW)
    assert scenario.home.latitude_deg == pytest.approx(mission.home.latitude_deg, abs=1e-7)
    places = [item for item in mission.items if item.has_position]
    goal = scenario.frame.geodetic(scenario.goal_point)
    assert (goal.latitude_deg, goal.longitude_deg) == pytest.approx(
        (places[-1].latitude_deg, places[-1].longitude_deg), abs=1e-6
    )
    assert len(scenario.fence) == len(mission.fence)


@pytest.mark.parametrize("name", ["../../evil.geojson", "..\\evil.geojson", "/etc/evil.geojson"])
def test_a_dropped_file_lands_beside_the_scenario_and_over_nothing(tmp_path: Path, name: str) -> None:
    assert keep(name, b"one", tmp_path) == tmp_path / "evil.geojson"
    assert keep(name, b"one", tmp_path) == tmp_path / "evil.geojson"
    assert keep(name, b"two", tmp_path) == tmp_path / "evil-2.geojson"
    assert sorted(file.read_bytes() for file in tmp_path.iterdir()) == [b"one", b"two"]


@pytest.mark.parametrize(
    "name",
    ["\x00m.geojson", "m\x1b\x9b.geojson", "m" * 300 + ".geojson", "\u2603" * 99 + ".geojson", "\ud800m.geojson"],
)
def test_a_name_that_no_folder_takes_is_made_one(tmp_path: Path, name: str) -> None:
    file = keep(name, b"one", tmp_path)
    assert file.read_bytes() == b"one"
    assert file.name.isprintable()


@pytest.mark.parametrize("name", ["x.toml", "x.exe", ".geojson", "", "..", "x.html"])
def test_files_that_are_no_map_are_not_kept(tmp_path: Path, name: str) -> None:
    with refuses("wrong-suffix"):
        keep(name, b"", tmp_path)
    assert not list(tmp_path.iterdir())


def test_equal_text_of_another_program_makes_no_edit_stale(tmp_path: Path) -> None:
    file = tmp_path / "meadow.toml"
    file.write_text(MEADOW.read_text())
    document = Document(file)
    shown = document.revision + document.edit([Put(path=("safety_distance",), value=3.0)], "farther", 1)
    file.write_text(document.text)
    assert document.look_at_disk()
    assert (document.revision, document.as_answer().unsaved) == (shown, False)
    assert document.edit([Put(path=("obstacles", 0, "height"), value=30.0)], "higher", shown)
