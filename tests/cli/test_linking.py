import json
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.version import Version
from ipoa_mission.cli import linking
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import upload
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Mission, change_speed, land, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission, write_mission
from tests.cli.conftest import ZURICH, Planned, Run, Serve

PASSPHRASE = "correct horse battery staple"


@pytest.fixture
def mission(planned: Planned) -> Path:
    return planned("sitl")[1] / "sitl.plan"


@pytest.mark.parametrize("family", registered())
def test_a_mission_goes_up_comes_down_and_goes_away(
    run: Run, autopilot: Serve, mission: Path, family: Autopilot
) -> None:
    with autopilot(family=family) as link:
        sent = json.loads(run(f"upload {mission} --autopilot {family} --link {link} --log up.tlog --json").out)
        assert sent["items"] == len(read_mission(mission).items)
        assert sent["autopilot"] == family.name
        assert run(f"download back.plan --link {link}").code == 0
        here, there = read_mission(mission), read_mission(Path("back.plan"))
        assert [item.command for item in there.items] == [item.command for item in here.items]
        for stored, sent_item in zip(there.items, here.items, strict=True):
            assert stored.altitude == pytest.approx(sent_item.altitude, abs=0.01)
        assert json.loads(run(f"clear --link {link} --json").out)["cleared"] == ["mission", "fence", "rally"]
        assert json.loads(run(f"download empty.plan --link {link} --json").out)["items"] == 0
    assert Path("up.tlog").stat().st_size > 100
    assert sorted(path.name for path in Path().glob("*.tlog")) == [
        "back-download.tlog",
        "empty-download.tlog",
        "up.tlog",
    ]  # no other is asked for


@pytest.mark.parametrize("verb", ["pause", "resume", "rtl"])
def test_a_vehicle_on_the_ground_is_not_told_to_fly(run: Run, autopilot: Serve, verb: str) -> None:
    with autopilot() as link:
        ended = run(f"{verb} --link {link} --json")
    error = json.loads(ended.out)["error"]
    assert (ended.code, error) == (1, "expected a vehicle in the air: the vehicle is disarmed, in AUTO.LOITER")


def test_upload_names_parameters_that_differ_between_mission_and_vehicle(
    run: Run, autopilot: Serve, mission: Path
) -> None:
    own = replace(read_mission(mission), parameters={"MPC_ACC_HOR": 1.5, "MPC_JERK_AUTO": 4.0, "MPC_XY_WARP": 9.0})
    write_mission(own, "slow.plan")
    with autopilot() as link:
        remarks = json.loads(run(f"upload slow.plan --link {link} --json").out)["remarks"]
    assert remarks == [
        'slow.params: not read: parameters that no model uses: line 5 ("MPC_XY_WARP")',
        "parameters from slow.params: MPC_ACC_HOR 1.5, MPC_JERK_AUTO 4, MPC_XY_WARP 9",
        "MPC_ACC_HOR is 3 on the vehicle, and the mission was made for 1.5",
        "the mission assumes default parameters, and the vehicle has COM_LOW_BAT_ACT 3 (not 0)",
        "the vehicle has no parameter MPC_XY_WARP",
    ]


def test_fly_prints_notes_before_it_arms(
    run: Run, autopilot: Serve, mission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = replace(read_mission(mission), parameters={"RTL_RETURN_ALT": 55.0})
    write_mission(own, "own.plan")

    def refuse(*_: object) -> None:
        raise NotReady("not armed in this test")

    monkeypatch.setattr(Vehicle, "start", refuse)
    with autopilot() as link:
        ended = run(f"fly own.plan --link {link} --out out")
    assert ended.code == 1
    before = ended.out.splitlines()
    assert "note: parameters from own.params: RTL_RETURN_ALT 55" in before
    assert [line for line in before if line.startswith("note: RTL_RETURN_ALT is ") and "made for 55" in line]


def test_a_mission_made_for_the_other_firmware_is_refused(run: Run, autopilot: Serve, mission: Path) -> None:
    with autopilot(family=Autopilot.ARDUPILOT) as link:
        ended = run(f"upload {mission} --link {link}")
        log = mission.with_name("sitl-upload.tlog")
        assert (ended.code, log.is_file()) == (1, True)
        assert "the mission was made for px4, and the vehicle is ardupilot" in ended.err
        assert f"written: {log}" in ended.err  # of what was said, although nothing came of it
        assert run(f"upload {mission} --link {link} --anyway").code == 0
        whoever = mission.with_suffix(".waypoints")  # it does not say whom it was made for
        assert run(f"upload {whoever} --link {link}").code == 0


def test_fly_checks_a_mission_by_the_version_aboard(run: Run, autopilot: Serve) -> None:
    places = [Geodetic(47.398 + 0.0002 * n, 8.5456, 488.0) for n in range(3)]
    ways = [waypoint(place, height) for place, height in zip(places, (10.0, 14.0, 10.0), strict=True)]
    items = (takeoff(ZURICH, 10.0), *ways, land(places[-1]))
    write_mission(Mission(ZURICH, items, Autopilot.PX4), "climb.plan")  # PX4 1.18 may pass its waypoints
    with autopilot(version=Version(1, 17)) as link:
        ended = run(f"fly climb.plan --link {link} --json")
        assert (ended.code, json.loads(ended.out)["completed"]) == (0, True)
        assert not [words for words in json.loads(ended.out)["remarks"] if "may pass at another height" in words]
    with autopilot() as link:
        ended = run(f"fly climb.plan --link {link} --json")
    refused = json.loads(ended.out)
    assert (ended.code, "[waypoint-passed]" in refused["error"], refused["codes"]) == (1, True, ["waypoint-passed"])
    assert run("fly climb.plan --link udpin:127.0.0.1:0 --firmware-version 1.18").err.startswith("error: items 2 to 4")


def test_error_of_the_version_aboard_outlasts_an_unknown_estimate(run: Run, autopilot: Serve) -> None:
    """Planned for PX4 1.17: by its forecast 1.18 does not reach item 4."""
    places = ((47.3980956, 8.5460799, 20.9), (47.3983209, 8.5466224, 26.0), (47.3984378, 8.546907, 25.9))
    ways = [waypoint(Geodetic(*place[:2], 488.0), place[2], 0.0, 7.0) for place in places]
    end = Geodetic(47.3985514, 8.5471835, 488.0)
    items = (takeoff(ZURICH, 15.0), change_speed(8.0), *ways, waypoint(end, 20.0), land(end))
    write_mission(Mission(ZURICH, items, Autopilot.PX4), "for17.plan")
    for version in ("", " --firmware-version 1.17"):
        with autopilot() as link:
            ended = run(f"fly for17.plan --link {link}{version} --json")
        assert (ended.code, json.loads(ended.out)["codes"]) == (1, ["waypoint-passed"])
        assert "items 3 to 6: PX4 1.18 may pass at another height" in ended.err


def test_mission_made_for_another_version_is_named(run: Run, autopilot: Serve, hop: Path) -> None:
    with autopilot(family=Autopilot.ARDUPILOT) as link:
        ended = run(f"fly {hop} --link {link} --autopilot ardupilot --firmware-version 4.7 --json")
    assert (
        "the mission was made for ArduPilot 4.7, and the vehicle has ArduPilot 4.8" in json.loads(ended.out)["remarks"]
    )


def test_repeated_note_is_printed_once(run: Run, autopilot: Serve, hop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare = Vehicle.prepare

    def prepare_twice(vehicle: Vehicle, *arguments: Any) -> None:
        prepare(vehicle, *arguments)
        prepare(vehicle, *arguments)

    monkeypatch.setattr(Vehicle, "prepare", prepare_twice)
    with autopilot(replace(ZURICH, longitude_deg=ZURICH.longitude_deg + 5e-5)) as link:
        ended = run(f"fly {hop} --link {link}")
    assert ended.code == 0, ended.err
    assert ended.out.count("m from the mission's home") == 1


def test_fly_over_a_link_keeps_the_log_of_an_earlier_flight(run: Run, autopilot: Serve, hop: Path) -> None:
    Path("out").mkdir()
    Path("out/hop.tlog").write_bytes(b"the flight of yesterday")
    with autopilot() as link:
        ended = run(f"fly {hop} --out out --link {link} --json")
    assert ended.code == 0, ended.err
    result = json.loads(ended.out)
    assert result["completed"]
    assert [item["seq"] for item in result["items"]][-1] == 3
    assert (result["armed"], result["in_air"], result["time_zero"]) == (False, False, "armed")
    assert result["written"] == ["out/hop-2.tlog"]
    assert Path("out/hop.tlog").read_bytes() == b"the flight of yesterday"


def test_link_without_a_vehicle_leaves_no_folder_and_no_log(run: Run, mission: Path) -> None:
    (log := mission.with_name("sitl-upload.tlog")).write_bytes(b"yesterday")
    fly = json.loads((ended := run(f"fly {mission} --out far/out --link tcp:127.0.0.1:9 --json")).out)
    assert (ended.code, "written" in fly, Path("far").exists()) == (1, False, False)
    assert "written" not in json.loads(run(f"upload {mission} --link tcp:127.0.0.1:9 --json").out)
    assert log.read_bytes() == b"yesterday"


def test_silence_leaves_no_log_behind(run: Run, mission: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ipoa_mission.link.connect.PRESENCE_S", 1.5)
    ended = run(f"upload {mission} --link udpin:127.0.0.1:0 --json")
    assert (ended.code, json.loads(ended.out).get("written")) == (1, None), ended.out
    assert not mission.with_name("sitl-upload.tlog").exists()


@pytest.mark.parametrize("verb", ["fly {m}", "upload {m} --link udpout:127.0.0.1:9", "clear --link udpout:127.0.0.1:9"])
def test_a_log_is_not_written_over_what_is_no_log(run: Run, mission: Path, verb: str) -> None:
    Path("notes.txt").write_text("mine")
    ended = run(f"{verb.format(m=mission)} --log notes.txt")
    assert (ended.code, Path("notes.txt").read_text()) == (2, "mine")
    assert "--log: expected a .tlog file, or a new file, not notes.txt" in ended.err


def test_a_vehicle_that_stands_somewhere_else_is_not_sent_a_mission(run: Run, autopilot: Serve, mission: Path) -> None:
    with autopilot(Geodetic(47.397742, 8.547594, 488.0)) as link:  # 151 m to the east, by PROJ's geodesic
        ended = run(f"upload {mission} --link {link}")
        assert ended.code == 1
        assert "the vehicle's home is 151 m from the mission's" in ended.err
        assert "it is at 47.39774, 8.54759, and the mission takes off at 47.39774, 8.54559" in ended.err
        assert "mock --home 47.397742 8.545594 488.0" in ended.err
        assert json.loads(run(f"download there.plan --link {link} --json").out)["items"] == 0
        anyway = json.loads(run(f"upload {mission} --link {link} --anyway --json").out)
        assert any("151 m from the mission's" in remark for remark in anyway["remarks"])


def test_a_vehicle_that_stands_higher_is_remarked_upon(run: Run, autopilot: Serve, mission: Path) -> None:
    with autopilot(Geodetic(47.397742, 8.545594, 500.0)) as link:
        ended = run(f"upload {mission} --link {link}")
    assert ended.code == 0
    assert "note: the vehicle's home is 12.0 m higher than the mission's (500.0 m AMSL, not 488.0 m)" in ended.out


def test_a_passphrase_signs_is_never_told_and_its_time_only_grows(
    run: Run, autopilot: Serve, mission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = Path("state/ipoa-mission/signing-station.timestamp")
    with autopilot(passphrase=PASSPHRASE) as link:
        assert run(f"scan --link {link.split()[0]} --seconds 0.3").code == 1  # who does not sign is not answered
        monkeypatch.setenv("IPOA_MISSION_PASSPHRASE", PASSPHRASE)
        marks = []
        for _ in range(2):
            ended = run(f"-vv upload {mission} --link {link} --log up.tlog")
            assert ended.code == 0, ended.err
            marks.append(int(mark.read_text()))
            for text in (ended.out, ended.err, mark.read_text(), Path("up.tlog").read_bytes().decode("latin-1")):
                assert PASSPHRASE not in text
    assert marks[1] > marks[0]


def test_a_key_in_a_file_goes_before_the_passphrase(
    run: Run, autopilot: Serve, mission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("key").write_text(PASSPHRASE)
    monkeypatch.setenv("IPOA_MISSION_KEY", "key")
    monkeypatch.setenv("IPOA_MISSION_PASSPHRASE", "another")
    with autopilot(passphrase=PASSPHRASE) as link:
        assert run(f"upload {mission} --link {link} --log up.tlog").code == 0


def test_ctrl_c_during_an_upload_says_what_the_vehicle_holds(
    run: Run, autopilot: Serve, mission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pressed: list[bool] = []

    def impatient(progress: object, done: int, total: int) -> None:
        if not pressed and done == 2:
            pressed.append(True)
            signal.raise_signal(signal.SIGINT)

    with autopilot() as link:
        monkeypatch.setattr(upload, "count", impatient)
        monkeypatch.setattr(signal, "getsignal", lambda number: signal.default_int_handler)
        ended = run(f"upload {mission} --link {link} --log up.tlog")
    assert ended.code == 130
    assert ended.out == ""
    assert ended.err.splitlines()[-2].startswith("error: cancelled: the vehicle keeps the mission it had")


def test_a_port_in_use_and_nobody_listening_are_told_with_a_hint(run: Run, autopilot: Serve, mission: Path) -> None:
    with autopilot() as link:
        port = link.split()[0].rpartition(":")[2]
        ended = run(f"scan --link udpin:127.0.0.1:{port}")
    assert ended.code == 1
    assert "cannot be opened: Address already in use" in ended.err
    assert "hint: is another ground station using it?" in ended.err
    nobody = run(f"upload {mission} --link tcp:127.0.0.1:1")
    assert nobody.code == 1
    assert "hint: nothing listens there" in nobody.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("clear --link 127.0.0.1:14550", "link: expected udpin:HOST:PORT"),
        (
            "download back.kml --link udpin:127.0.0.1:14550",
            'expected a name that ends in .plan or .waypoints, not in ".kml"',
        ),
        ("clear --link serial:/dev/there-is-none:57600", "there is no such device"),
    ],
)
def test_a_link_that_is_none_is_told(run: Run, words: str, expected: str) -> None:
    ended = run(words)
    assert ended.code in (1, 2)
    assert expected in ended.err


@pytest.mark.parametrize(
    ("items", "fence", "rally", "words"),
    [
        (1, 0, 0, "1 item is"),
        (2, 0, 0, "2 items are"),
        (1, 0, 1, "1 item and 1 rally point are"),
        (0, 2, 1, "0 items and 2 fence areas and 1 rally point are"),
    ],
)
def test_counted_lists_agree_in_number(items: int, fence: int, rally: int, words: str) -> None:
    assert linking._counted({"items": items, "fence": fence, "rally": rally}) == words
