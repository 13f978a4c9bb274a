"""Check the plane distance to skipped map features."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from ipoa_mission.checks.numbered_finding import item_of
from ipoa_mission.errors import Remedy
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast


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
