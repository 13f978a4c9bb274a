"""PX4's failsafe actions.

Read in 1.17.0 (d6f12ad1), release/1.18 (05deebf313) and main of 2026-08-13 (bb59c637): commander/failsafe, its
parameters, navigator. The most severe counts. Fallbacks: hold, RTL, land, descent without position, stopped motors. Not
covered: VTOL, offboard, seconds after arming.
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

V1_18, V1_19 = (1, 18), (1, 19)
FALLS = FailsafeAction(Contingency.TERMINATE)
LANDS = FailsafeAction(Contingency.LAND, (Contingency.TERMINATE,))
RETURNS = FailsafeAction(Contingency.RTL, (Contingency.LAND, Contingency.TERMINATE))
HOLDS = FailsafeAction(Contingency.HOLD, (Contingency.RTL, Contingency.LAND, Contingency.TERMINATE))
NO_POSITION_FALLS = replace(FALLS, words="lands while it has a local position")
DRIFTS = FailsafeAction(
    Contingency.UNKNOWN, (Contingency.LAND, Contingency.TERMINATE), "without a position it drifts while it descends"
)


def new(action: FailsafeAction, since: Series) -> FailsafeAction:
    return replace(action, since=since)


LINK = {0: GOES_ON, 1: HOLDS, 2: RETURNS, 3: LANDS, 5: FALLS, 6: FALLS}
RADIO = {**LINK, 7: new(replace(GOES_ON, words="holds only if a pilot flew it by hand"), V1_18)}
GRADES = {0: GOES_ON, 1: GOES_ON, 2: HOLDS, 3: RETURNS, 4: FALLS, 5: LANDS}
HEALTH = {0: GOES_ON, 1: GOES_ON, 2: GOES_ON, 3: RETURNS, 4: LANDS}
CRITICAL = {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: RETURNS, 4: new(RETURNS, V1_19)}
EMERGENCY = {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: LANDS, 4: new(FALLS, V1_19)}
MOTOR = {0: GOES_ON, 1: HOLDS, 2: LANDS, 3: RETURNS, 4: FALLS}
SATELLITES = {0: GOES_ON, 1: RETURNS, 2: LANDS, 3: FALLS}
AT_RETURN_HEIGHT = replace(RETURNS, words="descends to its return height if it is higher")
TRAFFIC = {0: GOES_ON, 1: GOES_ON, 2: AT_RETURN_HEIGHT, 3: LANDS, 4: HOLDS, 5: new(FALLS, V1_19)}
NO_HOLD = replace(GOES_ON, words="its commander lacks the order to hold")
ATTITUDE_FAILURE, RADIO_SOURCE, NO_RADIO = "attitude or motor failure", "COM_RC_IN_MODE", 4.0
BALANCE = {-1: GOES_ON, 0: GOES_ON, 1: RETURNS, 2: LANDS}
ACCURACY = "position inaccurate"

RULES = (
    FailsafeRule("low battery", "", math.nan, {}, GOES_ON),
    FailsafeRule("critical battery", "COM_LOW_BAT_ACT", 0.0, CRITICAL, GOES_ON),
    FailsafeRule("emergency battery", "COM_LOW_BAT_ACT", 0.0, EMERGENCY, GOES_ON),
    FailsafeRule("flight time left is short", "COM_FLTT_LOW_ACT", 0.0, {0: GOES_ON, 1: GOES_ON, 3: RETURNS}, GOES_ON),
    FailsafeRule("radio control lost", "NAV_RCL_ACT", 2.0, RADIO, GOES_ON),
    FailsafeRule(STATION_LOST, "NAV_DLL_ACT", 0.0, LINK, GOES_ON),
    FailsafeRule("fence breached", "GF_ACTION", 2.0, GRADES, GOES_ON),
    FailsafeRule("position lost (EKF)", "", math.nan, {}, DRIFTS, until=V1_19),
    FailsafeRule("position lost (EKF)", "COM_POS_FS_ACT", 0.0, {0: DRIFTS, 1: NO_POSITION_FALLS}, DRIFTS, since=V1_19),
    FailsafeRule(ACCURACY, "COM_POS_LOW_ACT", 3.0, GRADES, GOES_ON, {"COM_POS_LOW_EPH": -1.0}),
    FailsafeRule(
        "satellite receiver lost", "COM_GNSSLOSS_ACT", 0.0, SATELLITES, GOES_ON, {"SYS_HAS_NUM_GNSS": 0.0}, V1_18
    ),
    FailsafeRule("wind too strong", "COM_WIND_MAX_ACT", 0.0, GRADES, GOES_ON, {"COM_WIND_MAX": -1.0}),
    FailsafeRule("flown for too long", "", math.nan, {}, RETURNS, {"COM_FLT_TIME_MAX": -1.0}),
    FailsafeRule("mission cannot be flown on", "", math.nan, {}, RETURNS),
    FailsafeRule("motor failed", "COM_ACT_FAIL_ACT", 0.0, MOTOR, GOES_ON),
    FailsafeRule("propeller out of balance", "COM_IMB_PROP_ACT", 0.0, BALANCE, GOES_ON, until=V1_18),
    FailsafeRule(ATTITUDE_FAILURE, "CBRK_FLIGHTTERM", 121212.0, {121212: GOES_ON}, FALLS),
    FailsafeRule("parachute missing", "COM_PARACHUTE", 0.0, HEALTH, GOES_ON, since=V1_18),
    FailsafeRule("Remote ID lost", "COM_ARM_ODID", 0.0, {**HEALTH, 5: FALLS}, GOES_ON, since=V1_18),
    FailsafeRule("traffic receiver lost", "COM_TRAFF_AVOID", 0.0, HEALTH, GOES_ON, since=V1_19),
    FailsafeRule("traffic near", "NAV_TRAFF_AVOID", 1.0, {**TRAFFIC, 4: NO_HOLD}, GOES_ON, until=V1_19),
    FailsafeRule("traffic near", "NAV_TRAFF_AVOID", 1.0, TRAFFIC, GOES_ON, since=V1_19),
    *ordered(Contingency.RTL, Contingency.LAND, Contingency.HOLD, Contingency.TERMINATE),
)  # fmt: skip

#: Bits that ignore a lost link: 1 in a mission, 2 (1.18) in a return.
EXCEPTION_PARAMETERS = {"NAV_RCL_ACT": "COM_RCL_EXCEPT", "NAV_DLL_ACT": "COM_DLL_EXCEPT"}
IN_MISSION, IN_AUTO = 1, 2
DELAY, LEAST_DELAY = "COM_FAIL_ACT_T", 0.1  # [s]; shorter are ignored
#: Orders of navigator, position monitoring, and pilots.
WITHOUT_DELAY = frozenset({ACCURACY, "position lost (EKF)", "traffic near", BY_HAND})

DECIDED_BY = tuple(
    dict.fromkeys(
        (
            *(name for rule in RULES for name in (rule.parameter, *rule.needs) if name),
            *(*EXCEPTION_PARAMETERS.values(), DELAY, RADIO_SOURCE),
        )
    )
)

STATION_LOSS = StationLoss(
    "COM_DL_LOSS_T", 10.0, ("NAV_DLL_ACT", "COM_DL_LOSS_T", EXCEPTION_PARAMETERS["NAV_DLL_ACT"], DELAY)
)


def failsafes(parameters: Parameters, series: Series) -> tuple[Failsafe, ...]:
    return tuple(_failsafe(rule, parameters, series) for rule in RULES if rule.since <= series < rule.until)


def _failsafe(rule: FailsafeRule, parameters: Parameters, series: Series) -> Failsafe:
    action = _later(rule, rule.action(parameters, series), parameters)
    if rule.parameter == "NAV_RCL_ACT" and parameters.get(RADIO_SOURCE) == NO_RADIO:
        action = replace(GOES_ON, words=f"not checked: {RADIO_SOURCE} is 4")
    returning = action
    if rule.parameter in EXCEPTION_PARAMETERS and action.contingency is not Contingency.CONTINUE:
        excepted, words = (
            int(parameters.get(EXCEPTION_PARAMETERS[rule.parameter], 0.0)),
            f"by {EXCEPTION_PARAMETERS[rule.parameter]}",
        )
        if excepted & IN_MISSION:
            action = replace(GOES_ON, words=words)
        if excepted & IN_AUTO and series >= V1_18:
            returning = replace(GOES_ON, words=words)
    if rule.cause == ACCURACY:
        returning = replace(GOES_ON, words="applies only in a mission or a hold")
    if returning.contingency is Contingency.RTL and rule.cause != BY_HAND:
        returning = replace(GOES_ON, words="it is returning already")
    differs = {} if returning == action else {FlightStage.RETURN: returning}
    returns_at = rule.returns_at(series)
    return Failsafe(rule.cause, rule.parameter, rule.value(parameters), action, differs, returns_at)


def _later(rule: FailsafeRule, action: FailsafeAction, parameters: Parameters) -> FailsafeAction:
    delay = parameters.get(DELAY, 5.0)
    waits = action.contingency in {Contingency.RTL, Contingency.LAND} and rule.cause not in WITHOUT_DELAY
    return replace(action, after_s=delay) if waits and delay > LEAST_DELAY else action
