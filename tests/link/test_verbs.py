import math
import re
from contextlib import AbstractContextManager, closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import MissionError, Unsafe
from ipoa_mission.flight import preflight, procedure
from ipoa_mission.flight.procedure import (
    ProcedureOptions,
    Stage,
    fly_mission,
    left_lists,
    load_mission,
    upload_mission,
    without_progress,
)
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import connect as connecting
from ipoa_mission.link import orders
from ipoa_mission.link import vehicle as verbs
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import connect, meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.conversations import KeepsChanging, MissionRefused
from ipoa_mission.link.dialogue import Dialogue, NoAnswer, Pause, SendOnce, Step, TimeUp
from ipoa_mission.link.messages import (
    AutopilotVersion,
    Message,
    MissionType,
    ParamRequestRead,
    ParamSet,
    ParamValue,
    Request,
    Result,
)
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.signing import MAX_SIGNERS, persistent_signer
from ipoa_mission.link.tlog import TlogWriter
from ipoa_mission.link.upload import Unflyable
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.progress import Progress
from ipoa_mission.scenario import parse_scenario
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.faults import Faults
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.suited import suited
from tests.link_pair import connection_of
from tests.refused import refuses

HOME = Geodetic(47.4, 8.5, 400.0)
RALLY = (Geodetic(47.4001, 8.5, 25.0),)
MISSION = Mission(HOME, (takeoff(HOME, 10.0), waypoint(Geodetic(47.4002, 8.5), 12.0), return_to_launch()), rally=RALLY)


def met(autopilot: Autopilot, **habits: Any) -> Vehicle:
    """The built-in autopilot at the other end of a loopback."""
    return meet(Connection(Loopback(Station(Mock(autopilot, HOME, **habits))), Codec(245, 190)))


@pytest.mark.parametrize("autopilot", registered())
def test_rally_points_are_uploaded_and_set_current_counts_as_the_mission(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    vehicle.state.expect_on_ground()
    vehicle.upload(suited(vehicle, MISSION))
    assert vehicle.download().rally == RALLY
    assert not any("rally points" in remark for remark in upload_mission(vehicle, suited(vehicle, MISSION)))
    plain = suited(vehicle, replace(MISSION, rally=()))
    with refuses("other-rally-points", "", "rally points"):
        load_mission(vehicle, Forecast(plain), ProcedureOptions())
    assert vehicle.download().rally == RALLY
    assert any("holds rally points of another mission" in remark for remark in upload_mission(vehicle, plain))
    vehicle.set_current(1)
    vehicle.home()  # meanwhile it reports its current item
    current = vehicle.state.current
    assert current is not None
    assert current.seq == (2 if autopilot is Autopilot.ARDUPILOT else 1)
    with pytest.raises((CommandRefused, NoAnswer)):
        vehicle.set_current(99)
    assert vehicle.record().path == ()


@pytest.mark.parametrize("autopilot", registered())
def test_upload_to_a_vehicle_in_flight_is_refused(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    flown = suited(vehicle, replace(MISSION, rally=()))
    vehicle.upload(flown)
    vehicle.prepare()
    vehicle.start()
    other = suited(vehicle, MISSION)
    with refuses("not-on-ground", "", "expected a vehicle disarmed"):
        upload_mission(vehicle, other)
    assert vehicle.download().rally == ()
    upload_mission(vehicle, other, anyway=True)
    assert vehicle.download().rally == RALLY


def unreadable(unread: Exception, monkeypatch: pytest.MonkeyPatch) -> tuple[Vehicle, Mission]:
    """Return a vehicle whose lists are not read, and a mission without rally points."""
    vehicle = met(Autopilot.PX4)

    def download(kind: MissionType) -> None:
        raise unread

    monkeypatch.setattr(vehicle, "download_items", download)
    return vehicle, suited(vehicle, replace(MISSION, rally=()))


@pytest.mark.parametrize(
    "unread",
    [
        NoAnswer("no answer"),
        TimeUp("the time is over"),
        KeepsChanging(MissionType.RALLY),
        *(MissionRefused(result, MissionType.RALLY) for result in Result if result is not Result.UNSUPPORTED),
    ],
)
def test_unread_rally_points_refuse_the_flight(unread: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    """ArduPilot denies its lists while another station uploads."""
    vehicle, plain = unreadable(unread, monkeypatch)
    vehicle.state.expect_on_ground()
    with refuses("other-rally-points", "", "unknown", str(unread)):
        load_mission(vehicle, Forecast(plain), ProcedureOptions())
    remarks = " ".join(upload_mission(vehicle, plain))
    assert all(f"unknown whether the vehicle holds {what} of" in remarks for what in ("rally points", "a fence"))


def test_lists_that_a_vehicle_does_not_support_are_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    unsupported = MissionRefused(Result.UNSUPPORTED, MissionType.RALLY)
    assert left_lists(*unreadable(unsupported, monkeypatch)) == {}


def test_broken_link_ends_the_reading_of_lists(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LinkDown, match="broke"):
        left_lists(*unreadable(LinkDown("the link broke"), monkeypatch))


@pytest.mark.parametrize("version", [None, Autopilot.PX4.newest])
def test_an_unchecked_mission_is_checked_in_its_world(missions: Path, version: Version | None) -> None:
    scenario = parse_scenario((missions / "sitl.toml").read_text(), missions / "x")
    safe = replace(read_mission(missions / "sitl.plan"), firmware_version=version)
    (latitude,), (longitude,), _ = scenario.frame.to_geodetic(np.array([[90.0, 60.0, 15.0]]))
    items = (safe.items[0], waypoint(Geodetic(float(latitude), float(longitude)), 15.0), return_to_launch())
    mission = replace(safe, items=items)
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, mission.home))), Codec(245, 190)))
    with refuses("unsafe", "", "mast"):
        fly_mission(vehicle, mission, scenario, set_params=True)
    assert vehicle.download().items == ()
    remarks = list[str]()
    options = ProcedureOptions(anyway=True, remark=remarks.append)
    load_mission(vehicle, Forecast(mission, scenario), options)
    assert any("mast" in words for words in remarks)


@pytest.mark.parametrize("higher", [-40.0, -14.0, 14.0, 40.0])
def test_home_at_another_height_is_refused_in_a_world(missions: Path, higher: float) -> None:
    scenario = parse_scenario((missions / "sitl.toml").read_text(), missions / "x")
    mission = read_mission(missions / "sitl.plan")
    there = replace(mission.home, altitude=mission.home.altitude + higher)
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, there))), Codec(245, 190)))
    remarks = list[str]()
    options = ProcedureOptions(remark=remarks.append, set_params=True)
    if abs(higher) > 15.0:
        with refuses("far-from-home", "", "488.0 m", f"{488.0 + higher:.1f} m"):
            load_mission(vehicle, Forecast(mission, scenario), options)
        assert vehicle.download().items == ()
        options = replace(options, anyway=True)
    load_mission(vehicle, Forecast(mission, scenario), options)
    assert any(f"{abs(higher):.1f} m {'higher' if higher > 0 else 'lower'}" in words for words in remarks)
    with refuses("far-from-home", "", " 0.0 m"):
        preflight.expect_level(replace(mission.home, altitude=0.0), there)


@pytest.mark.parametrize("change", ["", "safety_distance = 9.0", 'returns = "warn"'])
@pytest.mark.parametrize("is_named", [False, True])
def test_mission_is_checked_with_the_parameters_aboard(missions: Path, change: str, is_named: bool) -> None:
    text = (missions / "sitl.toml").read_text()
    key = change.split(" ")[0]
    text = re.sub(f"^{key} .*$", change, text, flags=re.M) if change else text
    scenario = parse_scenario(text, missions / "x")
    mission = read_mission(missions / "sitl.plan")
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, mission.home))), Codec(245, 190)))
    vehicle.set_parameter("RTL_RETURN_ALT", 12.0)
    remarks, entered = list[str](), list[Stage]()

    def stages(stage: Stage) -> AbstractContextManager[Progress]:
        entered.append(stage)
        return without_progress(stage)

    options = ProcedureOptions(stages=stages, remark=remarks.append)
    if not is_named:
        mission = replace(mission, parameters={})
    forecast = Forecast(mission, scenario)
    if key != "returns":
        with pytest.raises(Unsafe, match=r"^with the parameters and version aboard: item") as refused:
            load_mission(vehicle, forecast, options)
        hint = refused.value.hint or ""
        assert ("--set-params" in hint) == is_named
        assert f"plan with COM_LOW_BAT_ACT = 3{'' if is_named else ', RTL_RETURN_ALT = 12'} under" in hint
        assert vehicle.download().items == ()
        options = replace(options, anyway=True)
    entered.clear()
    loaded = load_mission(vehicle, forecast, options)
    assert loaded.mission.parameters["RTL_RETURN_ALT"] == 12.0
    new = [words for words in remarks if words.startswith("with the parameters and version aboard: ")]
    assert any("RTL" in words for words in new) == (key != "safety_distance")
    own = "" if is_named else ", RTL_RETURN_ALT 12 (not 30)"
    assert f"the mission assumes default parameters, and the vehicle has COM_LOW_BAT_ACT 3 (not 0){own}" in remarks
    assert entered == [Stage.POSITION, Stage.CHECK, Stage.UPLOAD, Stage.RECHECK]


def test_parameter_that_changes_during_the_upload_is_checked_too(
    missions: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = read_mission(missions / "sitl.plan")
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, mission.home))), Codec(245, 190)))
    upload = vehicle.upload

    def changed(*arguments: Any, **named: Any) -> None:
        upload(*arguments, **named)
        vehicle.set_parameter("RTL_RETURN_ALT", 13.0)

    monkeypatch.setattr(vehicle, "upload", changed)
    entered = list[Stage]()

    def stages(stage: Stage) -> AbstractContextManager[Progress]:
        entered.append(stage)
        return without_progress(stage)

    loaded = load_mission(vehicle, Forecast(mission), ProcedureOptions(stages=stages, set_params=True))
    assert loaded.mission.parameters["RTL_RETURN_ALT"] == 13.0
    assert entered[-3:] == [Stage.UPLOAD, Stage.RECHECK, Stage.RECHECK]  # Ctrl-C says that the mission is aboard


def test_vehicle_that_reports_no_parameters_gets_uploads_only(missions: Path) -> None:
    mission = replace(read_mission(missions / "sitl.plan"), parameters={})
    mock = Mock(Autopilot.PX4, mission.home)
    receive = mock.receive
    mock.receive = lambda message, *rest: None if isinstance(message, ParamRequestRead) else receive(message, *rest)  # type: ignore[method-assign]
    vehicle = meet(Connection(Loopback(Station(mock)), Codec(245, 190)))
    remarks = upload_mission(vehicle, mission)
    assert any("parameters were not compared" in words for words in remarks)
    assert len(vehicle.download().items) == len(mission.items)
    vehicle.clear()
    with pytest.raises(NoAnswer):
        load_mission(vehicle, Forecast(mission), ProcedureOptions())
    assert vehicle.download().items == ()


@pytest.mark.parametrize("check", ["expect_slow_landing", "expect_fit", "other_rally", "aboard"])
def test_parameters_are_written_after_all_checks(missions: Path, monkeypatch: pytest.MonkeyPatch, check: str) -> None:
    mission = read_mission(missions / "sitl.plan")
    vehicle = meet(Connection(Loopback(Station(Mock(Autopilot.PX4, mission.home))), Codec(245, 190)))
    vehicle.set_parameter("RTL_RETURN_ALT", 12.0)
    seen = list[float]()
    examined = preflight.expect_fit

    def refuse(*_: object) -> None:
        raise Unsafe("refused")

    def fit(*arguments: Any) -> tuple[str, ...]:
        seen.extend(arguments[-1].values())
        return examined(*arguments)

    monkeypatch.setattr(preflight, "expect_fit", fit)
    if check == "other_rally":
        vehicle.upload(suited(vehicle, replace(MISSION, home=mission.home)))
    elif check == "aboard":
        monkeypatch.setattr(procedure, "_refuse_aboard", refuse)
    else:
        monkeypatch.setattr(preflight, check, refuse)
    with pytest.raises(MissionError):
        load_mission(vehicle, Forecast(mission), ProcedureOptions(set_params=True))
    assert seen in ([], [70.0])
    assert vehicle.parameters(["RTL_RETURN_ALT"]) == {"RTL_RETURN_ALT": 12.0}
    monkeypatch.undo()
    vehicle.clear(MissionType.RALLY)
    load_mission(vehicle, Forecast(mission), ProcedureOptions(set_params=True))
    assert vehicle.parameters(["RTL_RETURN_ALT"]) == {"RTL_RETURN_ALT": 70.0}


@pytest.mark.parametrize("autopilot", registered())
def test_a_set_parameter_is_kept_and_an_unknown_one_is_an_error(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    name = "WPNAV_SPEED" if autopilot is Autopilot.ARDUPILOT else "MPC_XY_CRUISE"
    vehicle.set_parameter(name, 3.0)
    assert vehicle.parameters([name]) == {name: 3.0}
    assert vehicle.parameters([]) == {}
    with refuses("unknown-parameter", "", "NO_SUCH_NAME", kind=NoAnswer):
        vehicle.set_parameter("NO_SUCH_NAME", 1.0)


def test_a_value_that_its_type_has_not_is_bad_input() -> None:
    vehicle = met(Autopilot.PX4)
    with refuses("bad-input", "MPC_YAW_MODE", "32", "1e", "12"):
        vehicle.set_parameter("MPC_YAW_MODE", 1e12)


def test_a_vehicle_that_is_armed_is_not_on_the_ground_to_be_prepared() -> None:
    vehicle = met(Autopilot.PX4)
    vehicle.upload(suited(vehicle, replace(MISSION, rally=())))
    vehicle.prepare()
    vehicle.start()
    with pytest.raises(NotReady):
        vehicle.state.expect_on_ground()


def test_running_order_ends_after_its_time() -> None:
    slow = Faults(delay_s=0.2)
    connection = Connection(Loopback(Station(Mock(Autopilot.PX4, HOME)), slow), Codec(245, 190))
    vehicle = meet(connection)
    vehicle.give_up_after(0.3)
    with pytest.raises(TimeUp):
        vehicle.download()
    assert connection.now() < 3.0


def test_unflyable_verdict_without_a_position_does_not_fail_the_upload(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = met(Autopilot.PX4)

    def upload(why: str, home: Geodetic | None) -> None:
        def unflyable(*_: object) -> None:
            raise Unflyable(why)

        monkeypatch.setattr(vehicle, "upload_items", unflyable)
        monkeypatch.setattr(vehicle, "home", lambda: home)
        vehicle.upload(suited(vehicle, MISSION))

    for why, home, code in (("too far", None, "unflyable"), ("", HOME, "unflyable"), ("", None, "unplaced")):
        with refuses(code, "", why):
            upload(why, home)


def test_an_arducopter_that_never_ends_its_start_up_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = met(Autopilot.ARDUPILOT, conditions=Conditions(cold=True))
    monkeypatch.setattr(verbs, "STARTUP_S", 0.3)
    with refuses("not-started-up", kind=NoAnswer):
        vehicle.download()


def test_every_end_of_the_search_for_a_vehicle_closes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Open(Connection):
        is_closed = False

        def close(self) -> None:
            self.is_closed = True

    connection = Open(Loopback(Station(Mock(Autopilot.PX4, HOME))), Codec(245, 190))
    monkeypatch.setattr(connecting, "open_connection", lambda *_: connection)
    with refuses("not-heard", "udpin:127.0.0.1:0", "system id 9", kind=NoAnswer):
        connect("udpin:127.0.0.1:0", system=9)
    assert connection.is_closed
    monkeypatch.setattr(connection, "receive", lambda until: (_ for _ in ()).throw(LinkDown("gone")))
    connection.is_closed = False
    with refuses("link-down", "", "gone"):
        connect("udpin:127.0.0.1:0")
    assert connection.is_closed


def test_the_other_values_that_a_vehicle_tells_meanwhile_are_no_answer() -> None:
    dialogue = setting(5.0)
    assert dialogue.send(ParamValue("MPC_Z_P", 1.0, 9, 1, 0)) is None
    with pytest.raises(StopIteration):
        dialogue.send(ParamValue("MPC_XY_CRUISE", 3.0, 9, 1, 0))


def setting(value: float) -> Dialogue[None]:
    """Return the dialogue that sets a parameter to 3, where it waits for the result."""
    dialogue = orders.set_parameter("MPC_XY_CRUISE", 3.0, Autopilot.PX4)
    step = next(dialogue)
    while not (isinstance(step, SendOnce) and isinstance(step.message, ParamSet)):
        step = dialogue.send(ParamValue("MPC_XY_CRUISE", value, 9, 1, 0) if isinstance(step, Pause) else None)
    assert isinstance(dialogue.send(None), Pause)
    return dialogue


def hear_nothing(dialogue: Dialogue[None], steps: list[Step]) -> None:
    while True:
        steps.append(dialogue.send(None))


def test_a_late_answer_to_an_earlier_request_does_not_confirm_a_parameter() -> None:
    dialogue = setting(5.0)
    for _ in range(6):
        assert dialogue.send(ParamValue("MPC_XY_CRUISE", 5.0, 9, 1, 0)) is None
    with pytest.raises(StopIteration):
        dialogue.send(ParamValue("MPC_XY_CRUISE", 3.0, 9, 1, 0))


def test_a_vehicle_that_keeps_a_value_is_asked_again_before_that_is_said() -> None:
    dialogue, steps = setting(5.0), list[Step]()
    dialogue.send(ParamValue("MPC_XY_CRUISE", 5.0, 9, 1, 0))
    with refuses("parameter-kept", "MPC_XY_CRUISE", "3", "5"):
        hear_nothing(dialogue, steps)
    assert sum(isinstance(step, SendOnce) for step in steps) == 2  # besides the first


def test_a_vehicle_that_says_nothing_of_a_parameter_that_is_set_is_silent() -> None:
    dialogue = setting(5.0)
    with refuses("no-answer", "", "MPC_XY_CRUISE"):
        hear_nothing(dialogue, [])


def test_two_ends_that_wait_for_each_other_for_ever_are_an_error() -> None:
    class Silent:
        deadline = math.inf

        def receive(self, data: bytes, peer: object, now: float) -> None: ...

        def tick(self, now: float) -> None: ...

        def outgoing(self) -> list[tuple[bytes, object]]:
            return []

    with pytest.raises(RuntimeError, match="both ends wait, and neither"):
        Loopback(Silent()).receive(math.inf)


def test_every_process_with_a_link_id_can_sign_at_once(tmp_path: Path) -> None:
    signers = [persistent_signer(bytes(32), tmp_path / "stamp") for _ in range(MAX_SIGNERS)]
    assert len({signer.link_id for signer in signers}) == MAX_SIGNERS
    with refuses("too-large", "stamp", f"{MAX_SIGNERS}"):
        persistent_signer(bytes(32), tmp_path / "stamp")
    signers[3].close()
    signers[3].close()  # once more does nothing
    assert persistent_signer(bytes(32), tmp_path / "stamp").link_id == 3


def test_a_timestamp_that_cannot_be_locked_is_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("ipoa_mission.link.signing._lock", refuse)
    with refuses("unwritable", "stamp"):
        persistent_signer(bytes(32), tmp_path / "stamp")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_disk_that_is_full_ends_the_log_and_not_the_flight(caplog: pytest.LogCaptureFixture) -> None:
    with closing(TlogWriter("/dev/full")) as log:
        for _ in range(3):
            log.write(b"frame", 1.0)
    assert len(caplog.messages) == 1
    assert "/dev/full: cannot be written any more: No space left on device" in caplog.messages[0]


def test_a_disk_that_takes_half_a_record_is_full(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    class Half:
        def write(self, data: bytes) -> int:
            return len(data) // 2

        def close(self) -> None: ...

    with closing(TlogWriter(tmp_path / "x.tlog")) as log:
        log._file.close()
        log._file = Half()  # type: ignore[assignment]
        log.write(b"frame", 1.0)
    assert "No space left on device" in caplog.messages[0]


def test_an_arducopter_is_asked_once_whether_it_takes_a_file() -> None:
    vehicle = met(Autopilot.ARDUPILOT)
    heard: list[Message] = []
    vehicle.overhearing = heard.append
    for _ in range(2):
        vehicle.upload(suited(vehicle, MISSION))
        assert vehicle.download().rally == RALLY
    assert sum(isinstance(message, AutopilotVersion) for message in heard) == 1
    assert not any(isinstance(message, Request) and message.kind == MissionType.MISSION for message in heard)


@pytest.mark.parametrize("autopilot", registered())
def test_vehicle_with_another_sessions_mission_is_prepared(autopilot: Autopilot) -> None:
    before = met(autopilot)
    before.upload(suited(before, MISSION))
    vehicle = meet(connection_of(before))
    places: list[Geodetic] = []

    def forbid(place: Geodetic) -> None:
        places.append(place)
        raise NotReady("not from here")

    with refuses("not-ready", "", "not from here"):
        vehicle.prepare(permit=forbid)
    (place,) = places
    assert (place.latitude_deg, place.longitude_deg) == pytest.approx((HOME.latitude_deg, HOME.longitude_deg), abs=1e-4)
    vehicle.prepare()
    vehicle.start()
    assert vehicle.state.armed
