"""Compute the plan area that survey lines keep out of."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import shapely

from ipoa_mission.forecast.deviation.kept_limits import NO_DEVIATION, DeviationBound, deviation_bound_of
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.geometry import union_of
from ipoa_mission.ground import Ground
from ipoa_mission.scenario import Scenario
from ipoa_mission.survey.free import wider
from ipoa_mission.survey.sight import Sight
from ipoa_mission.world.obstacles import Obstacle

TIGHT_PLACES = 4.0  # share the chance of a deviation
SPARE = 0.05  # [m]


def survey_bound(scenario: Scenario) -> DeviationBound:
    chance = scenario.safety.chance
    if chance is None:
        return NO_DEVIATION
    law = law_of(scenario.vehicle.autopilot, scenario.wind.speed)
    bound = deviation_bound_of(law, chance)
    return DeviationBound(law.level.distance(chance / TIGHT_PLACES), bound.down, bound.up)


def keep_out(scenario: Scenario, sight: Sight, growth: Mapping[str, float]) -> Any | None:
    """Return the geometry to keep out of, in plan. `growth` [m] adds clearance by obstacle name, flown round."""
    air, bound = scenario.airspace, survey_bound(scenario)
    distance = scenario.limits.obstacle_distance + SPARE
    max_widening, segments = min(0.05 * sight.spacing, 0.25), 16  # [m], for fewer corners; of a quarter circle
    shapes = list[Any]()
    for body in flown_round(scenario, sight, growth):
        away = (distance + bound.level + growth.get(body.name, 0.0)) / math.cos(math.pi / 4 / segments)
        shapes.append(wider(body.horizontal_shape.buffer(away, quad_segs=segments), max_widening))
    if air.bounds.footprint is not None:
        inside = air.bounds.footprint.shape.buffer(-bound.level - SPARE - growth.get("bounds", 0.0))
        (west, south, *_), (east, north, *_) = air.bounds.lower, air.bounds.upper
        shapes.append(shapely.box(west, south, east, north).buffer(2 * scenario.bounds.margin).difference(inside))
    return union_of(shapes) if shapes else None


def flown_round(scenario: Scenario, sight: Sight, growth: Mapping[str, float]) -> list[Obstacle]:
    """Return the obstacles flown neither over nor under, or grown."""
    air, bound = scenario.airspace, survey_bound(scenario)
    distance = scenario.limits.obstacle_distance + SPARE
    return [
        body
        for body in air.obstacles
        if body.name in growth or not _is_passed(body, sight, air.ground, distance, bound)
    ]


def _is_passed(body: Obstacle, sight: Sight, ground: Ground, distance: float, bound: DeviationBound) -> bool:
    (west, south, base), (east, north, top) = body.bounds.tolist()
    reach = max(sight.across, sight.along) / 2 + distance + bound.level
    grid = np.meshgrid(np.linspace(west - reach, east + reach, num=7), np.linspace(south - reach, north + reach, num=7))
    heights = ground(np.stack(grid, axis=-1).reshape(-1, 2))
    lowest, highest = float(heights.min()) + sight.least, float(heights.max()) + sight.least + sight.band
    return bool(top + distance + bound.down <= lowest or highest + distance + bound.up <= base)
