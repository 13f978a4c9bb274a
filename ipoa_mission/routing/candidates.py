"""Routes along a curve that an autopilot may fly quickly: of every density, and as it likes them.

ArduCopter slows down for every straight leg, PX4 for every corner. ArduCopter therefore also gets splines along the
gentlest line beside the curve, PX4 waypoints that it need not come near to.
"""

import math
from collections.abc import Iterator

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.geometry import leg_lengths
from ipoa_mission.planning.spline import Spline
from ipoa_mission.routing.relax import relaxed, stations
from ipoa_mission.routing.resample import ON_THE_CURVE, corridor
from ipoa_mission.routing.route import Route, push_clear
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.route import kinematics

SHARES = (1.0, 0.6, 0.3, 0.1)  # of the tolerance, that straight legs may leave the curve by
ASIDE = 0.6  # of that, by which a waypoint may lie beside the curve
RADII = (0.0, 4.0, 7.0, 10.0, 14.0)  # within which PX4 turns to the next waypoint [m]; 0: as its parameters say
ROOMS = (0.8, 0.4, 0.0)  # of the tolerance, that a spline's line may lie beside the curve
SPACINGS = (40.0, 25.0, 12.0)  # of spline waypoints [m]
MOST_SPLINES = 200
NEAREST = 0.1  # two waypoints are never so near to each other [m]


def candidates(curve: Spline, scenario: Scenario) -> Iterator[Route]:
    """Routes whose straight legs, or the chords of their curves, have been moved clear where that was possible."""
    is_ardupilot = scenario.vehicle.autopilot is Autopilot.ARDUPILOT
    routes = _splines(curve, scenario) if is_ardupilot else iter(())
    for route in routes:
        yield Route(push_clear(route.points, scenario), route.spline, route.brakes_on_curve)
    seen = set[bytes]()
    for share in SHARES:
        width = share * scenario.route.tolerance
        beside = (-ASIDE * width, 0.0, ASIDE * width)
        for asides in (beside, ON_THE_CURVE) if share == 1.0 else (beside,):
            points = push_clear(corridor(curve, width, asides, scenario.via_points), scenario)
            if points.tobytes() in seen or leg_lengths(points).min() < NEAREST:
                continue
            seen.add(points.tobytes())
            for radius in RADII[:1] if is_ardupilot or len(points) < 3 else RADII:
                yield Route(points, radius=radius)


def braking_length(scenario: Scenario) -> float:
    """In which ArduCopter comes to a stop on a curve, where it brakes by half of WPNAV_ACCEL [m]."""
    limits = kinematics(scenario.vehicle.autopilot, scenario.vehicle.autopilot_parameters())
    return scenario.vehicle.cruise_speed**2 / limits.accel


def _splines(curve: Spline, scenario: Scenario) -> Iterator[Route]:
    via = scenario.via_points
    for room in ROOMS:
        line = relaxed(curve, room * scenario.route.tolerance, via)
        length = float(leg_lengths(line).sum())
        brake = min(braking_length(scenario), length / 2)
        spacings = {max(spacing, length / MOST_SPLINES) for spacing in SPACINGS if spacing < length / 2}
        for spacing in sorted(spacings, reverse=True):
            even = length / math.ceil(length / spacing)
            for last, on_curve in ((max(brake, even), True), (max(brake, even), False), (even, False)):
                points = stations(line, spacing, last, via)
                if leg_lengths(points).min() >= NEAREST:
                    yield Route(points, spline=True, brakes_on_curve=on_curve)
