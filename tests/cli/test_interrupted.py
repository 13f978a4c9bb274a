"""Ctrl-C at each stage of a verb: exit code 130, and a message that is true of the vehicle and the files."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.cli import flight_output, interrupting, linking
from ipoa_mission.cli.interrupting import ChangeKind, ChangesMade, Interrupted, interruptible
from ipoa_mission.flight import preflight, procedure
from ipoa_mission.flight.flight import Flight
from ipoa_mission.flight.procedure import Stage
from ipoa_mission.link import departure
from ipoa_mission.link import upload as link_upload
from ipoa_mission.link.dialogue import Cancelled, wait
from ipoa_mission.link.mavftp import FileRefused
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission, write_mission
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.mock_vehicle import MockVehicle
from ipoa_mission.terminal import confirm
from tests.cli.conftest import ZURICH, Run, Serve

WRITTEN = "stopped: parameters were written: MPC_XY_CRUISE, RTL_RETURN_ALT"
STORED = f"{WRITTEN}; the new mission is on the vehicle"
EITHER = "the mission on the vehicle may be the old one, the new one or a mixture: upload again, or clear it"


class Pressed(NamedTuple):
    """Ctrl-C at the begin or end of a function: the message, and what the vehicle has."""

    owner: object
    function: str
    message: str
    parameters: tuple[float, float]
    items: int
    armed: bool


STAGES = {
    Stage.POSITION: Pressed(preflight, "await_home", "stopped: the mission was not sent", (5.0, 30.0), 0, False),
    Stage.PARAMETERS: Pressed(
        Vehicle,
        "set_parameter after",
        "stopped: some parameters may be written: MPC_XY_CRUISE, RTL_RETURN_ALT; the mission was not sent",
        (6.0, 30.0),
        0,
        False,
    ),
    Stage.CHECK: Pressed(preflight, "expect_fit", "stopped: the mission was not sent", (5.0, 30.0), 0, False),
    Stage.UPLOAD: Pressed(Vehicle, "upload", f"{WRITTEN}; {EITHER}", (6.0, 41.0), 0, False),
    Stage.RECHECK: Pressed(preflight, "idle_fence", STORED, (6.0, 41.0), 3, False),
    Stage.READY: Pressed(Vehicle, "prepare", f"{STORED}; the vehicle was not armed", (6.0, 41.0), 3, False),
    Stage.START: Pressed(Vehicle, "start after", f"{STORED}; the start may have been completed", (6.0, 41.0), 3, True),
    Stage.FLIGHT: Pressed(
        Vehicle, "watch", f"{STORED}; the vehicle was started; the vehicle flies on, unwatched", (6.0, 41.0), 3, True
    ),
}

HINTS = {
    Stage.START: "look at the vehicle: it may be flying",
    Stage.FLIGHT: "to command it: `ipoa-mission pause --link {link}`, or `rtl`",
}


def press(patch: pytest.MonkeyPatch, owner: object, at: str, raised: type[BaseException] = KeyboardInterrupt) -> None:
    name, _, after = at.partition(" ")
    whole: Callable[..., object] = getattr(owner, name)

    def pressed(*arguments: object, **named: object) -> None:
        if after:
            whole(*arguments, **named)
        raise raised("cancelled")

    patch.setattr(owner, name, pressed)


@pytest.fixture
def aboard(monkeypatch: pytest.MonkeyPatch) -> list[BuiltInAutopilot]:
    """Return the autopilots that are served."""
    served: list[BuiltInAutopilot] = []

    build = BuiltInAutopilot.__init__

    def noted(own: BuiltInAutopilot, *arguments: Any, **named: Any) -> None:
        served.append(own)
        build(own, *arguments, **named)

    monkeypatch.setattr(BuiltInAutopilot, "__init__", noted)
    return served


@pytest.fixture
def mission(hop: Path) -> Path:
    write_mission(replace(read_mission(hop), parameters={"MPC_XY_CRUISE": 6.0, "RTL_RETURN_ALT": 41.0}), hop)
    return hop


def test_every_stage_is_in_the_table() -> None:
    assert STAGES.keys() == set(Stage)


@pytest.mark.parametrize("raised", [KeyboardInterrupt, Cancelled])
@pytest.mark.parametrize("stage", Stage)
def test_ctrl_c_in_a_stage_says_what_the_vehicle_holds(
    run: Run,
    autopilot: Serve,
    mission: Path,
    aboard: list[BuiltInAutopilot],
    monkeypatch: pytest.MonkeyPatch,
    stage: Stage,
    raised: type[BaseException],
) -> None:
    owner, at, words, parameters, items, armed = STAGES[stage]
    press(monkeypatch, owner, at, raised)
    with autopilot(speedup=20.0) as link:
        ended = run(f"fly {mission} --link {link} --set-params --json")
        (there,) = aboard
        assert there.flight.armed is armed
    result = json.loads(ended.out)
    assert (ended.code, result["exit_code"], result["error"]) == (130, 130, words)
    assert result["hint"] == (HINTS[stage].format(link=link) if stage in HINTS else None)
    assert result["written"] == ["hop.tlog"]
    assert result["completed"] is False
    assert (there.table.values["MPC_XY_CRUISE"], there.table.values["RTL_RETURN_ALT"]) == parameters
    assert len(there.transfers.listed(MissionType.MISSION)) == items
    assert f"error: {words}\n" in ended.err


@pytest.mark.parametrize("raised", [KeyboardInterrupt, Cancelled])
@pytest.mark.parametrize("restores", [True, False])
def test_ctrl_c_before_the_arming_leaves_the_mode_or_names_it(
    run: Run,
    autopilot: Serve,
    mission: Path,
    aboard: list[BuiltInAutopilot],
    monkeypatch: pytest.MonkeyPatch,
    restores: bool,
    raised: type[BaseException],
) -> None:
    press(monkeypatch, procedure, "check_start", raised)
    if not restores:
        monkeypatch.setattr(departure, "restore_mode", lambda state, mode: wait(0.0))
    with autopilot(speedup=20.0) as link:
        (there,) = aboard
        before = there.vehicle.mode
        ended = run(f"fly {mission} --link {link} --set-params")
        after = there.vehicle.mode
    words = f"{STORED}; the vehicle was not armed"
    if not restores:
        words += "; it is in AUTO.MISSION: it takes off when armed"
    assert (ended.code, ended.err.splitlines()[0]) == (130, f"error: {words}")
    modes = there.profile.autopilot.modes
    assert before != modes.mission
    assert after == (before if restores else modes.mission)


@pytest.mark.parametrize("sent", [["SIGTERM"], ["SIGHUP", "SIGHUP", "SIGTERM"]])
def test_a_termination_before_the_arming_restores_the_mode(
    autopilot: Serve, mission: Path, aboard: list[BuiltInAutopilot], monkeypatch: pytest.MonkeyPatch, sent: list[str]
) -> None:
    """`systemctl stop`, and a closed session, which sends several."""
    monkeypatch.setattr(MockVehicle, "_passed_checks", lambda own: False)
    with autopilot(speedup=5.0) as link:
        (there,) = aboard
        there.vehicle.profile = replace(there.vehicle.profile, reports_prearm=True)
        before = there.vehicle.mode
        command = [sys.executable, "-m", "ipoa_mission", *f"fly {mission} --link {link} --set-params".split()]
        with subprocess.Popen(command, cwd=mission.parent, stderr=subprocess.PIPE, text=True) as verb:
            assert verb.stderr is not None
            assert any(line.startswith(Stage.READY) for line in verb.stderr)
            in_wait = there.vehicle.mode
            for name in sent:
                verb.send_signal(getattr(signal, name))
                time.sleep(0.05)
            _, err = verb.communicate(timeout=60)
        after = there.vehicle.mode
    modes = there.profile.autopilot.modes
    assert (in_wait, after) == (modes.mission, before)
    assert (verb.returncode, err.splitlines()[0]) == (130, f"error: {STORED}; the vehicle was not armed")


@pytest.mark.parametrize(
    ("words", "owner", "at", "expected", "written"),
    [
        ("upload {mission} --link {link}", linking, "_report", "stopped: the new mission is on the vehicle", 1),
        ("upload {mission} --link {link}", procedure, "left_lists", "stopped: the mission was not sent", 1),
        ("upload {mission} --link {link}", linking, "connect_to", "stopped: nothing was done", 0),
        ("clear --link {link}", Vehicle, "clear", "stopped: some of the vehicle's lists may be deleted", 0),
        ("clear --link {link}", linking, "_report", "stopped: the vehicle's lists are deleted", 0),
        ("download back.plan --link {link}", Vehicle, "download", "stopped: back.plan was not written", 1),
        ("download back.plan --link {link}", linking, "_report", "stopped; files written: 2", 2),
        ("fly {mission} --link {link}", flight_output, "print_flown", "stopped: hop: the vehicle is disarmed", 1),
        ("fly {mission}", flight_output, "print_flown", "stopped: hop: the vehicle is disarmed", 1),
        ("demo", Flight, "report", "stopped: campus: the vehicle is disarmed", 5),
        ("plan campus --report", Flight, "_page", "stopped: nothing was done", 0),
    ],
)
def test_ctrl_c_says_what_a_verb_has_done(
    run: Run,
    autopilot: Serve,
    hop: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: str,
    owner: object,
    at: str,
    expected: str,
    written: int,
) -> None:
    press(monkeypatch, owner, at)
    with autopilot() as link:
        ended = run(words.format(mission=hop, link=link))
    lines = ended.err.splitlines()
    files = [line.removeprefix("written: ") for line in lines if line.startswith("written: ")]
    assert (ended.code, [line for line in lines if line.startswith("error: ")]) == (130, [f"error: {expected}"])
    assert len(files) == written
    assert all(Path(file).is_file() for file in files)


def test_ctrl_c_while_the_vehicle_s_other_lists_are_read_sends_nothing(
    run: Run, autopilot: Serve, hop: Path, aboard: list[BuiltInAutopilot], monkeypatch: pytest.MonkeyPatch
) -> None:
    press(monkeypatch, Vehicle, "download_items", Cancelled)
    with autopilot() as link:
        ended = run(f"upload {hop} --link {link}")
    assert (ended.code, ended.err.splitlines()[0]) == (130, "error: stopped: the mission was not sent")
    assert not aboard[0].transfers.listed(MissionType.MISSION)


@pytest.mark.parametrize(
    ("family", "words", "left"),
    [
        (Autopilot.PX4, "the vehicle keeps the mission it had", {30.0}),
        (Autopilot.ARDUPILOT, "the mission on the vehicle may be a mixture of new and old", {30.0, 40.0}),
    ],
)
def test_a_second_ctrl_c_in_an_upload_names_all_that_the_vehicle_may_hold(
    run: Run,
    autopilot: Serve,
    aboard: list[BuiltInAutopilot],
    monkeypatch: pytest.MonkeyPatch,
    family: Autopilot,
    words: str,
    left: set[float],
) -> None:
    for height in (30.0, 40.0):
        items = (takeoff(ZURICH, height), *[waypoint(ZURICH, height)] * 6, return_to_launch())
        write_mission(Mission(ZURICH, items, family), Path(f"{height}.plan"))

    @contextmanager
    def impatient(*_: object, **__: object) -> Iterator[Callable[[float, str], None]]:
        def press_twice(share: float, words: str) -> None:
            if share > 0.4:
                raise KeyboardInterrupt

        yield press_twice

    press(monkeypatch, link_upload, "upload_by_file", FileRefused)  # item by item also to ArduPilot
    with autopilot(family=family) as link:
        assert run(f"upload 30.0.plan --link {link}").code == 0
        monkeypatch.setattr(interrupting, "progress_bar", impatient)
        ended = run(f"upload 40.0.plan --link {link}")
        held = aboard[0].transfers.listed(MissionType.MISSION)
    assert (ended.code, ended.err.splitlines()[0]) == (130, f"error: cancelled: {words}")
    heights = {item.altitude for item in held if item.command == Command.NAV_WAYPOINT}
    assert heights - {ZURICH.altitude} == left


def test_ctrl_c_at_a_question_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    press(monkeypatch, typer, "confirm", typer.Abort)
    with pytest.raises(KeyboardInterrupt):
        confirm("hop.plan exists: overwrite it?")


def test_the_link_s_more_exact_words_follow_the_earlier_changes() -> None:
    changes = ChangesMade({(ChangeKind.PARAMETERS, ""): "parameters were written: MPC_XY_CRUISE"})
    with pytest.raises(Interrupted) as ended, changes.reporting("either mission"):
        raise Cancelled("cancelled: the vehicle keeps the mission it had", known={"list_on_vehicle": "old"})
    words = "stopped: parameters were written: MPC_XY_CRUISE; cancelled: the vehicle keeps the mission it had"
    assert str(ended.value) == words
    assert ended.value.known["list_on_vehicle"] == "old"


def test_ctrl_c_amid_imports_is_an_interruption(monkeypatch: pytest.MonkeyPatch) -> None:
    def verb(changes: ChangesMade) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(sys.modules, "ipoa_mission.link.dialogue", None)  # half imported
    with pytest.raises(Interrupted, match="stopped: nothing was done"):
        interruptible(verb)()
