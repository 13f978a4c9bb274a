"""Write docs/failsafes.md: what each vehicle does when something fails, by its parameters.

python -m tools.generate.failsafes
"""

from ipoa_mission.vehicles.autopilot import Autopilot, registered
from ipoa_mission.vehicles.failsafe import FailsafeAction, FailsafeRule
from tools import REPOSITORY, command_line

PAGE = REPOSITORY / "docs" / "failsafes.md"
HEAD = """\
# Failsafes

What each vehicle does by itself when something fails, and what can be ordered, as read in its firmware's sources; made
from the code by `python -m tools.generate.failsafes`. From Python: `autopilot.failsafes(parameters, version)`.

`rtl` returns as its return parameters say, `land` lands where it is, `smart_rtl` flies back along the way flown, `hold`
brakes and stays, `land_start` goes to the mission's own landing, `terminate` stops the motors, `continue` goes on.
`unknown` is what is not modeled. After "or" stands what is tried where the first is not to be had. What is marked
"needs" is looked for only where one of these is above 0.
"""
NOTES = {
    "ardupilot": """\
* Of the route and the take-off. Where the mission comes down to land, bit 3 of `FS_OPTIONS` makes every battery, radio
  and ground station failsafe `land`; else a `rtl` climbs away again.
* Bits 0 and 1 of `FS_OPTIONS`: a mission goes on without radio control, without a ground station.
* A failsafe's `land` holds for 4 s first, but for a fence's. Armed on the ground a failsafe disarms.
* A landing switches the floor of the fence (`FENCE_ALT_MIN`) off.
* `smart_rtl` needs `SRTL_POINTS` and `SRTL_ACCURACY` above 0.
* Once a low battery has acted, a critical one does so only if its action is as urgent: 5, 1, 2, 4, 3, 0; then 6 and 7,
  which so do nothing after a low battery with 0.
* A landing needs no terrain data.
* Not here: advanced failsafe (`AFS_*`), scripts.
""",
    "px4": """\
* Of all stages of a mission. In a return a `rtl` changes nothing, and bit 0 of `COM_RCL_EXCEPT` and `COM_DLL_EXCEPT`,
  by which a mission goes on, does not count (bit 1 does, since 1.18).
* Before a `rtl` or `land` it holds for `COM_FAIL_ACT_T`, but where its position is inaccurate or lost, or traffic near.
* Of several causes the worst counts.
* Without radio control nothing follows with `COM_RC_IN_MODE` 4, or where there was none when it was armed.
* Not here: VTOL, offboard, what happens in the first seconds after arming.
""",
}


def page() -> str:
    """The text of the page."""
    return "\n".join((HEAD, *(_of(one) for one in registered() if one.failsafe_rules)))


def _of(autopilot: Autopilot) -> str:
    rows = "\n".join(_row(rule) for rule in autopilot.failsafe_rules)
    table = f"| cause | parameter | its default | what follows | any other value |\n|---|---|---|---|---|\n{rows}\n"
    return f"## {autopilot.model} {autopilot.newest}\n\n{NOTES[autopilot.name]}\n{table}"


def _row(rule: FailsafeRule) -> str:
    cause = rule.cause + (f"; needs {' or '.join(f'`{name}`' for name in rule.needs)}" if rule.needs else "")
    cause += f"; since {_series(rule.since)}" if rule.since > (0, 0) else ""
    cause += f"; before {_series(rule.until)}" if rule.until < (99, 0) else ""
    if not rule.parameter:
        return f"| {cause} | | | {rule.other} | |"
    follows = "<br>".join(f"{value}: {_words(answer)}" for value, answer in rule.answers.items())
    return f"| {cause} | `{rule.parameter}` | {rule.default:.9g} | {follows} | {rule.other} |"


def _words(answer: FailsafeAction) -> str:
    return f"{answer}; since {_series(answer.since)}" if answer.since > (0, 0) else str(answer)


def _series(series: tuple[int, int]) -> str:
    return f"{series[0]}.{series[1]}"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
