"""Failsafe actions against the firmwares' own parameter documentation.

ArduCopter 4.7.0-dev (2598e9d4: @Values of ArduCopter/Parameters.cpp, AP_BattMonitor_Params.cpp, AC_Fence.cpp and
AP_Avoidance.cpp), PX4 1.17.0 (d6f12ad1), release/1.18 (05deebf313) and main of 2026-08-13 (bb59c637, to be 1.19):
@value of commander_params, geofence_params and navigator_params.
"""

import math
import re

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.failsafe import Contingency, Failsafe, FlightStage
from ipoa_mission.autopilot.known_parameters import expect_known
from ipoa_mission.autopilot.parameters import INT8, INT16, INT32, REAL32, Parameters
from ipoa_mission.autopilot.version import Version
from tests.refused import refuses
from tools.generate import failsafes as page

AP, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
OLD, NEW, MAIN = Version(1, 17), Version(1, 18), Version(1, 19)
ACTIONS = (
    "0:None,1:Land,2:RTL,3:SmartRTL or RTL,4:SmartRTL or Land,5:Terminate,"
    "6:Auto DO_LAND_START/DO_RETURN_PATH_START or RTL,7:Brake or Land"
)
DOCUMENTED = {
    "BATT_FS_LOW_ACT": ACTIONS,
    "BATT_FS_CRT_ACT": ACTIONS,
    "FS_THR_ENABLE": "0:Disabled,1:Enabled always RTL,2:Enabled RTL,3:Enabled always Land,"
    "4:Enabled always SmartRTL or RTL,5:Enabled always SmartRTL or Land,"
    "6:Enabled Auto DO_LAND_START/DO_RETURN_PATH_START or RTL,7:Enabled always Brake or Land",
    "FS_GCS_ENABLE": "0:Disabled/NoAction,1:RTL,2:RTL,3:SmartRTL or RTL,4:SmartRTL or Land,5:Land,"
    "6:Auto DO_LAND_START/DO_RETURN_PATH_START or RTL,7:Brake or Land",
    "FENCE_ACTION": "0:Report Only,1:RTL or Land,2:Always Land,3:SmartRTL or RTL or Land,4:Brake or Land,"
    "5:SmartRTL or Land",
    "FS_EKF_ACTION": "0:Report only,1:Switch to Land mode,2:AltHold,3:Switch to Land mode",
    "AVD_F_ACTION": "0:None,1:Report,2:Climb Or Descend,3:Move Horizontally,4:Move Perpendicularly in 3D,5:RTL,6:Hover",
    "FS_CRASH_CHECK": "0:Disabled,1:Enabled",
    "FS_DR_ENABLE": "0:Disabled/NoAction",  # in all others it drifts: docs/data/returns.csv
}
GRADES = "0:None,1:Warning,2:Hold mode,3:Return mode,4:Terminate,5:Land mode"
LINK = "1:Hold mode,2:Return mode,3:Land mode,5:Terminate,6:Disarm"
OF_PX4 = {
    "NAV_DLL_ACT": "0:Disabled," + LINK,
    "NAV_RCL_ACT": LINK,
    "GF_ACTION": GRADES,
    "COM_WIND_MAX_ACT": GRADES,
    "COM_POS_LOW_ACT": GRADES,
    "COM_FLTT_LOW_ACT": "0:None,1:Warning,3:Return",
    "COM_ACT_FAIL_ACT": "0:Warning only,1:Hold mode,2:Land mode,3:Return mode,4:Terminate",
    "NAV_TRAFF_AVOID": "0:Disabled,1:Warn only,2:Return mode,3:Land mode,4:Disabled",  # as flown: docs/data/returns.csv
}
OF_117 = OF_PX4 | {"COM_IMB_PROP_ACT": "-1:Disabled,0:Warning,1:Return,2:Land"}
OF_118 = OF_PX4 | {
    "NAV_RCL_ACT": LINK + ",7:Disabled",  # "Hold mode (no failsafe)": flown by hand only
    "COM_GNSSLOSS_ACT": "0:Warning,1:Return,2:Land,3:Terminate",
    "COM_PARACHUTE": "0:Disabled,1:Warning,2:Error,3:Return,4:Land",
    "COM_ARM_ODID": "0:Disabled,1:Warning only,2:Error only,3:Return,4:Land,5:Terminate",
}
OF_MAIN = OF_118 | {
    "NAV_TRAFF_AVOID": "0:Disabled,1:Warn only,2:Return mode,3:Land mode,4:Position Hold mode,5:Terminate",
    "COM_TRAFF_AVOID": "0:Disabled,1:Warning,2:Error,3:Return,4:Land",
    "COM_POS_FS_ACT": "0:Descend mode,1:Terminate",
}
OF_VERSIONS = [(AP, None, DOCUMENTED), (PX4, OLD, OF_117), (PX4, NEW, OF_118), (PX4, MAIN, OF_MAIN)]
WORDS = {
    r"None|Disabled|Warn|Error|Report": Contingency.CONTINUE,
    r"SmartRTL": Contingency.SMART_RTL,
    r"DO_LAND_START": Contingency.LAND_START,
    r"\bRTL|Return": Contingency.RTL,
    r"Switch to Land|Descend": Contingency.UNKNOWN,  # without a position it drifts: docs/data/returns.csv
    r"Land": Contingency.LAND,
    r"Terminate|Disarm": Contingency.TERMINATE,
    r"Brake|Hold mode": Contingency.HOLD,
    r"AltHold|Climb|Move|Hover": Contingency.UNKNOWN,  # LOITER obeys the sticks: docs/data/returns.csv
    r"Enabled": Contingency.TERMINATE,  # that it is looked for
}
LOOKED_FOR = {
    **{"BATT_CRT_VOLT": 10.0, "BATT_LOW_VOLT": 10.5, "FENCE_ENABLE": 1.0, "BATT_FS_LOW_ACT": 0.0},
    **{"FD_ACT_EN": 1.0, "COM_WIND_MAX": 12.0, "COM_POS_LOW_EPH": 5.0, "SYS_HAS_NUM_GNSS": 1.0, "AVD_ENABLE": 1.0},
}


def documented(values: str) -> list[tuple[float, tuple[Contingency, ...]]]:
    """Return each value, and the contingencies that its words name in order."""
    pairs = (pair.split(":", 1) for pair in values.split(","))
    return [
        (
            float(value),
            tuple(next(e for word, e in WORDS.items() if re.search(word, part)) for part in text.split(" or ")),
        )
        for value, text in pairs
    ]


def by(name: str, parameters: Parameters, autopilot: Autopilot = AP, version: Version | None = None) -> Failsafe:
    return next(failsafe for failsafe in autopilot.failsafes(parameters, version) if failsafe.parameter == name)


@pytest.mark.parametrize(("autopilot", "version", "table"), OF_VERSIONS)
def test_every_documented_value_is_followed_by_what_its_words_say(
    autopilot: Autopilot, version: Version | None, table: dict[str, str]
) -> None:
    wrong = {}
    for name, values in table.items():
        for value, (first, *others) in documented(values):
            parameters = LOOKED_FOR | ({"BATT_LOW_VOLT": 0.0} if name == "BATT_FS_CRT_ACT" else {})
            action = by(name, parameters | {name: value}, autopilot, version).action
            if (action.contingency, *action.fallbacks[: len(others)]) != (first, *others):
                wrong[name, value] = str(action)
    assert not wrong


@pytest.mark.parametrize(("autopilot", "version", "table"), OF_VERSIONS)
def test_landing_by_choice_returns_with_the_named_value(
    autopilot: Autopilot, version: Version | None, table: dict[str, str]
) -> None:
    """The documented values have a return as well."""
    for name, values in table.items():
        parameters = LOOKED_FOR | ({"BATT_LOW_VOLT": 0.0} if name == "BATT_FS_CRT_ACT" else {})
        returns = [value for value, (first, *_) in documented(values) if first is Contingency.RTL]
        for value, _ in documented(values):
            failsafe = by(name, parameters | {name: value}, autopilot, version)
            assert failsafe.lands_by_choice == (failsafe.action.contingency is Contingency.LAND and bool(returns)), (
                name,
                value,
            )
            if failsafe.lands_by_choice:
                assert failsafe.returns_at in returns
                there = by(name, parameters | {name: float(returns[0])}, autopilot, version)
                assert there.action.contingency is Contingency.RTL


@pytest.mark.parametrize(("autopilot", "table"), [(AP, DOCUMENTED), (PX4, OF_MAIN)])
def test_every_parameter_that_decides_is_held_against_its_documentation(
    autopilot: Autopilot, table: dict[str, str]
) -> None:
    deciding = {rule.parameter for rule in autopilot.failsafe_profile.rules if rule.parameter}
    assert deciding - set(table) - {"COM_LOW_BAT_ACT", "CBRK_FLIGHTTERM"} == deciding & {"COM_IMB_PROP_ACT"}


#: AP_Param types of ArduCopter's headers; PX4's parameters.json of 1.17 and 1.18, and sources of main.
TYPES = {
    AP: {
        INT8: "AVD_ENABLE AVD_F_ACTION BATT_FS_CRT_ACT BATT_FS_LOW_ACT CHUTE_ENABLED FENCE_ACTION FENCE_AUTOENABLE "
        "FENCE_ENABLE FENCE_TYPE FS_CRASH_CHECK FS_DR_ENABLE FS_EKF_ACTION FS_GCS_ENABLE FS_THR_ENABLE",
        INT16: "SRTL_POINTS",
        INT32: "FS_OPTIONS",
        REAL32: "BATT_CRT_MAH BATT_CRT_VOLT BATT_LOW_MAH BATT_LOW_VOLT FS_EKF_THRESH SRTL_ACCURACY",
    },
    PX4: {
        INT32: "CBRK_FLIGHTTERM COM_ACT_FAIL_ACT COM_ARM_CHK_ESCS COM_ARM_ODID COM_DLL_EXCEPT COM_FLTT_LOW_ACT "
        "COM_FLT_TIME_MAX COM_GNSSLOSS_ACT COM_IMB_PROP_ACT COM_LOW_BAT_ACT COM_PARACHUTE COM_POS_FS_ACT "
        "COM_POS_LOW_ACT COM_RCL_EXCEPT COM_RC_IN_MODE COM_TRAFF_AVOID COM_WIND_MAX_ACT FD_ACT_EN GF_ACTION "
        "NAV_DLL_ACT NAV_RCL_ACT NAV_TRAFF_AVOID SYS_HAS_NUM_GNSS",
        REAL32: "COM_FAIL_ACT_T COM_POS_LOW_EPH COM_WIND_MAX",
    },
}


@pytest.mark.parametrize("autopilot", [AP, PX4])
def test_every_parameter_has_the_type_of_the_firmware(autopilot: Autopilot) -> None:
    """QGroundControl requires it in NAME.params."""
    firmware = {name: kind for kind, names in TYPES[autopilot].items() for name in names.split()}
    kinds = autopilot.parameter_table.kinds
    assert {name: kinds.get(name, REAL32) for name in autopilot.failsafe_profile.parameters} == firmware


@pytest.mark.parametrize(("autopilot", "names"), [(AP, {"FENCE_ACTION"}), (PX4, {"GF_ACTION", "NAV_DLL_ACT"})])
def test_a_default_is_that_of_the_table(autopilot: Autopilot, names: set[str]) -> None:
    known = autopilot.parameter_table.others
    defaults = {rule.parameter: rule.default for rule in autopilot.failsafe_profile.rules if rule.parameter in known}
    assert defaults == {name: known[name] for name in names}


@pytest.mark.parametrize(
    ("value", "critical", "emergency"),
    [(0.0, "continue", "continue"), (2.0, "land", "land"), (3.0, "rtl", "land"), (4.0, "rtl", "terminate")],
)
def test_px4_takes_a_battery_by_its_stage(value: float, critical: str, emergency: str) -> None:
    """COM_LOW_BAT_ACT: warning; land mode; return at critical, land at emergency level; or terminate there (1.19)."""
    by_cause = {each.cause: each.action.contingency for each in PX4.failsafes({"COM_LOW_BAT_ACT": value}, MAIN)}
    assert (by_cause["low battery"], by_cause["critical battery"]) == ("continue", critical)
    assert by_cause["emergency battery"] == emergency


def test_a_value_of_a_later_version_is_no_value_of_an_earlier_one() -> None:
    for earlier in (OLD, NEW):
        assert by("COM_LOW_BAT_ACT", {"COM_LOW_BAT_ACT": 4.0}, PX4, earlier).action.contingency is Contingency.CONTINUE
        assert {each.parameter for each in PX4.failsafes({}, earlier)}.isdisjoint({"COM_TRAFF_AVOID", "COM_POS_FS_ACT"})
    assert all(failsafe.parameter != "COM_PARACHUTE" for failsafe in PX4.failsafes({}, OLD))
    assert all(failsafe.parameter != "COM_IMB_PROP_ACT" for failsafe in PX4.failsafes({}, NEW))


@pytest.mark.parametrize("autopilot", [AP, PX4])
@pytest.mark.parametrize("value", [*(float(n) for n in range(-3, 20)), 2.5, 1e6, math.nan, math.inf])
def test_any_value_of_any_parameter_has_an_answer_at_every_stage(autopilot: Autopilot, value: float) -> None:
    parameters = LOOKED_FOR | {rule.parameter: value for rule in autopilot.failsafe_profile.rules if rule.parameter}
    for failsafe in autopilot.failsafes(parameters):
        for stage in FlightStage:
            assert failsafe.at(stage).contingency in Contingency
            assert (failsafe.at(stage).contingency is Contingency.UNKNOWN) <= bool(failsafe.at(stage).words)
        if failsafe.parameter and not math.isfinite(value):
            assert failsafe.action.contingency is Contingency.UNKNOWN


@pytest.mark.parametrize(
    ("options", "route", "landing"),
    [(0.0, "rtl", "rtl"), (1.0, "continue", "continue"), (8.0, "rtl", "land"), (9.0, "continue", "land")],
)
def test_fs_options_decide_by_stage(options: float, route: str, landing: str) -> None:
    """Bit 0: "Continue if in Auto on RC failsafe", bit 3: "Continue if landing on any failsafe"."""
    lost = by("FS_THR_ENABLE", {"FS_OPTIONS": options})
    assert (lost.at(FlightStage.ROUTE).contingency, lost.at(FlightStage.LANDING).contingency) == (route, landing)
    station = by("FS_GCS_ENABLE", {"FS_OPTIONS": 2.0 * (options % 8.0) + (options - options % 8.0), "FS_GCS_ENABLE": 1})
    assert (station.at(FlightStage.ROUTE).contingency, station.at(FlightStage.LANDING).contingency) == (route, landing)


def test_a_critical_battery_less_urgent_than_a_low_one_changes_nothing() -> None:
    """AP_BattMonitor::check_failsafes: terminate, land, RTL, SmartRTL or land, SmartRTL, none, then the others."""
    base = {"BATT_LOW_VOLT": 10.5, "BATT_CRT_VOLT": 10.0}
    for low, critical, then in (
        (2, 1, "land"),
        (1, 2, "land"),
        (0, 7, "continue"),
        (3, 4, "smart_rtl"),
        (4, 3, "smart_rtl"),
    ):
        action = by("BATT_FS_CRT_ACT", base | {"BATT_FS_LOW_ACT": low, "BATT_FS_CRT_ACT": critical}).action
        assert action.contingency == then
        assert ("less urgent" in action.words) == ((low, critical) in {(1, 2), (0, 7), (4, 3)})
    unwatched = base | {"BATT_LOW_VOLT": 0.0, "BATT_FS_CRT_ACT": 7}
    assert by("BATT_FS_CRT_ACT", unwatched).action.contingency is Contingency.HOLD


def test_unexamined_failsafes_are_named() -> None:
    assert "FENCE_ENABLE" in by("FENCE_ACTION", {}).action.words
    assert by("FENCE_ACTION", {"FENCE_AUTOENABLE": 3.0}).action.contingency is Contingency.RTL
    assert "BATT_CRT_VOLT" in by("BATT_FS_CRT_ACT", {"BATT_FS_CRT_ACT": 1.0}).action.words
    assert by("NAV_RCL_ACT", {"COM_RC_IN_MODE": 4.0}, PX4).action.contingency is Contingency.CONTINUE


def test_a_second_battery_has_failsafes_of_its_own() -> None:
    names = [failsafe.parameter for failsafe in AP.failsafes({"BATT2_MONITOR": 4.0, "BATT2_FS_LOW_ACT": 1.0})]
    assert {"BATT2_FS_LOW_ACT", "BATT2_FS_CRT_ACT"} <= set(names)
    second = {
        "BATT2_MONITOR": 4.0,
        "BATT2_FS_LOW_ACT": 1.0,
        "BATT2_LOW_VOLT": 0.0,
        "BATT2_LOW_MAH": 500.0,
        "FS_OPTIONS": 8.0,
    }
    assert by("BATT2_FS_LOW_ACT", second).at(FlightStage.LANDING).words == "by FS_OPTIONS"


def test_smart_rtl_without_points_is_what_stands_behind_it() -> None:
    none = {"SRTL_POINTS": 0.0, "FS_THR_ENABLE": 4.0, "FS_GCS_ENABLE": 4.0}
    assert by("FS_THR_ENABLE", none).action.contingency is Contingency.RTL
    assert (by("FS_GCS_ENABLE", none).action.contingency, by("FS_GCS_ENABLE", none).action.after_s) == (
        Contingency.LAND,
        4.0,
    )
    assert Contingency.SMART_RTL not in {failsafe.action.contingency for failsafe in AP.failsafes(none)}


def test_px4_excepts_modes_of_a_lost_link() -> None:
    both = {"COM_RCL_EXCEPT": 3.0, "COM_DLL_EXCEPT": 1.0, "NAV_RCL_ACT": 3.0, "NAV_DLL_ACT": 1.0}
    old, new = (by("NAV_RCL_ACT", both, PX4, version) for version in (OLD, NEW))
    assert (old.at(FlightStage.ROUTE).contingency, old.at(FlightStage.RETURN).contingency) == (
        Contingency.CONTINUE,
        Contingency.LAND,
    )
    assert (new.at(FlightStage.ROUTE).contingency, new.at(FlightStage.RETURN).contingency) == (
        Contingency.CONTINUE,
        Contingency.CONTINUE,
    )
    assert by("NAV_DLL_ACT", both, PX4, OLD).at(FlightStage.RETURN).contingency is Contingency.HOLD


def test_motors_are_examined_by_default_until_1_17() -> None:
    """FD_ACT_EN: 1 in failure_detector_params.c of 1.17, 0 in esc_check_params.yaml of 1.18, where ESCs count too."""
    lands = {"COM_ACT_FAIL_ACT": 2.0}
    old, new = (by("COM_ACT_FAIL_ACT", lands, PX4, version).action for version in (OLD, NEW))
    assert (old.contingency, new.contingency) == (Contingency.LAND, Contingency.CONTINUE)
    assert new.words == "not checked: needs FD_ACT_EN or COM_ARM_CHK_ESCS above 0"
    for name in ("FD_ACT_EN", "COM_ARM_CHK_ESCS"):
        assert by("COM_ACT_FAIL_ACT", lands | {name: 1.0}, PX4, NEW).action.contingency is Contingency.LAND


@pytest.mark.parametrize(
    ("autopilot", "name"), [(PX4, "COM_DLL_EXCEPT"), (PX4, "COM_RCL_EXCEPT"), (AP, "FS_OPTIONS"), (AP, "FENCE_TYPE")]
)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_bits_that_are_no_number_are_refused_by_name(autopilot: Autopilot, name: str, value: float) -> None:
    acts = {"NAV_DLL_ACT": 2.0, "FENCE_ENABLE": 1.0}
    with refuses("bad-input", name, "expected a whole number"):
        autopilot.failsafes(acts | {name: value})


def test_hold_before_a_failsafe_has_its_duration() -> None:
    """COM_FAIL_ACT_T before what a user may take over; LAND_WITH_DELAY_MS where ArduCopter lands by a failsafe."""
    assert by("NAV_RCL_ACT", {}, PX4).action.after_s == 5.0
    assert by("NAV_RCL_ACT", {"COM_FAIL_ACT_T": 0.0}, PX4).action.after_s == 0.0
    assert by("GF_ACTION", {"GF_ACTION": 4.0}, PX4).action.after_s == 0.0
    assert by("FS_THR_ENABLE", {"FS_THR_ENABLE": 3.0}).action.after_s == 4.0
    assert by("FENCE_ACTION", {"FENCE_ACTION": 2.0, "FENCE_ENABLE": 1.0}).action.after_s == 0.0


def test_deciding_parameter_is_known() -> None:
    expect_known(["FS_OPTIONS", "BATT_FS_CRT_ACT", "RTL_ALT_M"], AP)
    with refuses("bad-input", "FS_OPTIONS", "px4"):
        expect_known(["FS_OPTIONS"], PX4)


def test_the_page_is_as_the_tables() -> None:
    assert page.PAGE.read_text(encoding="utf-8") == page.page(), "run python -m tools.generate.failsafes"


def test_home_by_dead_reckoning_is_not_known() -> None:
    """Both that were flown went through something that RTL keeps clear of."""
    for value in (2.0, 3.0, 4.0, 6.0):
        assert by("FS_DR_ENABLE", {"FS_DR_ENABLE": value}).action.contingency is Contingency.UNKNOWN


def test_a_landing_has_no_floor() -> None:
    fenced = {"FENCE_ENABLE": 1.0, "FENCE_TYPE": 8.0}
    assert by("FENCE_ACTION", fenced).at(FlightStage.ROUTE).contingency is Contingency.RTL
    assert by("FENCE_ACTION", fenced).at(FlightStage.LANDING).contingency is Contingency.CONTINUE
    assert FlightStage.LANDING not in by("FENCE_ACTION", fenced | {"FENCE_TYPE": 15.0}).differs
