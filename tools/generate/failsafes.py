"""Write docs/failsafes.md: the action of each vehicle's failsafes, by its parameters.

python -m tools.generate.failsafes
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TypeAlias

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.failsafe import Cause, Contingency, FailsafeAction, FailsafeRule
from tools import REPOSITORY, command_line

Fallbacks: TypeAlias = Mapping[Contingency, tuple[Contingency, ...]]
PAGE = REPOSITORY / "docs" / "failsafes.md"
HEAD = """\
# Failsafes

Actions of each vehicle when something fails, or by order, read in its firmware's sources. Written by
`python -m tools.generate.failsafes`. In Python: `autopilot.failsafes(parameters, version)`.

`rtl` returns by its return parameters, `land` lands in place, `smart_rtl` flies back along the flown path. `hold`
brakes and stays. `land_start` flies to the mission's own landing, `terminate` stops the motors, `continue` goes on.
`unknown` is not modeled. If an action is not available, its fallbacks follow; a row names others ("or"). A cause with
"needs" is checked if one of these parameters is above 0.
"""
NOTES = {
    "ardupilot": """\
* The table is for the route and the take-off. During the landing of a mission, bit 3 of `FS_OPTIONS` makes every
  battery, radio and ground station failsafe `land`; otherwise a `rtl` climbs away again.
* With bits 0 and 1 of `FS_OPTIONS` a mission continues without radio control, or without a ground station.
* Before a failsafe's `land` it holds for 4 s, except for a fence breach. Armed on the ground a failsafe disarms.
* A landing disables the floor of the fence (`FENCE_ALT_MIN`).
* `smart_rtl` needs `SRTL_POINTS` and `SRTL_ACCURACY` above 0.
* After a low battery has acted, a critical one acts only if its action is as urgent: 5, 1, 2, 4, 3, 0; then 6 and 7.
  Actions 6 and 7 rank below 0: without effect after a low battery with action 0.
* A landing needs no terrain data.
* Not covered: advanced failsafe (`AFS_*`), scripts.
""",
    "px4": """\
* During a return a `rtl` changes nothing, and bit 0 of `COM_RCL_EXCEPT` and `COM_DLL_EXCEPT`, which continues a
  mission, does not apply (bit 1 does, since 1.18).
* Before a `rtl` or `land` it holds for `COM_FAIL_ACT_T`, except for an inaccurate or lost position, or traffic near.
* Of several causes the most severe action counts.
* A lost radio control has no effect with `COM_RC_IN_MODE` 4, or if it was lost at arming.
* Not covered: VTOL, offboard, the first seconds after arming.
""",
}


def page() -> str:
    return "\n".join((HEAD, *(_of(autopilot) for autopilot in registered() if autopilot.failsafe_profile.rules)))


def _of(autopilot: Autopilot) -> str:
    by_hand = [rule.usual.contingency for rule in autopilot.failsafe_profile.rules if rule.cause == Cause.BY_HAND]
    rules = [rule for rule in autopilot.failsafe_profile.rules if rule.cause != Cause.BY_HAND]
    fallbacks = _usual_fallbacks(rules)
    rows = "\n".join(_row(rule, fallbacks) for rule in rules)
    table = f"| cause | parameter | its default | value: action | any other value |\n|---|---|---|---|---|\n{rows}\n"
    then = "; ".join(f"`{first}`: {_in_code(others)}" for first, others in fallbacks.items())
    notes = f"{NOTES[autopilot.name]}\nFallbacks, in turn: {then}.\n"
    return f"## {autopilot.model} {autopilot.newest}\n\n{notes}\n{table}\nBy hand: {_in_code(by_hand)}.\n"


def _usual_fallbacks(rules: Iterable[FailsafeRule]) -> dict[Contingency, tuple[Contingency, ...]]:
    counts = dict[Contingency, Counter[tuple[Contingency, ...]]]()
    for rule in rules:
        for action in (*rule.actions.values(), rule.usual):
            counts.setdefault(action.contingency, Counter())[action.fallbacks] += 1
    usual = {first: count.most_common(1)[0][0] for first, count in counts.items()}
    return {first: usual[first] for first in Contingency if usual.get(first) and first is not Contingency.UNKNOWN}


def _row(rule: FailsafeRule, fallbacks: Fallbacks) -> str:
    cause = rule.cause + (f"; needs {' or '.join(f'`{name}`' for name in rule.needs)}" if rule.needs else "")
    cause += f"; since {_series(rule.since)}" if rule.since > (0, 0) else ""
    cause += f"; before {_series(rule.until)}" if rule.until < (99, 0) else ""
    other = _words(rule.usual, fallbacks)
    if not rule.parameter:
        return f"| {cause} | | | {other} | |"
    values = dict[str, list[str]]()
    for value, action in rule.actions.items():
        values.setdefault(_words(action, fallbacks), []).append(str(value))
    follows = "<br>".join(f"{', '.join(same)}: {words}" for words, same in values.items())
    return f"| {cause} | `{rule.parameter}` | {rule.default:.9g} | {follows} | {other} |"


def _words(action: FailsafeAction, fallbacks: Fallbacks) -> str:
    """Name the fallbacks only where they are not the usual ones."""
    usual = fallbacks.get(action.contingency, ())
    words = str(replace(action, fallbacks=()) if action.fallbacks == usual else action)
    if usual and not action.fallbacks:
        words = words.replace(action.contingency, f"{action.contingency} without a fallback", 1)
    return f"{words}; since {_series(action.since)}" if action.since > (0, 0) else words


def _in_code(words: Iterable[str]) -> str:
    return ", ".join(f"`{word}`" for word in words)


def _series(series: tuple[int, int]) -> str:
    return f"{series[0]}.{series[1]}"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
