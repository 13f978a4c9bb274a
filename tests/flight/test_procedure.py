"""The checked upload of a mission, and the checks of vehicle and mission before a flight."""

import re
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.unsafe import begun_forecast
from ipoa_mission.errors import MissionError, Unsafe
from ipoa_mission.flight import preflight, procedure
from ipoa_mission.flight.procedure import (
    ProcedureOptions,
    Stage,
    begin_mission,
    fly_mission,
    left_lists,
    load_mission,
    upload_mission,
    without_progress,
)
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import LinkDown
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.conversations import KeepsChanging, MissionRefused
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.messages import MissionType, ParamRequestRead, Position, Result
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Mission, return_to_launch, waypoint
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.progress import Progress
from ipoa_mission.scenario import parse_scenario
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.suited import MISSION, RALLY, met, suited
from tests.refused import refuses


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


@pytest.mark.parametrize("autopilot", registered())
def test_a_departure_has_its_time(autopilot: Autopilot) -> None:
    vehicle = met(autopilot)
    flown = suited(vehicle, replace(MISSION, rally=()))
    begun_s: dict[Stage, float] = {}

    def stages(stage: Stage) -> AbstractContextManager[Progress]:
        begun_s.setdefault(stage, vehicle.connection.now())
        return without_progress(stage)

    loaded = load_mission(vehicle, Forecast(flown), ProcedureOptions())
    at = datetime.now(UTC) + timedelta(seconds=90.0)
    assert begin_mission(vehicle, loaded, ProcedureOptions(stages=stages, depart_at=at)).completed
    assert begun_s[Stage.FLIGHT] - begun_s[Stage.READY] == pytest.approx(90.0, abs=4.0)
    with refuses("departure-missed", "", kind=NotReady):
        begin_mission(vehicle, loaded, ProcedureOptions(depart_at=at - timedelta(seconds=100.0)))


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
        preflight.expect_same_height(replace(mission.home, altitude=0.0), there)


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


@pytest.mark.parametrize(("height", "east_m"), [(2.9, 0.0), (-9.6, 0.0), (9.6, 0.0), (9.6, 2.0)])
def test_vehicle_on_the_ground_off_the_height_of_its_home_is_refused(
    missions: Path, height: float, east_m: float
) -> None:
    """PX4 flew 9.6 m too high after DO_SET_HOME by another station."""
    here = read_mission(missions / "sitl.plan").home
    position = Position(1.0, here.latitude_deg, here.longitude_deg + east_m / 75e3, here.altitude, height)
    if abs(height) < 3.0 or east_m > 1.5:
        preflight.expect_home_here(position, here)
        preflight.expect_home_here(None, here)
    else:
        with refuses("not-at-start", "", f"not at {height:+.1f} m"):
            preflight.expect_home_here(position, here)


def test_flight_from_the_ground_off_its_home_begins_only_anyway(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = met(Autopilot.PX4)
    plain = suited(vehicle, replace(MISSION, rally=(), fence=()))
    options = ProcedureOptions()
    forecast = load_mission(vehicle, Forecast(plain), options)
    prepare = vehicle.prepare

    def prepared(first: int, show: Progress, permit: Any) -> None:
        prepare(first, show, lambda there: None)
        assert vehicle.state.position is not None
        vehicle.state.position = replace(vehicle.state.position, height=-9.6)
        permit(plain.home)

    monkeypatch.setattr(vehicle, "prepare", prepared)
    with refuses("not-at-start", "", "-9.6 m"):
        procedure.begin_mission(vehicle, forecast, options)
    assert procedure.begin_mission(vehicle, forecast, replace(options, anyway=True)).completed


@pytest.mark.parametrize("autopilot", registered())
def test_flight_from_elsewhere_is_compared_with_the_path_from_there(autopilot: Autopilot) -> None:
    """ArduCopter 4.8 was ordered to hold 5.7 m beside the path from the mission's home, which it did not fly."""
    there = replace(MISSION.home, longitude_deg=MISSION.home.longitude_deg + 8e-4)  # 60 m
    vehicle = meet(Connection(Loopback(Station(Mock(autopilot, there))), Codec(245, 190)))
    onward = waypoint(Geodetic(47.4006, 8.5), 12.0, hold_s=0.1)
    flown = suited(vehicle, replace(MISSION, items=(*MISSION.items[:2], onward, MISSION.items[2]), rally=()))
    remarks = list[str]()
    record = fly_mission(vehicle, flown, first=2, anyway=True, set_params=True, remark=remarks.append)
    assert record.completed, record.why_not
    assert not record.deviations
    seconds = begun_forecast(Forecast(flown), 2, there).estimate.total_s
    assert any(f"({seconds:.1f} s are estimated from there)" in words for words in remarks)
