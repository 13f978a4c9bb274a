from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from ipoa_mission.checks.numbered_finding import item_of
from ipoa_mission.errors import Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.deviation.law import not_measured
from ipoa_mission.forecast.deviation.promise import Kept, Promise
from ipoa_mission.forecast.forecast import Forecast
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
