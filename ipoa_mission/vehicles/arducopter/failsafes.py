"""ArduCopter's failsafe actions.

Read in 4.7.0-dev (2598e9d4): ArduCopter/events.cpp, fence.cpp, ekf_check.cpp, crash_check.cpp, avoidance_adsb.cpp,
AP_BattMonitor, AC_Fence, AP_SmartRTL.
"""

from dataclasses import replace

from ipoa_mission.autopilot import failsafe
from ipoa_mission.autopilot.failsafe import (
    GOES_ON,
    Cause,
    Contingency,
    Failsafe,
    FailsafeAction,
    FailsafeProfile,
    FailsafeRule,
    FlightStage,
)
from ipoa_mission.autopilot.parameters import Parameters, whole
from ipoa_mission.vehicles.arducopter.limits import FENCE_SWITCHES, PARAMETER_TABLE, FenceType

LAND_PAUSE = 4.0  # LAND_WITH_DELAY_MS, except for a fence breach [s]
LANDS = FailsafeAction(Contingency.LAND, after_s=LAND_PAUSE)
RETURNS = FailsafeAction(Contingency.RTL, (Contingency.LAND,))
SMART_RETURNS = FailsafeAction(Contingency.SMART_RTL, (Contingency.RTL, Contingency.LAND))
SMART_OR_LANDS = FailsafeAction(Contingency.SMART_RTL, (Contingency.LAND,))
LAND_START = FailsafeAction(
    Contingency.LAND_START, (Contingency.RTL, Contingency.LAND), "to DO_RETURN_PATH_START or DO_LAND_START"
)
BRAKES = FailsafeAction(Contingency.HOLD, (Contingency.LAND,))
TERMINATES = FailsafeAction(Contingency.TERMINATE)
BATTERY_ACTIONS = {
    0: GOES_ON, 1: LANDS, 2: RETURNS, 3: SMART_RETURNS, 4: SMART_OR_LANDS, 5: TERMINATES, 6: LAND_START, 7: BRAKES,
}  # fmt: skip


def _drifts(words: str) -> FailsafeAction:
    return FailsafeAction(Contingency.UNKNOWN, (Contingency.LAND,), words)


def _in_fence(action: FailsafeAction) -> FailsafeAction:
    return replace(action, words="100 m outside it lands")


def _until_clear(contingency: Contingency, words: str = "{}") -> FailsafeAction:
    return FailsafeAction(contingency, words=words.format("until the traffic is gone, then by AVD_F_RCVRY"))


NO_POSITION = _drifts("without a position it drifts while it lands")
FAILSAFE_RULES = (
    FailsafeRule(
        Cause.LOW_BATTERY, "BATT_FS_LOW_ACT", BATTERY_ACTIONS, needs={"BATT_LOW_VOLT": 10.5, "BATT_LOW_MAH": 0.0},
    ),
    FailsafeRule(
        Cause.CRITICAL_BATTERY, "BATT_FS_CRT_ACT", BATTERY_ACTIONS, needs={"BATT_CRT_VOLT": 0.0, "BATT_CRT_MAH": 0.0},
    ),
    FailsafeRule(
        "radio control lost", "FS_THR_ENABLE",
        {0: GOES_ON, 1: RETURNS, 2: RETURNS, 3: LANDS, 4: SMART_RETURNS, 5: SMART_OR_LANDS, 6: LAND_START, 7: BRAKES},
        default=1.0, usual=LANDS,
    ),
    FailsafeRule(
        Cause.STATION_LOST, "FS_GCS_ENABLE",
        {0: GOES_ON, 1: RETURNS, 2: RETURNS, 3: SMART_RETURNS, 4: SMART_OR_LANDS, 5: LANDS, 6: LAND_START, 7: BRAKES},
        usual=RETURNS,
    ),
    FailsafeRule(
        Cause.FENCE_BREACHED, "FENCE_ACTION",
        {
            0: GOES_ON, 1: _in_fence(RETURNS), 2: FailsafeAction(Contingency.LAND), 3: _in_fence(SMART_RETURNS),
            4: _in_fence(BRAKES), 5: _in_fence(SMART_OR_LANDS),
        }, default=1.0, usual=_in_fence(RETURNS), needs=FENCE_SWITCHES,
    ),
    FailsafeRule(
        Cause.POSITION_LOST, "FS_EKF_ACTION",
        {
            0: GOES_ON, 1: NO_POSITION, 2: _drifts("ALT_HOLD: keeps its height, drifts, waits for the sticks"),
            3: NO_POSITION,
        }, default=1.0, usual=NO_POSITION, needs={"FS_EKF_THRESH": 0.8},
    ),
    FailsafeRule(
        "position by dead reckoning", "FS_DR_ENABLE",
        {
            0: GOES_ON, 1: _drifts("drifts on dead reckoning while it lands"),
            **dict.fromkeys((2, 3, 4, 6), _drifts("drifts on dead reckoning while it returns")), 5: TERMINATES,
            7: _drifts("drifts on dead reckoning while it holds"),
        }, default=2.0,
    ),
    FailsafeRule(Cause.TERRAIN_UNKNOWN, usual=replace(RETURNS, words="RTL continues without terrain data")),
    FailsafeRule(
        Cause.TRAFFIC_NEAR, "AVD_F_ACTION",
        {
            **dict.fromkeys((0, 1), GOES_ON),
            **dict.fromkeys((2, 3, 4), _until_clear(Contingency.UNKNOWN, "flies aside {}")),
            5: _until_clear(Contingency.RTL),
            6: _until_clear(Contingency.UNKNOWN, "LOITER {}: a low throttle stick makes it descend"),
        }, default=1.0, needs={"AVD_ENABLE": 0.0},
    ),
    FailsafeRule("parachute", usual=TERMINATES, needs={"CHUTE_ENABLED": 0.0}),
    FailsafeRule("out of control", "FS_CRASH_CHECK", {0: GOES_ON}, default=1.0, usual=TERMINATES),
    FailsafeRule("thrust lost", usual=replace(GOES_ON, words="uses all thrust that is left")),
    FailsafeRule(
        "vibration",
        usual=FailsafeAction(Contingency.CONTINUE, (Contingency.LAND,), "by FS_EKF_ACTION if its position is lost"),
    ),
    FailsafeRule("satellite position jumps"),
    FailsafeRule("compasses lost"),
    *failsafe.order_rules(
        Contingency.RTL, Contingency.LAND, Contingency.HOLD, Contingency.SMART_RTL, Contingency.LAND_START,
        Contingency.TERMINATE,
    ),
)  # fmt: skip


def failsafes_of(parameters: Parameters, series: failsafe.Series) -> tuple[Failsafe, ...]:
    further = (f"BATT{n}" for n in "23456789")
    monitored = [battery for battery in further if parameters.get(f"{battery}_MONITOR", 0.0) > 0.0]
    rules = (*FAILSAFE_RULES, *(_of_battery(rule, battery) for battery in monitored for rule in FAILSAFE_RULES[:2]))
    return tuple(_unless_less_urgent(_failsafe(rule, parameters, series), parameters, series) for rule in rules)


def _of_battery(rule: FailsafeRule, battery: str) -> FailsafeRule:
    needs = {name.replace("BATT", battery, 1): default for name, default in rule.needs.items()}
    return replace(rule, parameter=rule.parameter.replace("BATT", battery, 1), needs=needs)


def _failsafe(rule: FailsafeRule, parameters: Parameters, series: failsafe.Series) -> Failsafe:
    """Apply FS_OPTIONS: bit 0 and 1 continue a mission, bit 3 a landing."""
    action = _with_a_path(rule, rule.action(parameters, series), parameters)
    landing = action
    continues = replace(GOES_ON, words="by FS_OPTIONS")
    if action.contingency is not Contingency.CONTINUE and rule.cause != Cause.BY_HAND:
        options = whole(parameters, "FS_OPTIONS", 16.0)
        if options & {"FS_THR_ENABLE": 1, "FS_GCS_ENABLE": 2}.get(rule.parameter, 0):
            action = landing = continues
        if options & 8 and rule.parameter.startswith(("BATT", "FS_THR_ENABLE", "FS_GCS_ENABLE")):
            landing = replace(LANDS, words="by FS_OPTIONS")
        types = whole({**PARAMETER_TABLE.others, **parameters}, "FENCE_TYPE")
        if rule.cause == Cause.FENCE_BREACHED and types == FenceType.FLOOR:
            landing = replace(GOES_ON, words="a landing disables FENCE_ALT_MIN")
    if rule.cause == Cause.TERRAIN_UNKNOWN:
        landing = replace(GOES_ON, words="a landing needs no terrain data")
    return rule.failsafe(parameters, series, action, FlightStage.LANDING, landing)


def _with_a_path(rule: FailsafeRule, action: FailsafeAction, parameters: Parameters) -> FailsafeAction:
    """Replace SmartRTL by its fallback if the vehicle records no path."""
    records = parameters.get("SRTL_POINTS", 300.0) > 0.0 and parameters.get("SRTL_ACCURACY", 2.0) > 0.0
    if action.contingency is not Contingency.SMART_RTL or records:
        return action
    fallback = replace(action.in_place(), words="SmartRTL is disabled")
    pauses = fallback.contingency is Contingency.LAND and rule.cause not in {Cause.FENCE_BREACHED, Cause.BY_HAND}
    return replace(fallback, after_s=LAND_PAUSE) if pauses else fallback


def _unless_less_urgent(critical: Failsafe, parameters: Parameters, series: failsafe.Series) -> Failsafe:
    """Skip a critical battery's action if less urgent than a low one's of it; ArduCopter 4.7 ranks 6 and 7 below 0."""
    if critical.cause != Cause.CRITICAL_BATTERY:
        return critical
    rules = [_of_battery(rule, critical.parameter.split("_")[0]) for rule in FAILSAFE_RULES[:2]]
    low = _failsafe(rules[0], parameters, series)
    if not all(rule.is_monitored(parameters) for rule in rules) or _urgency(critical.value) <= _urgency(low.value):
        return critical
    words = (
        f"{critical.parameter} {critical.value:g} is less urgent than {low.parameter} {low.value:g} and has no effect, "
        "except where the voltage falls through both at once"
    )
    differs = {stage: replace(action, words=words) for stage, action in low.differs.items()}
    return replace(critical, action=replace(low.action, words=words), differs=differs, returns_at=None)


def _urgency(action: float) -> int:
    """Return the rank of a battery action, 0 for the most urgent."""
    ranked = (5, 1, 2, 4, 3, 0)
    return ranked.index(int(action)) if action in ranked else len(ranked)


#: Parameters of the first and the last station id that counts (GCS::sysid_is_gcs).
STATION_IDS = ("SYSID_MYGCS", "MAV_GCS_SYSID"), "MAV_GCS_SYSID_HI"
FAILSAFES = FailsafeProfile(
    FAILSAFE_RULES,
    failsafes_of,
    ("FS_OPTIONS", "SRTL_POINTS", "SRTL_ACCURACY", "FENCE_TYPE"),
    failsafe.StationLoss(
        "FS_GCS_TIMEOUT", 5.0, ("FS_GCS_ENABLE", "FS_GCS_TIMEOUT", "FS_OPTIONS", *STATION_IDS), *STATION_IDS
    ),
)
