import json
from dataclasses import replace
from pathlib import Path

import pytest

from ipoa_mission import (
    check_mission,
    estimate,
    fly_mission,
    plan_flight,
    plan_survey,
    read_mission,
    read_scenario,
    upload_mission,
)
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import Unsafe
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.simulator.fly import board
from tests.cli.conftest import Run
from tests.refused import refuses

MISSIONS = Path(__file__).resolve().parents[2] / "missions"
UNMEASURED = {Autopilot.PX4: Version(1, 16, 2), Autopilot.ARDUPILOT: Version(4, 6, 2)}
CODE = "version-not-measured"
FIELD = [[0.0, 40.0], [80.0, 40.0], [80.0, 90.0], [0.0, 90.0]]


def plain(autopilot: Autopilot) -> Mission:
    return replace(read_mission(MISSIONS / "sitl.plan"), autopilot=autopilot, parameters={}, fence=(), rally=())


def aboard(autopilot: Autopilot, version: Version | None) -> Vehicle:
    return board(replace(plain(autopilot), firmware_version=version or Version(0, 0, 0, "dev")))


def scenario(version: str, unmeasured: bool = False) -> Scenario:
    world = read_scenario(MISSIONS / "sitl.toml")
    vehicle = world.vehicle.model_copy(update={"firmware_version": version, "unmeasured_version": unmeasured})
    return world.model_copy(update={"vehicle": vehicle})


@pytest.mark.parametrize("autopilot", registered())
def test_check_has_an_error_and_where_it_is_asked_for_a_warning(autopilot: Autopilot) -> None:
    named = replace(plain(autopilot), firmware_version=UNMEASURED[autopilot])
    (finding,) = [finding for finding in check_mission(named) if finding.code == CODE]
    assert (str(finding.severity), finding.seq) == ("error", None)
    assert str(UNMEASURED[autopilot]) in finding.message
    assert "--unmeasured-version" in str(finding.hint)
    (finding,) = [finding for finding in check_mission(replace(named, unmeasured_version=True)) if finding.code == CODE]
    assert str(finding.severity) == "warning"
    assert not [finding for finding in check_mission(plain(autopilot)) if finding.code == CODE]


@pytest.mark.parametrize("autopilot", registered())
def test_a_vehicle_that_says_it_gets_no_mission_anyway_or_not(autopilot: Autopilot) -> None:
    mission = plain(autopilot)
    for send in (
        lambda vehicle, anyway: upload_mission(vehicle, mission, anyway=anyway),
        lambda vehicle, anyway: fly_mission(vehicle, mission, anyway=anyway),
    ):
        for anyway in (False, True):
            vehicle = aboard(autopilot, UNMEASURED[autopilot])
            with pytest.raises(Unsafe) as refused:
                send(vehicle, anyway)
            assert refused.value.known == {"codes": [CODE]}
            assert vehicle.download_items(0) == ()
    with pytest.raises(Unsafe) as refused:
        aboard(autopilot, UNMEASURED[autopilot]).upload(mission)
    assert refused.value.known == {"codes": [CODE]}


@pytest.mark.parametrize("autopilot", registered())
def test_a_vehicle_that_says_it_gets_it_where_it_is_asked_for(autopilot: Autopilot) -> None:
    asked = replace(plain(autopilot), unmeasured_version=True)
    remarks = upload_mission(aboard(autopilot, UNMEASURED[autopilot]), asked)
    assert any(str(UNMEASURED[autopilot]) in remark for remark in remarks)


@pytest.mark.parametrize("autopilot", registered())
def test_a_vehicle_without_a_version_is_refused_unless_the_user_names_one(autopilot: Autopilot) -> None:
    mission = plain(autopilot)
    with refuses("unsafe") as refused:
        upload_mission(aboard(autopilot, None), mission)
    assert refused.value.known == {"codes": [CODE]}
    upload_mission(aboard(autopilot, None), replace(mission, firmware_version=autopilot.newest))
    remarks = upload_mission(aboard(autopilot, None), replace(mission, unmeasured_version=True))
    assert any("does not report its version" in remark for remark in remarks)


@pytest.mark.parametrize("autopilot", registered())
def test_all_measured_versions_are_flown_without_a_word(autopilot: Autopilot) -> None:
    for version in autopilot.measured:
        assert not any("measured" in remark for remark in upload_mission(aboard(autopilot, version), plain(autopilot)))


def test_unmeasured_version_is_not_planned_for() -> None:
    for planned in (
        plan_flight,
        lambda world: plan_survey(FIELD, scenario=world, line_spacing=15.0, height_above_ground=70.0),
    ):
        with pytest.raises(Unsafe) as refused:
            planned(scenario("1.16"))
        assert refused.value.known == {"codes": [CODE]}
    flight = plan_flight(scenario("1.16", unmeasured=True))
    assert CODE in [finding.code for finding in flight.findings]
    assert flight.mission.unmeasured_version


def test_the_version_of_the_vehicle_goes_before_the_one_that_is_named() -> None:
    named = Forecast(replace(plain(Autopilot.ARDUPILOT), firmware_version=Version(4, 7)))
    on_it = named.on(Version(4, 8))
    assert on_it.mission_as_read.firmware_version == Version(4, 8)
    assert named.on(None) is named
    assert on_it.estimate.total_s < named.estimate.total_s
    assert estimate(plain(Autopilot.ARDUPILOT)).total_s == on_it.estimate.total_s


@pytest.mark.parametrize("verb", ["check", "estimate"])
def test_the_command_line_refuses_it_by_name(run: Run, verb: str) -> None:
    file = f"{MISSIONS / 'sitl.plan'} --firmware-version 1.16"
    refused = run(f"{verb} {file}")
    assert refused.code == 1
    assert CODE in refused.out + refused.err
    assert run(f"{verb} {file} --unmeasured-version").code == 0


def test_plan_and_fly_refuse_it_by_name(run: Run, tmp_path: Path) -> None:
    words = f"{MISSIONS / 'sitl.toml'} --firmware-version 1.16 --out {tmp_path} --json"
    for verb in ("plan", "fly"):
        refused = run(f"{verb} {words}")
        assert refused.code == 1
        assert json.loads(refused.out)["codes"] == [CODE]
        assert not list(tmp_path.iterdir())
    assert run(f"plan {words} --unmeasured-version").code == 0


def test_a_scenario_asks_for_it_by_a_key(tmp_path: Path, run: Run) -> None:
    text = (MISSIONS / "sitl.toml").read_text(encoding="utf-8")
    (world := tmp_path / "sitl.toml").write_text(
        text.replace("[vehicle]\n", '[vehicle]\nfirmware_version = "1.16"\n'), encoding="utf-8"
    )
    check = f"check {MISSIONS / 'sitl.plan'} --scenario {world}"
    assert run(check).code == 1
    world.write_text(world.read_text().replace('"1.16"\n', '"1.16"\nunmeasured_version = true\n'), encoding="utf-8")
    assert run(check).code == 0
