import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.checks.numbered_finding import item_of, numbered
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.deviation.law import not_measured
from ipoa_mission.forecast.deviation.promise import Kept, Promise
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.copter_circle import circle_turn
from ipoa_mission.forecast.itinerary.program import as_flown, program_of
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario

LIMIT_WORDS = {"obstacles": "to {}", "ground": "above the ground", "ceiling": "above the ground", "bounds": "inside {}"}


def check_clearance(mission: Mission, scenario: Scenario, promise: Promise) -> Iterator[Finding]:
    """Report each limit that too few flights keep.

    It is a warning off the way, and where the scenario leaves less room. Contact is always an error.
    """
    if promise.confidence is not None and (why := not_measured(mission.autopilot, scenario.wind.strongest)):
        yield Finding("wind-not-measured", Severity.WARNING, None, why)
    for kept in promise.broken:
        item = item_of(mission, kept.item)
        touches = kept.limit == "obstacles" and kept.kept < scenario.vehicle.radius
        report = item.error if kept.forbids or touches else item.warning
        yield report("flights-too-near", f"{_where(kept)}: {kept.words(promise.confidence)}")


def _where(kept: Kept) -> str:
    east, north, up = kept.place
    part = f"{kept.part}, " if kept.part else ""
    return f"{part}{LIMIT_WORDS[kept.limit].format(kept.to)} at east {east:.1f}, north {north:.1f}, up {up:.1f} m"


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


HEIGHT_TOLERANCE = 0.001  # of PX4 between equal heights [m]
NAMED_ITEMS = 5  # in a message


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
    climbing = [seq for seq, rise in rises.items() if not rise <= HEIGHT_TOLERANCE]
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
    names = ", ".join(map(str, items[:NAMED_ITEMS])) + (" and others" if len(items) > NAMED_ITEMS else "")
    return f"{'items' if len(items) > 1 else 'item'} {names}"


def check_passed_over(forecast: Forecast) -> Iterator[Finding]:
    things = [thing for thing in forecast.world.passed_over if thing.may_stand and not shapely.is_empty(thing.shape)]
    for code in sorted({thing.code for thing in things}):
        yield from _near(forecast, [thing for thing in things if thing.code == code], code)


def _near(forecast: Forecast, things: Sequence[Any], code: str) -> Iterator[Finding]:
    scenario = forecast.world
    tree = shapely.STRtree([thing.shape for thing in things])
    required = scenario.limits.obstacle_distance + scenario.route.tolerance
    for leg in forecast.legs:
        way = shapely.LineString(leg.points[:, :2])
        near = [things[i] for i in tree.query(way, "dwithin", required + leg.stray)]
        if near:
            distances = [float(shapely.distance(way, thing.shape)) for thing in near]
            first, distance = near[int(np.argmin(distances))], min(distances)
            others = f" (and {len(near) - 1} more such)" if len(near) > 1 else ""
            where = f"passes {distance:.1f} m from" if distance > 0 else "crosses"
            words = f"{where} {first.name} on {first.file}, {first.reason}{others}"
            item = item_of(forecast.mission, leg.seq)
            sections = [n for n, section in enumerate(scenario.maps) if section.file.name == first.file]
            heights = tuple(Remedy(("maps", n, key), value) for key, value in first.heights for n in sections)
            if code == "not-read":
                yield item.error("not-read", words, first.remedy, heights)
            else:
                yield item.error("map-not-understood", words, first.remedy, heights)
