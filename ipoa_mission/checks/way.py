"""Check items that are never reached, or after which the flight is unknown."""

import math
from collections.abc import Iterator

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.checks.numbered_finding import item_of, numbered
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.copter_circle import circle_turn


def check_way(forecast: Forecast) -> Iterator[Finding]:
    """Report each, and a circle flown in the other direction."""
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
    for at in numbered(mission):
        radius = at.item.params[2]
        if at.item.command != Command.NAV_LOITER_TURNS or radius == 0.0 or not math.isfinite(radius):
            continue
        turn = circle_turn(at.item)
        flown = mission.autopilot.circle(parameters, abs(radius), turn, None, mission.firmware_version)
        if flown is not None and flown.sense * radius < 0.0:
            sense = "clockwise" if flown.sense > 0.0 else "counterclockwise"
            words = f"{firmware} flies it {sense}: the sign of CIRCLE_RATE counts, and that of the radius does not"
            yield at.warning("circle-sense", words)
