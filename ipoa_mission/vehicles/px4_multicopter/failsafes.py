"""PX4's failsafe actions.

Read in 1.17.0 (d6f12ad1), release/1.18 (05deebf313) and main of 2026-08-13 (bb59c637): commander/failsafe, its
parameters, navigator. The most severe counts. Fallbacks: hold, RTL, land, descent without position, stopped motors.
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

V1_18, V1_19 = (1, 18), (1, 19)
TERMINATES = FailsafeAction(Contingency.TERMINATE)
LANDS = FailsafeAction(Contingency.LAND, (Contingency.TERMINATE,))
RETURNS = FailsafeAction(Contingency.RTL, (Contingency.LAND, Contingency.TERMINATE))
HOLDS = FailsafeAction(Contingency.HOLD, (Contingency.RTL, Contingency.LAND, Contingency.TERMINATE))
DRIFTS = FailsafeAction(
    Contingency.UNKNOWN, (Contingency.LAND, Contingency.TERMINATE), "without a position it drifts while it descends"
)
LINK_ACTIONS = {0: GOES_ON, 1: HOLDS, 2: RETURNS, 3: LANDS, 5: TERMINATES, 6: TERMINATES}
GRADED_ACTIONS = {0: GOES_ON, 1: GOES_ON, 2: HOLDS, 3: RETURNS, 4: TERMINATES, 5: LANDS}
HEALTH_ACTIONS = {0: GOES_ON, 1: GOES_ON, 2: GOES_ON, 3: RETURNS, 4: LANDS}
TRAFFIC_ACTIONS = {
    0: GOES_ON, 1: GOES_ON, 2: replace(RETURNS, words="descends to its return height if it is higher"), 3: LANDS,
}  # fmt: skip


def _motor_failed(needs: Parameters) -> FailsafeRule:
    actions = {0: GOES_ON, 1: HOLDS, 2: LANDS, 3: RETURNS, 4: TERMINATES}
    return FailsafeRule("motor failed", "COM_ACT_FAIL_ACT", actions, needs=needs)


FAILSAFE_RULES = (
    FailsafeRule(Cause.LOW_BATTERY),
    FailsafeRule(
        Cause.CRITICAL_BATTERY, "COM_LOW_BAT_ACT",
        {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: RETURNS, 4: replace(RETURNS, since=V1_19)},
    ),
    FailsafeRule(
        "emergency battery", "COM_LOW_BAT_ACT",
        {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: LANDS, 4: replace(TERMINATES, since=V1_19)},
    ),
    FailsafeRule("flight time left is short", "COM_FLTT_LOW_ACT", {0: GOES_ON, 1: GOES_ON, 3: RETURNS}),
    FailsafeRule(
        "radio control lost", "NAV_RCL_ACT",
        {**LINK_ACTIONS, 7: replace(GOES_ON, words="holds only in a manual flight mode", since=V1_18)}, default=2.0,
    ),
    FailsafeRule(Cause.STATION_LOST, "NAV_DLL_ACT", LINK_ACTIONS),
    FailsafeRule(Cause.FENCE_BREACHED, "GF_ACTION", GRADED_ACTIONS, default=2.0),
    FailsafeRule(Cause.POSITION_LOST, usual=DRIFTS, until=V1_19),
    FailsafeRule(
        Cause.POSITION_LOST, "COM_POS_FS_ACT",
        {0: DRIFTS, 1: replace(TERMINATES, words="lands while it has a local position")}, usual=DRIFTS, since=V1_19,
    ),
    FailsafeRule(
        Cause.POSITION_INACCURATE, "COM_POS_LOW_ACT", GRADED_ACTIONS, default=3.0, needs={"COM_POS_LOW_EPH": -1.0},
    ),
    FailsafeRule(
        "satellite receiver lost", "COM_GNSSLOSS_ACT", {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: TERMINATES},
        needs={"SYS_HAS_NUM_GNSS": 0.0}, since=V1_18,
    ),
    FailsafeRule("wind too strong", "COM_WIND_MAX_ACT", GRADED_ACTIONS, needs={"COM_WIND_MAX": -1.0}),
    FailsafeRule("flown for too long", usual=RETURNS, needs={"COM_FLT_TIME_MAX": -1.0}),
    FailsafeRule("mission cannot be flown on", usual=RETURNS),
    replace(_motor_failed({"FD_ACT_EN": 1.0}), until=V1_18),
    replace(_motor_failed({"FD_ACT_EN": 0.0, "COM_ARM_CHK_ESCS": 0.0}), since=V1_18),
    FailsafeRule(
        "propeller out of balance", "COM_IMB_PROP_ACT", {-1: GOES_ON, 0: GOES_ON, 1: RETURNS, 2: LANDS}, until=V1_18,
    ),
    FailsafeRule("attitude or motor failure", "CBRK_FLIGHTTERM", {121212: GOES_ON}, default=121212.0, usual=TERMINATES),
    FailsafeRule("parachute missing", "COM_PARACHUTE", HEALTH_ACTIONS, since=V1_18),
    FailsafeRule("Remote ID lost", "COM_ARM_ODID", {**HEALTH_ACTIONS, 5: TERMINATES}, since=V1_18),
    FailsafeRule("traffic receiver lost", "COM_TRAFF_AVOID", HEALTH_ACTIONS, since=V1_19),
    FailsafeRule(
        Cause.TRAFFIC_NEAR, "NAV_TRAFF_AVOID",
        {**TRAFFIC_ACTIONS, 4: replace(GOES_ON, words="its commander lacks the order to hold")}, default=1.0,
        until=V1_19,
    ),
    FailsafeRule(
        Cause.TRAFFIC_NEAR, "NAV_TRAFF_AVOID", {**TRAFFIC_ACTIONS, 4: HOLDS, 5: TERMINATES}, default=1.0, since=V1_19,
    ),
    *failsafe.order_rules(Contingency.RTL, Contingency.LAND, Contingency.HOLD, Contingency.TERMINATE),
)  # fmt: skip

EXCEPTION_PARAMETERS = {"NAV_RCL_ACT": "COM_RCL_EXCEPT", "NAV_DLL_ACT": "COM_DLL_EXCEPT"}


def failsafes_of(parameters: Parameters, series: failsafe.Series) -> tuple[Failsafe, ...]:
    return tuple(_failsafe(rule, parameters, series) for rule in FAILSAFE_RULES if rule.since <= series < rule.until)


def _failsafe(rule: FailsafeRule, parameters: Parameters, series: failsafe.Series) -> Failsafe:
    """Apply exceptions: they continue a mission (bit 0) or, since 1.18, a return (bit 1)."""
    action = _delayed(rule, rule.action(parameters, series), parameters)
    if rule.parameter == "NAV_RCL_ACT" and parameters.get("COM_RC_IN_MODE") == 4.0:  # no radio control
        action = replace(GOES_ON, words="not checked: COM_RC_IN_MODE is 4")
    returning = action
    if rule.parameter in EXCEPTION_PARAMETERS and action.contingency is not Contingency.CONTINUE:
        name = EXCEPTION_PARAMETERS[rule.parameter]
        excepted = whole(parameters, name)
        continues = replace(GOES_ON, words=f"by {name}")
        if excepted & 1:
            action = continues
        if excepted & 2 and series >= V1_18:
            returning = continues
    if rule.cause == Cause.POSITION_INACCURATE:
        returning = replace(GOES_ON, words="applies only in a mission or a hold")
    if returning.contingency is Contingency.RTL and rule.cause != Cause.BY_HAND:
        returning = replace(GOES_ON, words="it is returning already")
    return rule.failsafe(parameters, series, action, FlightStage.RETURN, returning)


def _delayed(rule: FailsafeRule, action: FailsafeAction, parameters: Parameters) -> FailsafeAction:
    """Return the action after COM_FAIL_ACT_T, which orders of navigator, position checks and pilots do not wait for."""
    delay = parameters.get("COM_FAIL_ACT_T", 5.0)
    at_once = {Cause.POSITION_INACCURATE, Cause.POSITION_LOST, Cause.TRAFFIC_NEAR, Cause.BY_HAND}
    waits = action.contingency in {Contingency.RTL, Contingency.LAND} and rule.cause not in at_once
    return replace(action, after_s=delay) if waits and delay > 0.1 else action  # PX4 ignores shorter delays


FAILSAFES = FailsafeProfile(
    FAILSAFE_RULES,
    failsafes_of,
    (*EXCEPTION_PARAMETERS.values(), "COM_FAIL_ACT_T", "COM_RC_IN_MODE"),
    failsafe.StationLoss("COM_DL_LOSS_T", 10.0, ("NAV_DLL_ACT", "COM_DL_LOSS_T", "COM_DLL_EXCEPT", "COM_FAIL_ACT_T")),
)
