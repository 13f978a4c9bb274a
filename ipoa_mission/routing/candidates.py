"""Routes along a curve that an autopilot may fly quickly: of every density, and as it likes them.

ArduCopter slows down for every straight leg, PX4 for every corner. ArduCopter therefore also gets splines along the
gentlest line beside the curve, PX4 waypoints that it need not come near to.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ipoa_mission.forecast.timing.route_time import kinematics
from ipoa_mission.geometry import leg_lengths
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.relax import relaxed
from ipoa_mission.routing.resample import ON_THE_CURVE, corridor, stations
from ipoa_mission.routing.route import Route
from ipoa_mission.scenario import Scenario

NEAREST = 0.1  # two waypoints are never so near to each other [m]


@dataclass(frozen=True)
class RouteGrid:
    """Which choices of waypoints beside a curve are tried; `tolerance` is how far they may leave it."""

    straight_shares: tuple[float, ...] = (1.0, 0.6, 0.3, 0.1)  # of the tolerance, that straight legs leave the curve by
    aside_share: float = 0.6  # of that, by which a waypoint may lie beside the curve
    turn_radii: tuple[float, ...] = (0.0, 4.0, 7.0, 10.0, 14.0)  # where PX4 turns to the next [m]; 0: as it is set
    spline_shares: tuple[float, ...] = (
        0.8,
        0.4,
        0.0,
    )  # of the tolerance, that a spline's line may lie beside the curve
    spline_spacings: tuple[float, ...] = (40.0, 25.0, 12.0)  # of spline waypoints [m]
    most_splines: int = 200


GRID = RouteGrid()


def candidates(curve: Spline, scenario: Scenario) -> Iterator[Route]:
    """Routes beside the curve; their legs, and the chords of their curves, may still cut in on what it bends round."""
    guidance = scenario.vehicle.autopilot.guidance
    if guidance.flies_splines:
        yield from _splines(curve, scenario)
    drawn = set[bytes]()
    for share in GRID.straight_shares:
        width = share * scenario.route.tolerance
        beside = (-GRID.aside_share * width, 0.0, GRID.aside_share * width)
        for asides in (beside, ON_THE_CURVE) if share == 1.0 else (beside,):
            points = corridor(curve, width, asides, scenario.via_points)
            if points.tobytes() in drawn:
                continue
            drawn.add(points.tobytes())
            for radius in GRID.turn_radii if guidance.takes_radius and len(points) > 2 else GRID.turn_radii[:1]:
                yield Route(points, radius=radius)


def braking_length(scenario: Scenario) -> float:
    """In which ArduCopter comes to a stop on a curve, where it brakes by half of WPNAV_ACCEL [m]."""
    limits = kinematics(scenario.vehicle.autopilot, scenario.vehicle.autopilot_parameters())
    return scenario.vehicle.cruise_speed**2 / limits.accel


def _splines(curve: Spline, scenario: Scenario) -> Iterator[Route]:
    via = scenario.via_points
    for room in GRID.spline_shares:
        line = relaxed(curve, room * scenario.route.tolerance, via)
        length = float(leg_lengths(line).sum())
        brake = min(braking_length(scenario), length / 2)
        spacings = {
            max(spacing, length / GRID.most_splines) for spacing in GRID.spline_spacings if spacing < length / 2
        }
        for spacing in sorted(spacings, reverse=True):
            even = length / math.ceil(length / spacing)
            for last, on_curve in ((max(brake, even), True), (max(brake, even), False), (even, False)):
                points = stations(line, spacing, last, via)
                if leg_lengths(points).min() >= NEAREST:
                    yield Route(points, spline=True, brakes_on_curve=on_curve)
