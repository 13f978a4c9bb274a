import math

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check_mission
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Finding
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.stored_mission import compare
from tests.finding_codes import codes_of
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME, THERE = Geodetic(47.397742, 8.545594, 488.0), Geodetic(47.3985, 8.5456)
HELD = waypoint(THERE, 20.0)
THIRD = Item(HELD.command, HELD.frame, (0.0, 0.0, 5.0, math.nan), HELD.latitude_deg, HELD.longitude_deg, 20.0)
BACK = Item(Command.NAV_RETURN_TO_LAUNCH, Frame.MISSION, (1.0, 0.0, 0.0, 0.0))


def mission(*items: Item, autopilot: Autopilot = PX4, version: str | None = None) -> Mission:
    known = None if version is None else Version.parsed(version)
    return Mission(HOME, (takeoff(HOME, 20.0), *items), autopilot, firmware_version=known)


def others(mission: Mission) -> tuple[Finding, ...]:
    """Leave out unmeasured versions, and waypoints that 1.18 may pass."""
    aside = ("version-not-measured", "waypoint-passed", "waypoint-may-be-passed")
    return tuple(finding for finding in check_mission(mission) if finding.code not in aside)


def test_tables_reach_from_the_oldest_to_the_newest() -> None:
    assert PX4.tables.series == ((1, 15), (1, 16), (1, 17), (1, 18))
    assert ARDUPILOT.tables.series == ((4, 5), (4, 6), (4, 7), (4, 8))
    assert all(len(a.firmware(Version(*s)).commit) == 40 for a in registered() for s in a.tables.series)
    assert all(version.series in a.tables.series for a in registered() for version in a.measured)


@pytest.mark.parametrize(
    ("autopilot", "version", "table"),
    [
        (PX4, "1.16.2", (1, 16)),
        (PX4, "1.14.0", (1, 15)),
        (PX4, "1.19.0-alpha1", (1, 18)),
        (ARDUPILOT, "4.9.0-dev", (4, 8)),
        (ARDUPILOT, "4.0", (4, 5)),
    ],
)
def test_a_version_has_the_table_of_its_series_or_the_nearest(
    autopilot: Autopilot, version: str, table: tuple[int, int]
) -> None:
    assert autopilot.firmware(Version.parsed(version)).version.series == table


def test_1_18_refuses_params_that_it_does_not_use() -> None:
    findings = others(mission(THIRD, BACK, version="1.18"))
    assert codes_of(findings) == ["error param-refused 2", "error param-refused 3"]
    assert ["param3" in finding.message and "not 5" in finding.message for finding in findings] == [True, False]
    assert others(mission(THIRD, BACK, version="1.17")) == ()


def test_1_18_takes_a_gate_no_more() -> None:
    gate = Item(Command.CONDITION_GATE, 3, (0.0,) * 4, THERE.latitude_deg, THERE.longitude_deg, 20.0)
    refused = others(mission(gate, HELD, return_to_launch(), version="1.18"))
    assert [(f.code, f.seq) for f in refused] == [("param-refused", 2), ("way-unknown", 2)]
    taken = others(mission(gate, HELD, return_to_launch(), version="1.17"))
    assert [finding.code for finding in taken] == ["way-unknown"]


def test_kept_and_never_flown_versions_are_errors() -> None:
    wait = Item(Command.CONDITION_DELAY, Frame.MISSION, (3.0, 0.0, 0.0, 0.0))
    kept = others(mission(wait, HELD, return_to_launch(), version="1.16"))
    assert [finding.code for finding in kept] == ["command-never-flown"]
    waits = others(mission(wait, HELD, return_to_launch(), version="1.18"))
    assert [finding.code for finding in waits] == ["way-unknown"]


def test_a_development_version_may_not_take_yet_what_its_series_does() -> None:
    arc = Item(Command.NAV_ARC_WAYPOINT, 3, (90.0, 0.0, 0.0, 0.0), THERE.latitude_deg, THERE.longitude_deg, 20.0)
    items = (HELD, arc, return_to_launch())
    assert others(mission(*items, autopilot=ARDUPILOT, version="4.7.1")) == ()
    findings = others(mission(*items, autopilot=ARDUPILOT, version="4.7.0-dev"))
    assert codes_of(findings) == ["warning command-of-development 3"]


def test_a_read_back_agrees_that_one_of_the_versions_gives() -> None:
    sent = Item(Command.NAV_LAND, 3, (5.0, 0.0, 0.0, 0.0), THERE.latitude_deg, THERE.longitude_deg)
    zeroed = Item(Command.NAV_LAND, 3, (0.0, 0.0, 0.0, 0.0), THERE.latitude_deg, THERE.longitude_deg)
    assert compare([sent], [zeroed], PX4) is None
    assert compare([sent], [zeroed], PX4, Version(1, 17)) is None
    assert str(compare([sent], [zeroed], PX4, Version(1, 18))) == "item 1: param1: sent 5, the vehicle holds 0"


def test_versions_are_read_as_they_are_written_and_as_vehicles_say_them() -> None:
    assert Version.parsed(" v1.18.0-beta1 ") == Version(1, 18, 0, "beta")
    assert Version.of_flight_sw(0x04060200) == Version(4, 6, 2, "dev")
    assert Version.of_flight_sw(0) is None
    assert all(
        Version.of_flight_sw(version.number) == version for version in (Version(4, 6, 2), Version(1, 18, 0, "rc"))
    )
    for words in ("", "1", "latest", "1.2.3.4", "1.18-gold", "1.9999"):
        with refuses("unknown-version", "", "4.6", "1.18.0-beta1", kind=BadInput):
            Version.parsed(words)
    with refuses("unknown-version", "firmware version", "px4", "1.15", "1.16", "1.17", "1.18", "4.6.0", kind=BadInput):
        PX4.tables.expect(Version(4, 6))


def test_the_newest_version_that_was_measured_is_meant_where_none_is_named() -> None:
    assert PX4.checked_for(None) == "px4 1.18"
    assert ARDUPILOT.checked_for(None) == "ardupilot 4.8"
    assert PX4.firmware() is PX4.firmware(Version(1, 18))
    assert PX4.facts(None)["version"] == "1.18.0-beta"


@pytest.mark.parametrize(
    ("autopilot", "version", "measured"),
    [
        (PX4, "1.16.2", False),
        (PX4, "1.17.0-dev", True),
        (PX4, "1.17.3", True),
        (PX4, "1.18.0-beta1", True),
        (PX4, "1.19", False),
        (ARDUPILOT, "4.6.2", False),
        (ARDUPILOT, "4.7.0-dev", True),
        (ARDUPILOT, "4.8.0-dev", True),
        (ARDUPILOT, "4.9", False),
    ],
)
def test_a_version_is_measured_whose_flights_are_in_the_lab_book(
    autopilot: Autopilot, version: str, measured: bool
) -> None:
    assert autopilot.is_measured(Version.parsed(version)) is measured
    assert (autopilot.not_measured(Version.parsed(version)) is None) is measured


def test_a_version_without_a_table_uses_the_nearest_and_names_it() -> None:
    assert str(PX4.not_measured(Version(1, 19))).endswith("its items are checked by the tables of PX4 1.18")
    assert PX4.checked_for(Version(1, 19)) == "px4 1.19 (not measured)"
