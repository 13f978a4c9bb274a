"""Missions of an earlier writing: removed where they are ours, named where somebody edited them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Mission, takeoff, waypoint
from ipoa_mission.mission.mission_io import About, not_as_written, write_files

HOME = Geodetic(39.101, 121.82, 20.0)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), waypoint(HOME, 12.0)), parameters={"MPC_XY_CRUISE": 6.0})
ABOUT: About = {"parameters": {"MPC_XY_CRUISE": 6.0}}


def write_whole(folder: Path) -> None:
    write_files([("x", MISSION, ABOUT)], folder)


def write_parts(folder: Path, count: int, about: About | None = None) -> None:
    write_files([(f"x-{n}", MISSION, about) for n in range(1, count + 1)], folder, whole=("x", ABOUT))


def names(folder: Path, suffixes: Sequence[str] = (".plan", ".waypoints", ".params", ".json")) -> set[str]:
    return {path.name for path in folder.iterdir() if path.suffix in suffixes}


def test_a_split_mission_leaves_no_whole_one(tmp_path: Path) -> None:
    write_whole(tmp_path)
    assert names(tmp_path) == {"x.plan", "x.waypoints", "x.params", "x.json"}
    write_parts(tmp_path, 3)
    parts = {f"x-{n}{suffix}" for n in (1, 2, 3) for suffix in (".plan", ".waypoints", ".params")}
    assert names(tmp_path) == {*parts, "x.json"}


def test_fewer_parts_leave_none_of_the_earlier_ones(tmp_path: Path) -> None:
    for about in (None, ABOUT):
        write_parts(tmp_path, 3, about)
        write_parts(tmp_path, 2, about)
        assert names(tmp_path, (".plan", ".waypoints")) == {
            "x-1.plan", "x-1.waypoints", "x-2.plan", "x-2.waypoints",
        }  # fmt: skip
        assert not [name for name in names(tmp_path) if name.startswith("x-3")]
        write_whole(tmp_path)
        assert names(tmp_path, (".plan", ".waypoints", ".params")) == {"x.plan", "x.waypoints", "x.params"}


def test_fewer_parts_leave_no_page_of_the_earlier_ones(tmp_path: Path) -> None:
    ours, theirs = '<meta name="generator" content="ipoa-mission">', "<html>"
    for count, pages in ((4, {"x-1": ours, "x-2": ours, "x-3": ours, "x-4": theirs}), (2, {"x-1": ours}), (1, {})):
        parts = [(f"x-{n}", MISSION, None) for n in range(1, count + 1)]
        write_files(parts, tmp_path, {tmp_path / f"{name}.html": text for name, text in pages.items()}, ("x", ABOUT))
    assert names(tmp_path, (".html",)) == {"x-1.html", "x-4.html"}


def test_what_somebody_edited_or_wrote_stays_and_is_named(tmp_path: Path) -> None:
    write_parts(tmp_path, 3)
    assert not_as_written(tmp_path, "x") == []
    edited = tmp_path / "x-3.plan"
    edited.write_text(edited.read_text().replace("12", "13"))
    (tmp_path / "x-2.params").write_text("1\t1\tMPC_XY_CRUISE\t3.0\t9\n")
    (tmp_path / "x-4.plan").write_text("mine")
    (tmp_path / "x-1.tlog").write_text("a flight")
    assert not_as_written(tmp_path, "x") == [edited]
    write_whole(tmp_path)
    kept = {"x-3.plan", "x-2.params", "x-4.plan"}
    assert names(tmp_path) - kept == {"x.plan", "x.waypoints", "x.params", "x.json"}
    assert names(tmp_path) >= kept
    assert (tmp_path / "x-1.tlog").exists()


def test_missions_of_another_name_in_a_copied_record_stay(tmp_path: Path) -> None:
    write_whole(tmp_path)
    (tmp_path / "y.json").write_bytes((tmp_path / "x.json").read_bytes())
    write_files([("y", replace(MISSION, parameters={}), {})], tmp_path)
    assert (tmp_path / "x.plan").exists()
