"""ArduCopter's failsafe actions.

Read in 4.7.0-dev (2598e9d4): ArduCopter/events.cpp, fence.cpp, ekf_check.cpp, crash_check.cpp, avoidance_adsb.cpp,
AP_BattMonitor, AC_Fence, AP_SmartRTL. On the ground it disarms instead. Not covered: advanced failsafe (AFS_*),
scripts.
"""

import math
from dataclasses import replace

from ipoa_mission.autopilot.failsafe import (
    BY_HAND,
    GOES_ON,
    STATION_LOST,
    Failsafe,
    FailsafeAction,
    FailsafeRule,
    Series,
    StationLoss,
    ordered,
)
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import Contingency, FlightStage
from ipoa_mission.vehicles.arducopter.own_fence import FENCE_SWITCHES, FLOOR_BIT

LAND_PAUSE = 4.0  # LAND_WITH_DELAY_MS, except for a fence breach [s]
LANDS = FailsafeAction(Contingency.LAND, after_s=LAND_PAUSE)
RETURNS = FailsafeAction(Contingency.RTL, (Contingency.LAND,))
SMART_RETURNS = FailsafeAction(Contingency.SMART_RTL, (Contingency.RTL, Contingency.LAND))
SMART_OR_LANDS = FailsafeAction(Contingency.SMART_RTL, (Contingency.LAND,))
LAND_START = FailsafeAction(
    Contingency.LAND_START, (Contingency.RTL, Contingency.LAND), "to DO_RETURN_PATH_START or DO_LAND_START"
)
BRAKES = FailsafeAction(Contingency.HOLD, (Contingency.LAND,))
STOPS = FailsafeAction(Contingency.TERMINATE)

ACTIONS = {0: GOES_ON, 1: LANDS, 2: RETURNS, 3: SMART_RETURNS, 4: SMART_OR_LANDS, 5: STOPS, 6: LAND_START, 7: BRAKES}
RADIO = {0: GOES_ON, 1: RETURNS, 2: RETURNS, 3: LANDS, 4: SMART_RETURNS, 5: SMART_OR_LANDS, 6: LAND_START, 7: BRAKES}
STATION = {0: GOES_ON, 1: RETURNS, 2: RETURNS, 3: SMART_RETURNS, 4: SMART_OR_LANDS, 5: LANDS, 6: LAND_START, 7: BRAKES}
NO_POSITION = FailsafeAction(Contingency.UNKNOWN, (Contingency.LAND,), "without a position it drifts while it lands")
ESTIMATE = {
    0: GOES_ON,
    1: NO_POSITION,
    2: FailsafeAction(
        Contingency.UNKNOWN, (Contingency.LAND,), "ALT_HOLD: keeps its height, drifts, waits for the sticks"
    ),
    3: NO_POSITION,
}
DRIFTS = "drifts on dead reckoning"
RECKONS = {
    0: GOES_ON,
    1: FailsafeAction(Contingency.UNKNOWN, (Contingency.LAND,), f"{DRIFTS} while it lands"),
    **dict.fromkeys(
        (2, 3, 4, 6), FailsafeAction(Contingency.UNKNOWN, (Contingency.LAND,), f"{DRIFTS} while it returns")
    ),
    5: STOPS,
    7: FailsafeAction(Contingency.UNKNOWN, (Contingency.LAND,), f"{DRIFTS} while it holds"),
}
OUTSIDE = "100 m outside it lands"
FENCE = {
    0: GOES_ON,
    1: replace(RETURNS, words=OUTSIDE),
    2: FailsafeAction(Contingency.LAND),
    3: replace(SMART_RETURNS, words=OUTSIDE),
    4: replace(BRAKES, words=OUTSIDE),
    5: replace(SMART_OR_LANDS, words=OUTSIDE),
}
UNTIL_CLEAR = "until the traffic is gone, then by AVD_F_RCVRY"
TRAFFIC = {
    **dict.fromkeys((0, 1), GOES_ON),
    **dict.fromkeys((2, 3, 4), FailsafeAction(Contingency.UNKNOWN, words=f"flies aside {UNTIL_CLEAR}")),
    5: FailsafeAction(Contingency.RTL, words=UNTIL_CLEAR),
    6: FailsafeAction(Contingency.UNKNOWN, words=f"LOITER {UNTIL_CLEAR}: a low throttle stick makes it descend"),
}
VIBRATION_WORDS = "by FS_EKF_ACTION if its position is lost"
LOW_BATTERY, CRITICAL_BATTERY, BREACH, TERRAIN = (
    "low battery",
    "critical battery",
    "fence breached",
    "terrain data missing",
)

RULES = (
    FailsafeRule(LOW_BATTERY, "BATT_FS_LOW_ACT", 0.0, ACTIONS, GOES_ON, {"BATT_LOW_VOLT": 10.5, "BATT_LOW_MAH": 0.0}),
    FailsafeRule(
        CRITICAL_BATTERY, "BATT_FS_CRT_ACT", 0.0, ACTIONS, GOES_ON, {"BATT_CRT_VOLT": 0.0, "BATT_CRT_MAH": 0.0}
    ),
    FailsafeRule("radio control lost", "FS_THR_ENABLE", 1.0, RADIO, LANDS),
    FailsafeRule(STATION_LOST, "FS_GCS_ENABLE", 0.0, STATION, RETURNS),
    FailsafeRule(BREACH, "FENCE_ACTION", 1.0, FENCE, FENCE[1], FENCE_SWITCHES),
    FailsafeRule("position lost (EKF)", "FS_EKF_ACTION", 1.0, ESTIMATE, NO_POSITION, {"FS_EKF_THRESH": 0.8}),
    FailsafeRule("position by dead reckoning", "FS_DR_ENABLE", 2.0, RECKONS, GOES_ON),
    FailsafeRule(TERRAIN, "", math.nan, {}, replace(RETURNS, words="RTL continues without terrain data")),
    FailsafeRule("traffic near", "AVD_F_ACTION", 1.0, TRAFFIC, GOES_ON, {"AVD_ENABLE": 0.0}),
    FailsafeRule("parachute", "", math.nan, {}, STOPS, {"CHUTE_ENABLED": 0.0}),
    FailsafeRule("out of control", "FS_CRASH_CHECK", 1.0, {0: GOES_ON}, STOPS),
    FailsafeRule("thrust lost", "", math.nan, {}, replace(GOES_ON, words="uses all thrust that is left")),
    FailsafeRule("vibration", "", math.nan, {}, replace(GOES_ON, otherwise=(Contingency.LAND,), words=VIBRATION_WORDS)),
    FailsafeRule("satellite position jumps", "", math.nan, {}, GOES_ON),
    FailsafeRule("compasses lost", "", math.nan, {}, GOES_ON),
    *ordered(
        Contingency.RTL,
        Contingency.LAND,
        Contingency.HOLD,
        Contingency.SMART_RTL,
        Contingency.LAND_START,
        Contingency.TERMINATE,
    ),
)

#: Bits of FS_OPTIONS that continue a mission.
CONTINUE_BITS = {"FS_THR_ENABLE": 1, "FS_GCS_ENABLE": 2}
LANDING_BIT, DEFAULT_OPTIONS = 8, 16.0  # of FS_OPTIONS: continue a landing
LANDING_PARAMETERS = ("BATT_FS_LOW_ACT", "BATT_FS_CRT_ACT", *CONTINUE_BITS)
URGENCY = (5, 1, 2, 4, 3, 0)  # battery actions, most urgent first
BATTERIES = tuple(f"BATT{n}" for n in "23456789")

DECIDED_BY = tuple(
    dict.fromkeys(
        (
            *(name for rule in RULES for name in (rule.parameter, *rule.needs) if name),
            *("FS_OPTIONS", "SRTL_POINTS", "SRTL_ACCURACY", "FENCE_TYPE"),
        )
    )
)

#: Station ids from the first to the second parameter (GCS::sysid_is_gcs).
HEEDED = ("SYSID_MYGCS", "MAV_GCS_SYSID"), "MAV_GCS_SYSID_HI"
STATION_LOSS = StationLoss("FS_GCS_TIMEOUT", 5.0, ("FS_GCS_ENABLE", "FS_GCS_TIMEOUT", "FS_OPTIONS", *HEEDED), *HEEDED)


def failsafes(parameters: Parameters, series: Series) -> tuple[Failsafe, ...]:
    first = [_failsafe(rule, parameters, series) for rule in RULES]
    more = [
        _failsafe(_of(rule, battery), parameters, series)
        for battery in BATTERIES
        if parameters.get(f"{battery}_MONITOR", 0.0) > 0.0
        for rule in RULES[:2]
    ]
    return tuple(_with_its_urgency(one, parameters, series) for one in (*first, *more))


def _of(rule: FailsafeRule, battery: str) -> FailsafeRule:
    named = {name.replace("BATT", battery, 1): usual for name, usual in rule.needs.items()}
    return replace(rule, parameter=rule.parameter.replace("BATT", battery, 1), needs=named)


def _failsafe(rule: FailsafeRule, parameters: Parameters, series: Series) -> Failsafe:
    action = _with_a_path(rule.action(parameters, series), parameters, rule.cause not in {BREACH, BY_HAND})
    options, landing = int(parameters.get("FS_OPTIONS", DEFAULT_OPTIONS)), action
    if action.contingency is not Contingency.CONTINUE and rule.cause != BY_HAND:
        if options & CONTINUE_BITS.get(rule.parameter, 0):
            action = landing = replace(GOES_ON, words="by FS_OPTIONS")
        acts = _first(rule.parameter) in LANDING_PARAMETERS
        landing = replace(LANDS, words="by FS_OPTIONS") if acts and options & LANDING_BIT else landing
    has_only_a_floor = rule.cause == BREACH and int(parameters.get("FENCE_TYPE", 7.0)) == FLOOR_BIT
    if has_only_a_floor and action.contingency is not Contingency.CONTINUE:
        landing = replace(GOES_ON, words="a landing disables FENCE_ALT_MIN")
    if rule.cause == TERRAIN:
        landing = replace(GOES_ON, words="a landing needs no terrain data")
    differs = {} if landing == action else {FlightStage.LANDING: landing}
    returns_at = rule.returns_at(series)
    return Failsafe(rule.cause, rule.parameter, rule.value(parameters), action, differs, returns_at)


def _first(name: str) -> str:
    return f"BATT{name[5:]}" if name[:5] in BATTERIES else name


def _with_a_path(action: FailsafeAction, parameters: Parameters, pauses: bool) -> FailsafeAction:
    """Replace SmartRTL by its fallback if it records no path."""
    keeps = parameters.get("SRTL_POINTS", 300.0) > 0.0 and parameters.get("SRTL_ACCURACY", 2.0) > 0.0
    if action.contingency is not Contingency.SMART_RTL or keeps:
        return action
    instead = replace(action.in_place(), words="SmartRTL is disabled")
    return replace(instead, after_s=LAND_PAUSE) if instead.contingency is Contingency.LAND and pauses else instead


def _with_its_urgency(one: Failsafe, parameters: Parameters, series: Series) -> Failsafe:
    """Skip the action for a critical battery if it is less urgent than for a low one.

    Several batteries are not compared. ArduCopter 4.7 ranks actions 6 and 7 below 0.
    """
    if one.cause != CRITICAL_BATTERY:
        return one
    both = [_of(rule, one.parameter.split("_")[0]) for rule in RULES[:2]]
    low = _failsafe(both[0], parameters, series)
    if not all(rule.looks(parameters) for rule in both) or _urgency(one.value) <= _urgency(low.value):
        return one
    words = (
        f"{one.parameter} {one.value:g} is less urgent than {low.parameter} {low.value:g} and has no effect, "
        "except where the voltage falls through both at once"
    )
    differs = {stage: replace(action, words=words) for stage, action in low.differs.items()}
    return replace(one, route=replace(low.route, words=words), differs=differs, returns_at=None)


def _urgency(action: float) -> int:
    return URGENCY.index(int(action)) if action in URGENCY else len(URGENCY)
