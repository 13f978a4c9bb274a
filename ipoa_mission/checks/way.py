"""Report items after which the flight is unknown, circles of another sense, and waypoints that may be passed."""

import math
from collections.abc import Iterator

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.checks.numbered_finding import item_of, numbered_items
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.copter_curves import circle_turn
from ipoa_mission.forecast.itinerary.program import as_flown, program_of


def check_way(forecast: Forecast) -> Iterator[Finding]:
    mission = forecast.given
    firmware = mission.autopilot.firmware(mission.firmware_version)
    for unknown in forecast.unknown:
        at, words = item_of(mission, unknown.seq), f"{unknown.why}; the clearance is unknown"
        if not firmware.takes(at.item.command) or at.item.command in firmware.never_flown:
            continue
        match unknown.code:
            case "jump-flown-elsewhere":
                yield at.error("jump-flown-elsewhere", words, unknown.hint)
            case "never-reached":
                yield at.error("never-reached", words, unknown.hint)
            case _:
                yield at.error("way-unknown", words, unknown.hint)
    parameters = mission.autopilot.complete(mission.parameters, mission.firmware_version)
    for at in numbered_items(mission):
        radius = at.item.params[2]
        if at.item.command != Command.NAV_LOITER_TURNS or radius == 0.0 or not math.isfinite(radius):
            continue
        turn = circle_turn(at.item)
        flown = mission.autopilot.circle(parameters, abs(radius), turn, None, mission.firmware_version)
        if flown is not None and flown.sense * radius < 0.0:
            sense = "clockwise" if flown.sense > 0.0 else "counterclockwise"
            words = f"{firmware} flies it {sense}: the sign of CIRCLE_RATE counts, and that of the radius does not"
            yield at.warning("circle-sense", words)


def check_passing(forecast: Forecast) -> Iterator[Finding]:
    """Report an error for waypoints without a hold before a change of height, and a warning for all others.

    PX4 from 1.18 on moves its vertical setpoint separately: it oscillates, and does not return to a waypoint passed too
    high or too low.
    """
    mission = forecast.mission
    hold = mission.autopilot.waypoint_defaults(mission.firmware_version).hold
    if hold == 0.0:
        return
    rises = _rises(forecast)
    climbing = [seq for seq, rise in rises.items() if not rise <= 0.001]  # [m] of PX4
    level = [seq for seq in rises if seq not in climbing]
    hint = f"give each a hold of {hold:g} s (param1): the vehicle stops there and waits for its height"
    if climbing:
        words = f"{_named(climbing)}: {mission.autopilot.model} may pass at another height, and fly on without end"
        yield Finding("waypoint-passed", Severity.ERROR, climbing[0], words, hint)
    if level:
        words = f"{_named(level)}: {mission.autopilot.model} does not return to a waypoint that it passed"
        yield Finding("waypoint-may-be-passed", Severity.WARNING, level[0], words, hint)


def _rises(forecast: Forecast) -> dict[int, float]:
    """Return the greatest change of height [m] after each waypoint."""
    mission = forecast.mission
    try:
        program, seqs = forecast.itinerary.program, [visit.seq for visit in forecast.itinerary.visits]
    except BadInput:
        program = program_of(mission, as_flown(mission).items)
        seqs = list(range(1, len(mission.items) + 1))
    rises: dict[int, float] = {}
    for n, (seq, item) in enumerate(zip(seqs, program.items, strict=True)):
        if item.command in WAYPOINTS and not item.params[0] > 0.0 and (onward := program.onward(n)) is not None:
            rise = abs(float(program.places[onward, 2] - program.places[n, 2]))
            rises[seq] = max(rise, rises.get(seq, 0.0))
    return dict(sorted(rises.items()))


def _named(items: list[int]) -> str:
    names = ", ".join(map(str, items[:5])) + (" and others" if len(items) > 5 else "")
    return f"{'items' if len(items) > 1 else 'item'} {names}"
