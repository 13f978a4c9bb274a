"""Whether a version may pass a waypoint without reaching it, and then not return to it."""

from collections.abc import Iterator

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.commands import WAYPOINTS

SAME_HEIGHT = 0.001  # PX4 takes two heights for the same up to this difference [m]
NAMED = 5  # items in a message


def check_passing(forecast: Forecast) -> Iterator[Finding]:
    """An error for waypoints without a hold where the height changes next, and a warning for all others.

    PX4 from 1.18 on moves its vertical setpoint by itself: it oscillates where the next item has another height. A
    waypoint that is passed too high or too low is not reached, and nothing leads the vehicle back.
    """
    mission, program = forecast.mission, forecast.itinerary.program
    hold = mission.autopilot.waypoint_defaults(mission.firmware_version).hold
    if hold == 0.0:
        return
    climbing, level = list[int](), list[int]()
    for n, item in enumerate(mission.items):
        if item.command in WAYPOINTS and not item.params[0] > 0.0 and (onward := program.onward(n)) is not None:
            rise = abs(program.places[onward, 2] - program.places[n, 2])
            (level if rise <= SAME_HEIGHT else climbing).append(n + 1)
    hint = f"give each a hold of {hold:g} s (param1): there it stops and waits for its height"
    if climbing:
        words = f"{_named(climbing)}: {mission.autopilot.model} may pass at another height, and fly on without end"
        yield Finding("waypoint-passed", Severity.ERROR, climbing[0], words, hint)
    if level:
        words = f"{_named(level)}: {mission.autopilot.model} does not return to a waypoint that it passed"
        yield Finding("waypoint-may-be-passed", Severity.WARNING, level[0], words, hint)


def _named(items: list[int]) -> str:
    names = ", ".join(map(str, items[:NAMED])) + (" and others" if len(items) > NAMED else "")
    return f"{'items' if len(items) > 1 else 'item'} {names}"
