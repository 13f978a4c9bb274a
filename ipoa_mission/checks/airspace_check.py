"""Check distances to obstacles, ground and bounds."""

import math
from collections.abc import Iterator, Sequence
from itertools import takewhile
from typing import Any

import numpy as np
import shapely

from ipoa_mission.checks.numbered_finding import item_of, leg_name
from ipoa_mission.errors import Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingency.shortfalls import clear_in, heights_above
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, KeptLimit
from ipoa_mission.forecast.deviation.law import not_measured
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Phase
from ipoa_mission.forecast.leg_limits import ROUNDING, broken_limits
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario


def remedy(forecast: Forecast) -> tuple[str, tuple[Remedy, ...]]:
    """Return a hint and changes of the scenario that make the way home clear.

    Both name the lowest return altitude within the bounds, in steps of 5 m, that keeps the required clearance.
    Near home there may be none: an autopilot does not climb to it there.
    """
    others = 'plan the way home too, with the goal over home and this one under via; or land: route.ending = "land"'
    mission, scenario = forecast.mission, forecast.world
    by = mission.autopilot.parameter_table.return_height
    is_clear, land = clear_in(scenario), Remedy(("route", "ending"), "land")
    for altitude in takewhile(lambda height: height <= scenario.airspace.bounds.upper[2], heights_above(0.0)):
        name, value = by.name, by.spelled(altitude)
        if is_clear(Forecast(mission.with_parameters({name: value}), scenario).ways_home):
            hint = f"{name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]; or {others}"
            return hint, (Remedy(("vehicle", "parameters", name), float(round(value))), land)
    return others, (land,)


def check_airspace(forecast: Forecast) -> Iterator[Finding]:
    """Report a home elsewhere, then each broken limit of each leg.

    The planner chooses no climb, way home or landing: there it is a warning, and contact an error.
    """
    mission, scenario = forecast.mission, forecast.world
    offset = np.abs(scenario.frame.local(mission.home))
    if offset.max() > 1.0:  # [m]
        message = f"home: lies {np.linalg.norm(offset):.1f} m from the scenario's home: heights above home differ"
        yield Finding("home-differs", Severity.WARNING, 0, message)
    reported = set[str]()
    for leg in forecast.legs:
        for check in broken_limits(leg, scenario):
            words = check.words()
            begins = np.linalg.norm(np.array(check.nearest.place) - leg.points[0]) < ROUNDING["m"]
            if words in reported and begins:
                continue
            reported |= {words} if leg.phase is Phase.CRUISE else set()
            item, message = item_of(mission, leg.seq), f"{leg_name(leg)}: {words}"
            contact = scenario.vehicle.radius - ROUNDING["m"] if check.limit in ("obstacles", "ground") else -math.inf
            if leg.phase is not Phase.CRUISE and not check.nearest.distance < contact:
                yield item.warning("leg-too-near", message)
            else:
                hint, remedies = remedy(forecast) if leg.phase is Phase.RETURN else (None, ())
                yield item.error("leg-too-near", message, hint, remedies)


def check_clearance(mission: Mission, scenario: Scenario, guarantee: ClearanceGuarantee) -> Iterator[Finding]:
    """Report each limit that too few flights keep.

    It is a warning off the way, and where the scenario leaves less room. Contact is always an error.
    """
    if guarantee.confidence is not None and (why := not_measured(mission.autopilot, scenario.wind.strongest)):
        yield Finding("wind-not-measured", Severity.WARNING, None, why)
    for limit in guarantee.broken:
        item = item_of(mission, limit.item)
        touches = limit.limit == "obstacles" and limit.guaranteed < scenario.vehicle.radius
        report = item.error if limit.forbids or touches else item.warning
        yield report("flights-too-near", f"{_where(limit)}: {limit.words(guarantee.confidence)}")


def _where(limit: KeptLimit) -> str:
    east, north, up = limit.place
    part = f"{limit.part}, " if limit.part else ""
    words = {"obstacles": f"to {limit.to}", "bounds": f"inside {limit.to}"}.get(limit.limit, "above the ground")
    return f"{part}{words} at east {east:.1f}, north {north:.1f}, up {up:.1f} m"


def check_passed_over(forecast: Forecast) -> Iterator[Finding]:
    things = [
        thing for thing in forecast.world.passed_over if thing.may_be_obstacle and not shapely.is_empty(thing.shape)
    ]
    for code in sorted({thing.code for thing in things}):
        yield from _near(forecast, [thing for thing in things if thing.code == code], code)


def _near(forecast: Forecast, things: Sequence[Any], code: str) -> Iterator[Finding]:
    scenario = forecast.world
    tree = shapely.STRtree([thing.shape for thing in things])
    required = scenario.limits.obstacle_distance + scenario.route.tolerance
    for leg in forecast.legs:
        line = shapely.LineString(leg.points[:, :2])
        near = [things[i] for i in tree.query(line, "dwithin", required + leg.stray)]
        if near:
            distances = [float(shapely.distance(line, thing.shape)) for thing in near]
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
