import io
import json
import logging
import os
import pty
import re
import signal
import subprocess
import sys
import tomllib
from contextlib import redirect_stdout
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from rich.align import Align
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ipoa_mission import terminal
from ipoa_mission.autopilot.version import Version
from ipoa_mission.centimeters import floor_cm
from ipoa_mission.cli.app import listen_to_log
from ipoa_mission.cli.flight_output import print_flown
from ipoa_mission.cli.mission_source import FlownJob, Job
from ipoa_mission.errors import MissionError
from ipoa_mission.files import MISSIONS
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.paper import reproduce
from ipoa_mission.planning import planner
from ipoa_mission.report.exports import EXPORTS
from ipoa_mission.terminal import progress_bar
from tests.cli.conftest import Planned, Run, verbs

VERBS = sorted(verbs())


@pytest.fixture
def mission(missions: Path) -> Path:
    return missions / "sitl.plan"


@pytest.mark.parametrize("verb", ["", *VERBS])
def test_help_fits_eighty_columns_and_never_names_a_type_for_a_flag(
    run: Run, monkeypatch: pytest.MonkeyPatch, verb: str
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    ended = run(f"{verb} --help")
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert max(len(line) for line in lines) <= 80
    assert [line for line in lines if "<bool>" in line and "--help" not in line and "-completion" not in line] == []


@pytest.mark.parametrize("verb", [verb for verb in VERBS if verb != "schema"])
def test_every_verb_has_an_answer_for_machines(run: Run, verb: str) -> None:
    assert "--json" in run(f"{verb} --help").out


@pytest.mark.parametrize("line", ["plan campus --nope", "check", "nope", "plan campus --seed -1", "show a.plan b.plan"])
def test_a_usage_error_is_json_for_machines_and_words_for_people(run: Run, line: str) -> None:
    words = run(line)
    ended = run(f"{line} --json")
    result = json.loads(ended.out)
    assert ended.code == words.code == result["exit_code"] == 2
    assert (words.out, result["code"]) == ("", "usage")
    assert result["error"] in " ".join(words.err.split())
    assert ended.err == words.err


def test_a_mistake_is_json_for_machines_and_words_for_people(run: Run) -> None:
    ended = run("check nothing.plan --json")
    result = json.loads(ended.out)
    assert ended.code == result["exit_code"] == 2
    assert result["error"] == "nothing.plan: cannot be read: No such file or directory"
    assert ended.err.startswith(f"error: {result['error']}")


def test_new_and_export_tell_machines_what_they_wrote(run: Run, mission: Path) -> None:
    assert json.loads(run("new first.toml --json --home 47.3977 8.5456 488").out)["written"] == "first.toml"
    assert tomllib.loads(Path("first.toml").read_text())["home"]["latitude_deg"] == 47.3977
    assert json.loads(run(f"export {mission} out.kml --json").out) == {"written": "out.kml", "remarks": []}


def test_an_altitude_that_nobody_knows_is_remarked_upon(run: Run) -> None:
    words = f"new first.toml --buildings {Path(__file__).parents[2] / 'missions' / 'oldtown.geojson'}"
    assert "note: home.altitude_amsl is 0 m" in run(words).out
    assert "note" not in run(f"{words} --force --home 46.4403 9.84 488").out


def completing(words: str) -> dict[str, str]:
    return {"COMP_WORDS": words, "COMP_CWORD": str(words.count(" ")), "_IPOA_MISSION_COMPLETE": "complete_bash"}


@pytest.mark.parametrize(
    ("words", "completed"), [("ipoa-mission pl", "plan"), ("ipoa-mission plan a.plan --se", "--seed")]
)
def test_a_shell_completes_verbs_and_options(
    run: Run, monkeypatch: pytest.MonkeyPatch, words: str, completed: str
) -> None:
    for name, value in completing(words).items():
        monkeypatch.setenv(name, value)
    ended = run("")
    assert (ended.out.split(), ended.err) == ([completed], "")


def test_the_program_that_is_installed_completes_options(tmp_path: Path) -> None:
    command, asked = Path(sys.executable).with_name("ipoa-mission"), completing("ipoa-mission plan a.plan --se")
    done = subprocess.run(command, env=os.environ | asked, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout.split(), done.stderr) == (["--seed"], "")


def test_a_mock_says_where_it_is_and_ctrl_c_is_how_it_ends(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "ipoa_mission", "mock", "--link", "tcpin:127.0.0.1:0", "--json"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as mock:
        assert mock.stdout is not None
        assert json.loads(mock.stdout.readline())["autopilot"] == "px4"
        mock.send_signal(signal.SIGINT)
        assert mock.communicate(timeout=300) == ("", "")
        assert mock.returncode == 0


def test_the_version_is_that_of_the_package(run: Run) -> None:
    assert run("--version").out == f"ipoa-mission {version('ipoa-mission')}\n"


def test_v_logs_to_standard_error_and_leaves_the_result_alone(run: Run, hop: Path) -> None:
    quiet, loud = (run(f"{option} fly {hop} --json") for option in ("", "-v"))
    assert quiet.out == loud.out
    assert quiet.err == ""
    assert "info " in loud.err
    assert "ipoa_mission.cli" in loud.err
    assert logging.getLogger("ipoa_mission").handlers != logging.getLogger().handlers


def test_a_warning_of_the_package_is_heard_without_v(run: Run) -> None:
    Path("key").write_text("secret")
    Path("key").chmod(0o666)
    assert run("clear --link tcp:127.0.0.1:1 --key key").err.startswith("warning: key: others than its owner may write")


@pytest.mark.parametrize("no_color", [False, True])
def test_a_terminal_gets_color_unless_no_color_says_otherwise(tmp_path: Path, no_color: bool) -> None:
    theirs, ours = pty.openpty()
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"} | {"TERM": "xterm-256color"}
    if no_color:
        environment["NO_COLOR"] = "1"
    command = [sys.executable, "-m", "ipoa_mission", "show", "nothing.plan"]
    ended = subprocess.run(command, stdout=ours, stderr=ours, env=environment, cwd=tmp_path, timeout=300, check=False)
    os.close(ours)
    text = os.read(theirs, 10_000).decode()
    os.close(theirs)
    assert ended.returncode == 2
    assert "nothing.plan: cannot be read" in text
    assert ("\x1b[1;31m" in text) is not no_color


def stderr_as_terminal(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", shown := Terminal())
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "160")
    return shown


def test_a_bar_tells_the_time_gone_and_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = stderr_as_terminal(monkeypatch)
    with progress_bar("measuring") as show:
        for done in (1, 2, 3):
            show(done / 4, f"tiny: {done} of 4")
    text = re.sub(r"\x1b\[[0-9;?]*\w", "", terminal.getvalue())
    assert re.search(r"measuring .* tiny: 3 of 4 0:00:0\d · 0:00:0\d left", text)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a file that is full")
@pytest.mark.parametrize("verb", ["--version", "schema"])
def test_a_full_disk_is_told_in_words(verb: str) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "ipoa_mission", verb], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (ended.returncode, ended.stderr) == (1, "error: the output is incomplete: No space left on device\n")


def test_names_that_look_like_markup_are_told_as_they_are(run: Run, mission: Path) -> None:
    Path("[bold]").mkdir()
    assert "written: [bold]/x.csv" in run(f"export {mission} [bold]/x.csv").out
    assert "[red]x.plan: cannot be read" in run("show [red]x.plan").err


def test_show_and_estimate_fit_eighty_columns(run: Run, missions: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    mission = missions / "campus.plan"
    for words in (f"show {mission} --scenario {missions}/campus.toml", f"estimate {mission}"):
        lines = run(words).out.split("\n\n")[1].splitlines()
        assert len(lines) > len(read_mission(mission).items)
        assert max(len(line) for line in lines) <= 80
        assert not any(line.endswith(" ") for line in lines)


def test_ctrl_c_while_planning_leaves_nothing_behind(run: Run, missions: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(planner, "search", interrupted, raising=False)
    monkeypatch.setattr("ipoa_mission.routing.seek.plan_path", interrupted)
    ended = run(f"plan {missions}/sitl.toml --out out")
    assert (ended.code, ended.out) == (130, "")
    assert ended.err == "error: stopped: nothing was written\n"
    assert not Path("out").exists()


def test_ctrl_c_while_measuring_says_that_the_runs_are_kept(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(reproduce, "reproduce", interrupted)
    ended = run("reproduce table-3 --out kept")
    assert ended.code == 130
    assert "finished runs are in kept" in ended.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("plan {sitl} --seed -1", "Invalid value for '--seed'"),
        ("plan {sitl} --out {file}", "file: expected a folder, not file"),
        ("plan {sitl} --out {file}/deeper", "file/deeper: expected a folder, not"),
        ("plan {typo}", "typo.toml: "),
        ("plan {file}", "file: "),
        (
            "plan bogus",
            "bogus: expected a scenario file (.toml), or `campus`, but there is no such file hint: ipoa-mission",
        ),
        ("plan Typo", "hint: did you mean typo.toml?"),
        ("fly typos.toml", "hint: did you mean typo.toml?"),
        ("estimate {mission} --scenario typo.tml", "hint: did you mean typo.toml?"),
        ("check typo.tom", "No such file or directory hint: did you mean typo.toml?"),
        ("fly {mission} --report", "--report: expected a scenario"),
        ("fly {mission} --param-file nothing.parm", "nothing.parm: cannot be read"),
        ("export {mission} there/is/none.kml", "there/is/none.kml: cannot be written: No such file or directory"),
        (
            "export {mission} picture.png",
            f'expected a name that ends in {", ".join((*EXPORTS, *MISSIONS))}, not in ".png"',
        ),
        ("estimate {sitl}", "expected a mission (.plan, .waypoints), not a scenario"),
        ("compare {mission} {sitl}", "sitl.toml"),
        ("new there/is/none.toml --home 1 2 0", "expected a folder to write it to"),
        ("new first.toml", "expected --home LAT LON ALT, or --buildings FILE"),
        ("new first.json", "expected a name that ends in .toml"),
        ("plan {mission}", "expected a scenario (.toml), not a mission"),
        ("show {sitl}", "hint: first: ipoa-mission plan"),
        ("show 'my flight.toml'", "ipoa-mission plan 'my flight.toml'"),
        ("check ''", "no .plan or .waypoints file in this folder"),
        ("studio ''", "cannot be read: Is a directory"),
        ("plan {sitl} --optimizer quick", "optimizer.name: expected ipoa, poa"),
        ("mock --home 95 8 400", "--home: expected latitude and longitude in degrees"),
        ("mock --link mavlink:1", "link: expected udpin:HOST:PORT"),
        ("mock --param MPC_XY_CRUISE=1e300", "--param MPC_XY_CRUISE=1e300: expected NAME=VALUE"),
        ("reproduce table-33", "table-33"),
        ("upload {mission} --link udpin:127.0.0.1:0 --key {folder}", "cannot be read: Is a directory"),
    ],
)
def test_a_usual_mistake_ends_with_2_and_says_what_was_expected(
    run: Run, mission: Path, missions: Path, words: str, expected: str
) -> None:
    Path("file").write_text("nothing")
    Path("typo.toml").write_text((missions / "sitl.toml").read_text().replace("[goal]", "[goal"))
    names = {"sitl": missions / "sitl.toml", "mission": mission}
    ended = run(words.format(**names, file="file", typo="typo.toml", folder="."))
    assert ended.code == 2, ended.err
    assert expected in " ".join(ended.err.split())
    assert "Traceback" not in ended.err
    assert ended.out == ""


@pytest.mark.parametrize(
    ("module", "words", "extra"),
    [
        ("rasterio", "plan {missions}/oldtown.toml", "maps"),
        ("pyulog", "compare {mission} flight.ulg", "logs"),
        ("mavsdk", "upload {mission} --link udpin:127.0.0.1:0 --backend mavsdk", "mavsdk"),
        ("serial", "clear --link serial:/dev/ttyUSB0:57600", "serial"),
        ("minionpy", "reproduce table-3 --runs 1 --jobs 1", "paper"),
    ],
)
def test_an_extra_that_is_not_installed_is_named(
    run: Run, missions: Path, mission: Path, monkeypatch: pytest.MonkeyPatch, module: str, words: str, extra: str
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    Path("flight.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8))
    ended = run(words.format(missions=missions, mission=mission))
    assert ended.code in (1, 2)
    assert f"ipoa-mission[{extra}]" in ended.err
    assert "Traceback" not in ended.err


#: Escape sequences, a bell, CSI as one character, reversed text, a forged line.
WICKED = "mast\x1b]0;owned\x07\x1b[2J\x9b31m\u202etxt\r\nerror: none"
SHOWN = r"mast\x1b]0;owned\x07\x1b[2J\x9b31m\u202etxt\r\nerror: none"
OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]")


def test_control_characters_are_shown_in_results_tables_errors_and_logs(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.print_lines(WICKED, "\ta tab")
    terminal.print_table(WICKED, ["words", "n"], [(WICKED, "1")])
    terminal.print_error(MissionError(f"the vehicle says {WICKED}", hint=WICKED))
    for level in (logging.WARNING, logging.DEBUG):
        listen_to_log(level)
        logging.getLogger("ipoa_mission.link").warning("%s", WICKED)
    captured = capsys.readouterr()
    assert not OBEYED.search(captured.out + captured.err)
    assert captured.out.count(SHOWN) == 3
    assert "\ta tab" in captured.out
    assert captured.err.count(SHOWN.split(r"\n")[0]) == 4


def test_control_characters_in_json_are_escaped_and_read_back_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.print_json({"name": WICKED, "town": "Zürich"})
    captured = capsys.readouterr().out
    assert not OBEYED.search(captured)
    assert "Zürich" in captured
    assert json.loads(captured) == {"name": WICKED, "town": "Zürich"}


def test_a_bar_shows_what_a_terminal_would_obey(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = stderr_as_terminal(monkeypatch)
    with terminal.progress_bar("flying") as show:
        show(0.5, "\x1b]0;owned\x07[red]")
    assert r"\x1b]0;owned\x07[red]" in screen.getvalue()
    assert "\x07" not in screen.getvalue()


def test_names_in_files_do_not_reach_the_terminal_as_commands(run: Run, missions: Path) -> None:
    scenario = (missions / "sitl.toml").read_text()
    Path("keys.toml").write_text('"\\u001b[2J" = 1\n' + scenario)
    ended = run("plan keys.toml")
    assert ended.code == 2
    assert r"\x1b[2J" in ended.err
    assert "\x1b" not in ended.err


def test_output_without_a_terminal_names_a_wait_once(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("waiting until it is ready", is_waiting=True) as show:
        for words in ("", "PreArm: GPS 1: Bad fix\x1b[2J", "PreArm: Battery 1 low"):
            show(0.0, words)
    with progress_bar("upload") as show:
        show(0.5, "1 of 2")
    captured = capsys.readouterr()
    assert captured.err == "waiting until it is ready: PreArm: GPS 1: Bad fix\\x1b[2J\n"
    assert captured.out == ""


@pytest.mark.parametrize("columns", [20, 60, 80, 120])
def test_no_figure_of_a_table_is_cut_however_narrow_the_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    row = ("12", "NAV_RETURN_TO_LAUNCH", "1234.5", "321", "+123.4", "6543.2", "leg of the first of three passes")
    terminal.print_table("", ["item", "command", "leg\nm", "hdg\n°", "climb\nm", "done\ns", ""], [row])
    words = capsys.readouterr().out.split()
    assert set(row) - {row[1], row[-1]} <= set(words)
    assert row[1] in words or columns < 80  # a name is folded where it must be
    assert set(row[-1].split()) <= set(words)


@given(
    st.integers(1, 6).flatmap(
        lambda n: st.tuples(
            st.lists(st.sampled_from(["item", "leg\nm", "hdg\n°", "above\nground", ""]), min_size=n, max_size=n),
            st.lists(st.lists(st.from_regex(r"[a-z]{0,9}( [a-z]{1,9}){0,3}|-?[0-9]{1,4}\.[0-9]", fullmatch=True),
                              min_size=n, max_size=n), min_size=1, max_size=4),
        )
    )
)  # fmt: skip
def test_a_table_is_that_of_rich(table: tuple[list[str], list[list[str]]]) -> None:
    heads, rows = table
    assume(all(map(any, zip(*rows, strict=True))))  # empty columns are left out
    assume(all(map(any, rows)))  # no table has an empty row
    drawn = rich_table(heads, rows)
    assume(max(map(len, drawn)) < 80)  # folded in other places
    with redirect_stdout(io.StringIO()) as printed:
        terminal.print_table("title", heads, [tuple(row) for row in rows])
    assert printed.getvalue().rstrip("\n").split("\n")[2:] == drawn


def rich_table(heads: list[str], rows: list[list[str]]) -> list[str]:
    numbers = {i for i in range(len(heads)) if all(row[i][-1:].isdigit() or not row[i] for row in rows)}
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    for i, head in enumerate(heads):
        side: Literal["left", "right"] = "right" if i in numbers else "left"
        table.add_column(Align(head, side, vertical="bottom"), justify=side, no_wrap=True)
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False, width=200)
    with console.capture() as drawn:
        console.print(table)
    return [line.rstrip() for line in drawn.get().rstrip("\n").split("\n")]


def test_flown_line_has_the_clearance_on_the_version_aboard(
    planned: Planned, capsys: pytest.CaptureFixture[str]
) -> None:
    flight = planned("sitl")[0]
    assert flight.guarantee.clearance is not None
    aboard = flight.forecast.on(Version.parsed("1.17"))
    print_flown(FlownJob(Job("sitl", aboard, (), flight), (), FlightRecord({}, 60.0, (), (), True)), [])
    kept = aboard.guarantee.clearance
    assert kept is not None
    assert f"99 % of flights keep {floor_cm(kept.guaranteed):.2f} m" in capsys.readouterr().out
    assert kept.guaranteed != flight.guarantee.clearance.guaranteed
