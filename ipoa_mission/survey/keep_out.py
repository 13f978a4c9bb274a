"""What a survey flies round: obstacles that are not lower than the flight by their clearance, grown by what it needs.

The clearance is the promised one: the required distance, and how far flights of this autopilot lie beside their path.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import shapely

from ipoa_mission.forecast.deviation.kept_limits import NO_DEVIATION, DeviationBound, deviation_bound_of
from ipoa_mission.forecast.deviation.measured_law import law_of
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.outline import wider
from ipoa_mission.survey.sight import Sight
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.obstacles import Obstacle
from ipoa_mission.world.union import union_of

TIGHT_PLACES = 4.0  # at so many tight places the tube has room
SPARE = 0.05  # and so much more [m]
LOOKS = 7  # lines each way on which the ground round an obstacle is looked at
CORNERS = 16  # of a quarter of a circle round a corner
SIMPLER, SIMPLER_M = 0.05, 0.25  # outlines are wider at corners by so much, of the spacing and at most, to have fewer


def tube(scenario: Scenario) -> DeviationBound:
    """How far flights lie beside their path where it is straight, at some tight places."""
    chance = scenario.safety.chance
    if chance is None:
        return NO_DEVIATION
    law = law_of(scenario.vehicle.autopilot, scenario.wind.speed)
    rim = deviation_bound_of(law, chance)
    return DeviationBound(law.level.distance(chance / TIGHT_PLACES), rim.down, rim.up)


def keep_out(scenario: Scenario, sight: Sight, growth: Mapping[str, float]) -> Any | None:
    """What lines and ways keep out of, in plan; None where nothing is in the way.

    `growth`: by how much more some obstacles are to be kept away from [m], by name; those are flown round, not over.
    """
    air, rim = scenario.airspace, tube(scenario)
    distance = scenario.limits.obstacle_distance + SPARE
    shapes = [
        _grown(body, distance + rim.level + growth.get(body.name, 0.0), min(SIMPLER * sight.spacing, SIMPLER_M))
        for body in flown_round(scenario, sight, growth)
    ]
    if air.bounds.footprint is not None:
        inside = air.bounds.footprint.shape.buffer(-rim.level - SPARE - growth.get("bounds", 0.0))
        (west, south, *_), (east, north, *_) = air.bounds.lower, air.bounds.upper
        shapes.append(shapely.box(west, south, east, north).buffer(2 * scenario.bounds.margin).difference(inside))
    return union_of(shapes) if shapes else None


def flown_round(scenario: Scenario, sight: Sight, growth: Mapping[str, float]) -> list[Obstacle]:
    """The obstacles that are neither flown over nor under; those that have more room are not."""
    air, rim = scenario.airspace, tube(scenario)
    distance = scenario.limits.obstacle_distance + SPARE
    return [
        body for body in air.obstacles if body.name in growth or not _is_passed(body, sight, air.ground, distance, rim)
    ]


def _grown(body: Obstacle, by: float, most: float) -> Any:
    return wider(body.plan.buffer(by / math.cos(math.pi / 4 / CORNERS), quad_segs=CORNERS), most)


def _is_passed(body: Obstacle, sight: Sight, ground: Ground, distance: float, rim: DeviationBound) -> bool:
    (west, south, base), (east, north, top) = body.bounds.tolist()
    reach = max(sight.across, sight.along) / 2 + distance + rim.level
    grid = np.meshgrid(np.linspace(west - reach, east + reach, LOOKS), np.linspace(south - reach, north + reach, LOOKS))
    heights = ground(np.stack(grid, axis=-1).reshape(-1, 2))
    lowest, highest = float(heights.min()) + sight.least, float(heights.max()) + sight.least + sight.band
    return bool(top + distance + rim.down <= lowest or highest + distance + rim.up <= base)
