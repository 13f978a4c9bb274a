"""Compute the time from the first place to the last waypoint."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.bound import Kinematics, least_time
from ipoa_mission.forecast.timing.flight_model import FlightModel
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector, arc_lengths, leg_lengths

ROUTE_STARTS = WAYPOINTS | {Command.NAV_TAKEOFF}
PATH_STEP, SMOOTHED_STEPS = 1.0, 5  # [m], averaged over
MAX_STEPS = 10_000


@dataclass(frozen=True)
class RouteTime:
    """`seconds` of the route, and the `least` within the same limits [s]; NaN without a route.

    An autopilot may exceed its own limits; then its time is the least.
    """

    seconds: float
    path: Points = field(repr=False, compare=False)
    limits: Kinematics | None = field(repr=False, compare=False)

    @cached_property
    def least(self) -> float:
        return math.nan if self.limits is None else min(least_time(self.path, self.limits).seconds, self.seconds)

    @property
    def ratio(self) -> float:
        return self.seconds / self.least


NO_ROUTE = RouteTime(math.nan, np.zeros((0, 3)), None)


def kinematics(autopilot: Autopilot, parameters: Parameters, speed: float | None = None) -> Kinematics:
    return autopilot.part(FlightModel).kinematics(parameters, speed)


def route_time(
    route: Itinerary, done: Sequence[float] | Vector, track: Track, autopilot: Autopilot, parameters: Parameters
) -> RouteTime:
    ends = [n for n, visit in enumerate(route.visits) if visit.item.command in WAYPOINTS]
    starts = [n for n, visit in enumerate(route.visits) if visit.item.command in ROUTE_STARTS]
    if not ends or starts[0] == ends[-1]:
        return NO_ROUTE
    begin, end = float(done[starts[0]]), float(done[ends[-1]])
    standard = kinematics(autopilot, parameters).speed
    limits = kinematics(autopilot, parameters, _most_asked(route, ends[0], ends[-1], standard))
    path = _smoothed(track.between(begin, end).points)
    if len(path) < 2:
        return NO_ROUTE
    return RouteTime(end - begin, path, limits)


def _most_asked(route: Itinerary, first: int, last: int, standard: float) -> float:
    """Return the highest level speed in force between two visits [m/s]; the one before counts as well."""
    asked = [
        (n, visit.item.params[1])
        for n, visit in enumerate(route.visits[:last])
        if visit.item.command == Command.DO_CHANGE_SPEED and visit.item.params[0] < 2 and visit.item.params[1] > 0
    ]
    begun = standard if not asked or asked[0][0] > first else 0.0
    return max([begun, *(speed for _, speed in asked)])


def _smoothed(path: Points) -> Points:
    path = path[np.concatenate([[True], leg_lengths(path) > 1e-6])] if len(path) > 1 else path
    if len(path) < 2:
        return path
    traveled = arc_lengths(path)
    stops = np.linspace(0.0, traveled[-1], min(max(2, math.ceil(traveled[-1] / PATH_STEP) + 1), MAX_STEPS))
    even = np.column_stack([np.interp(stops, traveled, axis) for axis in path.T])
    if len(even) <= SMOOTHED_STEPS:
        return even[[0, -1]]
    wide = np.pad(even, ((SMOOTHED_STEPS // 2, SMOOTHED_STEPS // 2), (0, 0)), mode="edge")
    middle = np.column_stack(
        [np.convolve(axis, np.full(SMOOTHED_STEPS, 1 / SMOOTHED_STEPS), "valid") for axis in wide.T]
    )
    middle[[0, -1]] = even[[0, -1]]
    return middle
