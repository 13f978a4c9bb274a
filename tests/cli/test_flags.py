import errno
import json
import os
import signal
import stat
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from ipoa_mission import files
from ipoa_mission.cli.groups import read_departure_option
from ipoa_mission.files import MISSIONS as MISSION_SUFFIXES
from ipoa_mission.files import read_text, write_together
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import mission_text, not_as_written, read_mission, read_mission_file, write_mission
from ipoa_mission.report.exports import EXPORTS, forecast_text
from ipoa_mission.scenario import read_scenario
from tests.cli.conftest import Planned, Run
from tests.cli.test_surveying import SCENARIO
from tests.examples import some
from tests.refused import refuses
from tools.generate import verbs

MISSIONS = Path(__file__).parents[2] / "missions"
SITL, CAMPUS = MISSIONS / "sitl.plan", MISSIONS / "campus.plan"
#: Other meanings in `mock`, an autopilot; `reproduce`, `demo` (no `--out`); `learn`, one file; `deconflict`:
#: optional there. Where a link is optional. A vehicle is chosen on a link or in a log.
SEVERAL = {"--autopilot": 2, "--firmware-version": 2, "--link": 3, "--out": 5, "--seed": 2, "--system": 2}
#: Who takes one takes all.
TOGETHER = (
    {"--param", "--param-file"},
    {"--log", "--timeout", "--backend"},
    {"--optimizer", "--report"},
    {"--loss", "--duplicate", "--delay", "--reorder"},
)
LINKED = "fly mock upload download clear pause resume rtl"
#: Flag: verbs that must take it.
TAKEN = {
    "--json": "demo new plan studio check estimate show export fly mock compare learn "
    "deconflict scan upload download clear pause resume rtl reproduce",
    "--force": "deconflict demo learn new plan export fly download",
    "--scenario": "check estimate show export mock compare studio",
    "--param": "plan check estimate show fly mock compare",
    "--wind": "plan check estimate show fly compare deconflict",
    "--system": f"plan compare learn {LINKED}",
    "--key": LINKED,
    "--timeout": "fly upload download clear pause resume rtl",
}


def test_the_page_is_what_the_code_says() -> None:
    assert verbs.PAGE.read_text(encoding="utf-8") == verbs.page(), "run python -m tools.generate.verbs"


def test_a_flag_means_the_same_everywhere() -> None:
    rows = verbs.rows()
    assert {name: n for name, n in Counter(flag.name for flag in rows).items() if n > 1} == SEVERAL
    takers = {name: {verb for flag, of in rows.items() if flag.name == name for verb in of} for name in TAKEN}
    assert takers == {name: set(of.split()) for name, of in TAKEN.items()}
    for group in TOGETHER:
        assert len({tuple(sorted(of)) for flag, of in rows.items() if flag.name in group}) == 1, group


#: Parts are flown one by one, a survey by its scenario or files.
PLANNED_ONLY = {"SCENARIO", "[SCENARIO]", "--split"}
PLANNED_ONLY |= {"--survey", "--height", "--line-spacing", "--width", "--camera", "--gsd", "--flown"}


def test_fly_takes_what_plan_takes() -> None:
    taken = {name: {flag.name for flag in verbs.flags(verb)} for name, verb in verbs.by_name().items()}
    assert taken["plan"] - PLANNED_ONLY <= taken["fly"]


@pytest.mark.parametrize(
    "words", ["show {m} --scenario {s}", "estimate {m} --scenario {s}", "export {m} x.KML", "export {m} x.Plan"]
)
@pytest.mark.parametrize("columns", [None, "64"])
def test_tables_fit_eighty_columns_in_a_pipe_too_or_what_is_asked_for(
    run: Run, words: str, columns: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS") if columns is None else monkeypatch.setenv("COLUMNS", columns)
    for name in ("sitl", "campus"):
        Path("x.KML").unlink(missing_ok=True)
        Path("x.Plan").unlink(missing_ok=True)
        ended = run(words.format(m=MISSIONS / f"{name}.plan", s=MISSIONS / f"{name}.toml"))
        assert ended.code == 0, ended.err
        table = ended.out.split("\n\n")[1].splitlines() if "\n\n" in ended.out else []
        assert all(len(line) <= int(columns or 80) for line in table)


def test_parameters_and_wind_change_what_every_verb_tells(run: Run) -> None:
    totals = set()
    for words in ("", "--param MPC_XY_VEL_MAX=4", "--wind 6@230", f"--scenario {MISSIONS / 'sitl.toml'}"):
        shown = json.loads(run(f"show {SITL} --json {words}").out)["items"][-1]["done_s"]
        estimated = json.loads(run(f"estimate {SITL} --json {words}").out)["total_s"]
        assert shown == pytest.approx(estimated, abs=0.001)
        totals.add(round(estimated, 1))
    assert len(totals) == 3  # the scenario has neither wind nor parameters
    quiet, windy = (
        json.loads(run(f"check {SITL} --scenario {MISSIONS / 'sitl.toml'} --json {wind}").out)["clearance"]["kept_m"]
        for wind in ("", "--wind 5@9")
    )
    assert windy < quiet
    assert "--wind: needs --scenario" in run(f"check {SITL} --wind 5@9").err


def test_a_wind_from_beyond_the_compass_is_refused(run: Run) -> None:
    assert "[deg, to 360]" in run(f"show {SITL} --wind 5@720").err


@pytest.mark.parametrize(
    "time", ["noon", "25:00:00", "2026-11-01T14:05:30Z", "2999-01-01T00:00:00Z", "14:05", "0001-01-01"]
)
def test_a_departure_is_within_the_next_day(run: Run, time: str) -> None:
    ended = run(f"fly {SITL} --link tcp:127.0.0.1:1 --depart-at {time}")
    assert (ended.code, "within the next 24 hours, like 14:05:30" in ended.err) == (2, True)


@pytest.mark.parametrize(("zone", "hours"), [("", 0), ("+00:00", 0), ("+02:00", 2)])
def test_a_departure_is_local_or_has_its_zone(zone: str, hours: int) -> None:
    then = datetime.now(UTC) + timedelta(seconds=600)
    there = then.astimezone() if not zone else then + timedelta(hours=hours)
    read = read_departure_option(f"{there:%Y-%m-%dT%H:%M:%S}{zone}")
    assert read is not None
    assert abs((read - then).total_seconds()) <= 1.0


def test_a_departure_needs_a_link_and_a_single_flight(run: Run, tmp_path: Path) -> None:
    then = f"{datetime.now(UTC) + timedelta(seconds=600):%Y-%m-%dT%H:%M:%SZ}"
    assert "--depart-at: needs --link" in run(f"fly {SITL} --depart-at {then}").err
    (tmp_path / "field.toml").write_text(SCENARIO)
    survey = f"fly {tmp_path}/field.toml --out {tmp_path} --link tcp:127.0.0.1:1 --depart-at {then}"
    assert "--depart-at: expected a single flight" in run(survey).err


@pytest.mark.parametrize("suffix", [*EXPORTS, *MISSION_SUFFIXES])
def test_export_has_the_format_of_its_suffix(run: Run, suffix: str) -> None:
    scenario = MISSIONS / "campus.toml"
    file = read_mission_file(Path(CAMPUS))
    expected = (
        mission_text(file.mission, suffix, file)
        if suffix in MISSION_SUFFIXES
        else forecast_text(Forecast(file.mission, read_scenario(scenario)), suffix, "campus")
    )
    assert run(f"export {CAMPUS} campus{suffix.upper()} --scenario {scenario}").code == 0
    assert Path(f"campus{suffix.upper()}").read_text() == expected


def test_an_export_in_a_scenario_ends_on_its_ground(run: Run) -> None:
    world = read_scenario(MISSIONS / "campus.toml")
    for suffix in ("csv", "kml"):
        assert run(f"export {CAMPUS} campus.{suffix} --scenario {MISSIONS}/campus.toml").code == 0
    rows = [line.split(",") for line in Path("campus.csv").read_text().splitlines()]
    last = dict(zip(rows[0], rows[-1], strict=True))
    assert float(last["height_above_ground_m"]) == pytest.approx(0.0, abs=0.02)
    output = Path("campus.kml").read_text()
    end = output[output.index("<coordinates>") :].split("</coordinates>")[0].split()[-1]
    goal = world.airspace.ground(world.goal_point[None, :])[0]
    assert float(end.split(",")[2]) - world.home.altitude_amsl == pytest.approx(goal, abs=0.05)


def test_files_are_not_overwritten_without_force(run: Run) -> None:
    Path("x.kml").write_text("mine")
    Path("v.plan").write_text("mine")
    for words in (f"export {SITL} x.kml", "download v.plan --link udpin:127.0.0.1:0"):
        ended = run(words)
        assert ended.code == 2
    assert {path.read_text() for path in (Path("x.kml"), Path("v.plan"))} == {"mine"}
    assert run(f"export {SITL} x.kml --force").code == 0
    Path("same.plan").write_bytes(SITL.read_bytes())
    assert "the file exists" in run("export same.plan same.plan").err


def test_plan_writes_mission_and_page_together_or_neither(
    planned: Planned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = planned("sitl")[0]

    def fail(*_: object) -> str:
        raise OSError("no page")

    with monkeypatch.context() as broken:
        broken.setattr("ipoa_mission.report.page.report_html", fail)
        with pytest.raises(OSError, match="no page"):
            flight.write(tmp_path, report=True)
    assert not list(tmp_path.iterdir())
    *mission, page = flight.write(tmp_path, report=True)
    assert mission == list(flight.write(tmp_path))
    flight.report(tmp_path / "again.html")
    assert (page.name, page.read_text()) == ("sitl.html", (tmp_path / "again.html").read_text())


def test_a_plan_writes_over_a_plan_but_over_nobody_elses(run: Run, planned: Planned, tmp_path: Path) -> None:
    flight = planned("sitl")[0]
    flight.write(tmp_path)
    flight.report(tmp_path / "sitl.html")
    assert not_as_written(tmp_path, "sitl", report=True) == []
    assert not_as_written(MISSIONS, "sitl") == []
    (tmp_path / "sitl.plan").write_text((tmp_path / "sitl.plan").read_text().replace("15", "16", 1))
    (tmp_path / "sitl.html").write_text("mine")
    assert not_as_written(tmp_path, "sitl") == [tmp_path / "sitl.plan"]
    assert not_as_written(tmp_path, "sitl", report=True) == [tmp_path / "sitl.plan", tmp_path / "sitl.html"]
    for verb in ("plan", "fly"):
        ended = run(f"{verb} {MISSIONS / 'sitl.toml'} --out {tmp_path}")
        assert ended.code == 2
        assert ended.err == f"error: {tmp_path / 'sitl.plan'}: the file exists\nhint: --force overwrites it\n"
    (tmp_path / "sitl.json").write_text("{}")
    assert tmp_path / "sitl.json" in not_as_written(tmp_path, "sitl")


def test_a_plan_does_not_write_over_edited_parameters(run: Run, tmp_path: Path) -> None:
    for shipped in MISSIONS.glob("sitl.*"):
        (tmp_path / shipped.name).write_bytes(shipped.read_bytes())
    vehicle = tmp_path / "sitl.params"
    assert not_as_written(tmp_path, "sitl") == []
    for edited in (vehicle.read_text() + "1\t1\tMPC_XY_CRUISE\t3.0\t9\n", "# Parameters of the vehicle\n1 1 A\n"):
        vehicle.write_text(edited)
        ended = run(f"plan {MISSIONS / 'sitl.toml'} --out {tmp_path}")
        assert (ended.code, vehicle.read_text()) == (2, edited)
        assert ended.err == f"error: {vehicle}: the file exists\nhint: --force overwrites it\n"


def test_files_of_one_flight_are_written_together_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").write_text("before")
    (tmp_path / "c").mkdir()
    with refuses("unwritable", "c"):
        write_together({tmp_path / "a": "new", tmp_path / "b": "new", tmp_path / "c": "new"})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "c"]
    assert (tmp_path / "a").read_text() == "before"


def refuse_renames(monkeypatch: pytest.MonkeyPatch, *refused: str) -> None:
    rename = Path.replace

    def rename_others(path: Path, target: Path) -> Path:
        if {path.name, target.name} & {*refused}:
            raise PermissionError(errno.EACCES, "Permission denied")
        return rename(path, target)

    monkeypatch.setattr(Path, "replace", rename_others)


@pytest.mark.parametrize("refused", ["a.plan", "a.params"])
def test_a_refused_rename_or_removal_leaves_the_old_files(
    refused: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = read_mission(MISSIONS / "sitl.plan").with_parameters({"MPC_XY_CRUISE": 4.0})
    write_mission(mission, tmp_path / "a.plan")
    before = {path: path.read_text() for path in tmp_path.iterdir()}
    refuse_renames(monkeypatch, refused)
    with refuses("unwritable", refused):
        write_mission(replace(mission, parameters={}, cruise_speed=7.0), tmp_path / "a.plan")
    assert {path: path.read_text() for path in tmp_path.iterdir()} == before


def test_ctrl_c_during_a_removal_leaves_the_old_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("before")
    monkeypatch.setattr(files, "note_written", _interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_together({tmp_path / "a": None, tmp_path / "b": "new"})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "before"}


def _interrupt(path: Path) -> None:
    raise KeyboardInterrupt


def test_a_file_to_remove_may_be_missing(tmp_path: Path) -> None:
    write_together({tmp_path / "a": None, tmp_path / "b": "new"})
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_files_are_on_disk_before_the_first_is_renamed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = list[str]()
    sync, rename = os.fsync, Path.replace

    def noted_sync(file: int) -> None:
        done.append("sync")
        sync(file)

    def noted_rename(path: Path, target: Path) -> Path:
        done.append("rename")
        return rename(path, target)

    monkeypatch.setattr(os, "fsync", noted_sync)
    monkeypatch.setattr(Path, "replace", noted_rename)
    write_together({tmp_path / "a": "new", tmp_path / "b": "new"})
    assert done == ["sync", "sync", "rename", "rename"]


@pytest.mark.skipif(os.name == "nt", reason="no such modes")
@pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o644), (0o027, 0o640), (0o077, 0o600)])
def test_a_written_file_is_as_readable_as_the_user_s_other_files(tmp_path: Path, mask: int, mode: int) -> None:
    before = os.umask(mask)
    try:
        write_together({tmp_path / "a": "new"})
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == mode


def test_target_of_a_symbolic_link_is_written_and_the_link_stays(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "a").write_text("before")
    (tmp_path / "a").symlink_to(tmp_path / "elsewhere" / "a")
    write_together({tmp_path / "a": "new"})
    assert (tmp_path / "a").is_symlink()
    assert (tmp_path / "elsewhere" / "a").read_text() == "new"


@pytest.mark.skipif(not hasattr(os, "setgid") or os.getuid() != 0, reason="mounts a small disk")
def test_a_full_disk_leaves_nothing_half_written(planned: Planned, tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "tmpfs", disk], capture_output=True).returncode:
        pytest.skip("may not mount")
    try:
        with refuses("unwritable", "sitl.json"):
            planned("sitl")[0].write(disk)
        assert [*disk.iterdir()] == []
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_pipe_is_read_to_its_end(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_text("words\n" * 30_000))
    writer.start()
    assert read_text(pipe) == "words\n" * 30_000
    writer.join()


def test_the_time_that_a_user_gives_is_kept(run: Run) -> None:
    for verb in (f"upload {SITL}", "clear", f"fly {SITL}"):
        began = time.monotonic()
        ended = run(f"{verb} --link udpin:127.0.0.1:0 --timeout 1")
        assert ended.code == 1
        assert "no autopilot is heard" in ended.err
        assert time.monotonic() - began == pytest.approx(1.0, abs=0.9) or verb.startswith("fly")


def test_ctrl_c_at_any_time_has_words_for_machines(tmp_path: Path) -> None:
    for wait_s in (0.15, 1.0):
        command = [sys.executable, "-m", "ipoa_mission", "plan", str(MISSIONS / "downtown.toml"), "--json"]
        with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as verb:
            time.sleep(wait_s)
            verb.send_signal(signal.SIGINT)
            out, err = verb.communicate(timeout=300)
        if verb.returncode == 130:
            assert json.loads(out)["exit_code"] == 130
            assert err.startswith("error: stopped: nothing was")
        assert [*tmp_path.iterdir()] == []


#: Presses Ctrl-C at the import of module n, then runs the command line.
PRESSED = """
import signal, sys
class Presser:
    imported = 0
    def find_spec(self, *_):
        self.imported += 1
        if self.imported == {number}:
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Presser())
sys.argv[0] = "ipoa-mission"
from ipoa_mission.__main__ import main
main()
"""


@pytest.mark.parametrize("number", some(3, [2, 60, 250, 3, 4, 15, 150, 200]))
def test_ctrl_c_while_the_command_is_imported_is_one_line(number: int) -> None:
    """Of the first two modules, the package and `__main__`, nothing of ours runs yet."""
    command = [sys.executable, "-c", PRESSED.format(number=number + 1), "check", str(MISSIONS / "campus.plan")]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert (ended.returncode, ended.stdout) == (130, "")
    assert ended.stderr == "error: stopped: nothing was done\n"


def test_every_file_that_fly_writes_is_named(run: Run, hop: Path) -> None:
    assert "written: hop.tlog" in run(f"fly {hop}").out
    assert json.loads(run(f"fly {hop} --json").out)["written"] == ["hop.tlog"]
    assert "written: own.tlog" in run(f"fly {hop} --log own.tlog").out
    assert {path.name for path in Path().iterdir()} == {"hop.tlog", "own.tlog"}


def test_a_mission_that_is_flown_is_not_planned(run: Run) -> None:
    for option in ("--optimizer ipoa", "--report"):
        assert run(f"fly {SITL} {option}").err.startswith(f"error: {option.split()[0]}: expected a scenario")


def test_a_mission_without_parameters_takes_old_ones_away(tmp_path: Path) -> None:
    mission = read_mission(SITL)
    write_mission(mission.with_parameters({"MPC_XY_CRUISE": 3.0}), tmp_path / "x.plan")
    assert (tmp_path / "x.params").exists()
    write_mission(Mission(mission.home, mission.items), tmp_path / "x.plan")
    assert not (tmp_path / "x.params").exists()
