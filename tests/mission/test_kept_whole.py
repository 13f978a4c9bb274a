import json
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission import BadInput
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.item_edits import text_with, with_inserted, with_item, with_plain_items, without_item
from ipoa_mission.mission.items import Item, Mission, MissionFile, land, takeoff, waypoint
from ipoa_mission.mission.landing_ground import landing_height, landing_on
from ipoa_mission.mission.mission_io import digest, read_mission, read_mission_file, write_mission
from tests.refused import refuses

MISSIONS = Path(__file__).parents[2] / "missions"
SURVEY = next(Path(__file__).parents[1].rglob("survey.plan"))


def opened(path: Path) -> MissionFile:
    return read_mission_file(path)


def moved(file: MissionFile, seq: int) -> str:
    item = file.mission.items[seq - 1]
    there = replace(item, latitude_deg=round(item.latitude_deg + 1e-4, 7))
    return text_with(with_item(file.mission, seq, there), file, Path("a"))


@pytest.mark.parametrize("name", ["campus.plan", "campus.waypoints", "sitl.plan", "oldtown.waypoints"])
def test_only_the_line_of_what_was_moved_differs(name: str) -> None:
    file = opened(MISSIONS / name)
    before, after = file.source.splitlines(), moved(file, 4).splitlines()
    assert len(before) == len(after)
    assert sum(old != new for old, new in zip(before, after, strict=True)) == 1


def test_unread_parts_stay(tmp_path: Path) -> None:
    document = json.loads((MISSIONS / "sitl.plan").read_text())
    document["mission"] |= {"cruiseSpeed": 15, "theirs": {"a": [1, None]}}
    document["geoFence"]["breachReturn"] = [47.0, 8.0, 20]
    document["mission"]["items"][2] |= {"theirs": 3, "AMSLAltAboveTerrain": 500.0}
    document["mission"]["items"][3]["theirs"] = 4
    path = tmp_path / "a.plan"
    path.write_text(json.dumps(document))
    again = json.loads(moved(opened(path), 4))
    for place in (document, again):
        place["mission"]["items"][3]["params"] = []
    assert again == document


def commented(folder: Path) -> MissionFile:
    lines = (MISSIONS / "sitl.waypoints").read_text().splitlines()
    lines[6:6] = ["", "# the mast"]
    lines[3:3] = ["  # the north field"]
    path = folder / "a.waypoints"
    path.write_bytes("\r\n".join([*lines, "# end", ""]).encode())
    return opened(path)


def test_comments_and_line_ends_of_an_edited_file_stay(tmp_path: Path) -> None:
    file = commented(tmp_path)
    before, after = file.source.split("\r\n"), moved(file, 4).split("\r\n")
    assert len(before) == len(after)
    (changed,) = (n for n, (old, new) in enumerate(zip(before, after, strict=True)) if old != new)
    assert before[changed].startswith("4\t")


def test_comments_move_with_their_items(tmp_path: Path) -> None:
    file = commented(tmp_path)
    removed = text_with(without_item(file.mission, 3), file, Path("a")).split("\r\n")
    inserted = text_with(with_inserted(file.mission, 2, file.mission.items[3]), file, Path("a")).split("\r\n")
    assert [line for line in removed if "#" in line] == ["  # the north field", "# the mast", "# end"]
    assert removed[removed.index("  # the north field") + 1].startswith("2\t")
    assert removed[removed.index("# the mast") + 1].startswith("4\t")
    assert inserted[inserted.index("  # the north field") + 1].startswith("3\t")
    assert inserted[inserted.index("# the mast") + 1].startswith("6\t")


def test_a_home_at_zero_is_written_where_its_mission_is(tmp_path: Path) -> None:
    lines = (MISSIONS / "sitl.waypoints").read_text().splitlines()
    lines[1] = "0\t1\t0\t16\t0\t0\t0\t0\t0\t0\t400\t1"
    path = tmp_path / "a.waypoints"
    path.write_text("\n".join(lines))
    after = moved(opened(path), 4).splitlines()
    assert after[1] != lines[1]
    assert sum(old != new for old, new in zip(lines, after, strict=True)) == 2


def test_a_jump_leads_where_it_led() -> None:
    mission = opened(MISSIONS / "sitl.plan").mission
    jump = Item(Command.DO_JUMP, 2, (4.0, 2.0, 0.0, 0.0))
    mission = with_inserted(mission, 6, jump)
    assert with_inserted(mission, 2, mission.items[2]).items[6].params[0] == 5.0
    assert without_item(mission, 2).items[4].params[0] == 3.0
    with refuses("bad-input", "item 4", "item 6"):
        without_item(mission, 4)


def test_an_item_of_a_survey_is_left_to_it_until_it_is_plain() -> None:
    file = opened(SURVEY)
    with refuses("complex-item", "", "item 5", "QGroundControl", kind=BadInput):
        moved(file, 5)
    with refuses("complex-item", "", "item 5", kind=BadInput):
        with_inserted(file.mission, 5, file.mission.items[0])
    before = with_inserted(file.mission, 2, file.mission.items[0])  # in front of it
    assert "ComplexItem" in text_with(before, file, Path("a.plan"))
    plain = with_plain_items(file.mission, 5)
    assert "ComplexItem" not in text_with(plain, file, Path("a.plan"))
    assert with_item(plain, 5, plain.items[4]).items == file.mission.items


def test_a_changed_landing_ground_or_survey_is_written_whole(tmp_path: Path) -> None:
    home = Geodetic(47.4, 8.5, 400.0)
    there = Geodetic(47.401, 8.5)
    mission = landing_on(Mission(home, (takeoff(home, 20.0), waypoint(there, 20.0), land(there))), 3.0)
    path = tmp_path / "a.plan"
    write_mission(mission, path)
    file = opened(path)
    for height in (3.0, 7.0):
        write_mission(landing_on(file.mission, height), path, file)
        assert landing_height(read_mission(path)) == height
        assert (path.read_text() == file.source) == (height == 3.0)
    survey = opened(SURVEY)
    write_mission(with_plain_items(survey.mission, 5), path, survey)
    assert "ComplexItem" not in path.read_text()


def test_a_record_of_whole_numbers_is_read_and_a_nameless_one_is_not(tmp_path: Path) -> None:
    home, there = Geodetic(47.4, 8.5, 400.0), Geodetic(47.401, 8.5)
    path = tmp_path / "a.waypoints"
    write_mission(Mission(home, (takeoff(home, 20.0), waypoint(there, 20.0), land(there))), path)
    record = {"sha256": {path.name: digest(path.read_text())}, "estimate": {"total_s": 77}, "landing_ground_m": 12}
    (tmp_path / ".json").write_text(json.dumps(record))
    assert read_mission_file(path).planned is None
    part = tmp_path / "-1.waypoints"
    part.write_text(path.read_text())
    (tmp_path / ".json").write_text(json.dumps(record | {"sha256": {part.name: digest(part.read_text())}}))
    assert read_mission_file(part).planned is None
    (tmp_path / "a.json").write_text(json.dumps(record))
    assert read_mission_file(path).planned == ("a.json", 77.0)
    assert landing_height(read_mission(path)) == 12.0
