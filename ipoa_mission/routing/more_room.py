"""Where a path must keep farther away than the scenario asks, so that what is flown along it keeps what is asked."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.forecast.deviation.kept_limits import DeviationBound
from ipoa_mission.forecast.deviation.room import grown, shrunk
from ipoa_mission.forecast.shortfalls import Shortfall
from ipoa_mission.geometry import Vector
from ipoa_mission.planning.path_problem import PathProblem, PathTask, problem_of
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Cylinder, Obstacle

MORE = 1.15  # times what is missing
A_LITTLE = 0.03  # and so much [m]
AS_NEAR = 0.3  # an obstacle is moved away from that is farther than the nearest by what is missing and so much [m]
LOOK_EVERY = 0.5  # along a curve [m]
EVEN = DeviationBound(1.0, 1.0, 1.0)  # as far up and down as to the sides


@dataclass(frozen=True, eq=False)
class Needs:
    """By how much obstacles (n,) must be larger, and limits of height and bounds tighter [m].

    `columns`, `towers`: so much wider than obstacles (n,) is what is kept free below them, down to the ground, and
    above them, up to the highest bound; negative: nothing.
    """

    growth: Vector
    columns: Vector
    towers: Vector
    above: float = 0.0
    below: float = 0.0
    inside: float = 0.0

    def more(self, attempt: Attempt, scenario: Scenario) -> "Needs":
        """What is needed beside this by what an attempt is short of."""
        promise, curve = attempt.promise, attempt.plan.curve
        short = {kept.limit: -kept.slack * MORE + A_LITTLE for kept in promise.broken if kept.on_the_way}
        wanted = [(one.to, short["obstacles"]) for one in promise.broken if one.on_the_way and one.limit == "obstacles"]
        aside = [one for one in attempt.short if one.body and not one.overhead and not one.comes_down]
        wanted += [(one.body, one.missing * MORE + A_LITTLE) for one in aside]
        growth = self.growth
        spots = curve.sample(max(2, int(curve.length / LOOK_EVERY)))
        for name, missing in wanted:
            growth = np.maximum(growth, _growth(spots, name, missing, scenario))
        return Needs(
            growth,
            _wider(self.columns, (one for one in attempt.short if one.overhead), scenario),
            _wider(self.towers, (one for one in attempt.short if one.comes_down), scenario),
            self.above + short.get("ground", 0.0),
            self.below + short.get("ceiling", 0.0),
            self.inside + short.get("bounds", 0.0),
        )

    def room(self, roomy: PathTask, scenario: Scenario, gaps: bool) -> PathProblem:
        """The scenario with the room that `roomy` has and what is needed beside; with `gaps` it closes no gap.

        Nothing closes in on a place that the scenario gives.
        """
        air = roomy.airspace
        bodies = tuple(
            _upright(air, wide, column, tower) if max(column, tower) >= 0.0 else body
            for body, wide, column, tower in zip(
                grown(roomy, scenario, self.growth, EVEN, gaps),
                air.obstacles,
                self.columns.tolist(),
                self.towers.tolist(),
                strict=True,
            )
        )
        inside = DeviationBound(self.inside, self.inside, self.inside)
        bounds = shrunk(air.bounds, scenario.places, inside) if self.inside else air.bounds
        return problem_of(roomy).tightened(self.above, self.below, Airspace(bounds, air.terrain, bodies))


def _wider(rooms: Vector, short: Iterable[Shortfall], scenario: Scenario) -> Vector:
    """What is kept free below or above obstacles (n,), wider by what is missing there; at first as wide as they are."""
    number = {body.name: n for n, body in enumerate(scenario.airspace.obstacles)}
    wider = rooms.copy()
    for name, missing in {one.body: one.missing for one in short}.items():
        wide = rooms[number[name]]
        wider[number[name]] = 0.0 if wide < 0.0 else wide + missing * MORE + A_LITTLE
    return wider


def _upright(air: Airspace, body: Obstacle, column: float, tower: float) -> Obstacle:
    """The body, as wide as the wider of both, with all below it if it has a column, and all above if a tower."""
    (west, south, base), (east, north, top) = body.bounds
    floor = min(air.bounds.lower[2], base) if column >= 0.0 else base
    ceiling = max(air.bounds.upper[2], top) if tower >= 0.0 else top
    wider = max(column, tower)
    if body.column is not None:
        return body.grown(wider, base - floor, ceiling - top)
    radius = max(east - west, north - south) / 2 + wider
    return Cylinder(body.name, (west + east) / 2, (south + north) / 2, radius, floor, ceiling)


def _growth(spots: np.ndarray, name: str, missing: float, scenario: Scenario) -> Vector:
    """By how much obstacles (n,) must be larger for a path of those spots (k, 3) to be `missing` [m] farther away."""
    bodies, required = scenario.airspace.obstacles, scenario.limits.obstacle_distance
    reach = {body.name: n for n, body in enumerate(bodies)}
    away = np.full(len(bodies), np.inf)
    for body, _, distance in scenario.airspace.near(spots, required + 4 * missing + 10.0):
        away[reach[body.name]] = min(away[reach[body.name]], float(distance.min()))
    nearest = away[reach[name]] if name in reach and np.isfinite(away[reach[name]]) else float(away.min())
    return np.where(away <= nearest + missing + AS_NEAR, np.maximum(away + missing - required, 0.0), 0.0)


def a_little(scenario: Scenario) -> Needs:
    """What the predicted path alone needs: it is seen by straight legs that stand for it."""
    none = nothing(scenario)
    return replace(none, growth=none.growth + 2 * A_LITTLE, above=2 * A_LITTLE)


def nothing(scenario: Scenario) -> Needs:
    """No need of more but, where it may land by choice and that is planned, to stay aside from what is below."""
    none, vehicle = np.full(len(scenario.airspace.obstacles), -1.0), scenario.vehicle
    failsafes = vehicle.autopilot.failsafes(vehicle.autopilot_parameters(), vehicle.version)
    lands = scenario.safety.returns == "planned" and any(one.lands_by_choice for one in failsafes)
    return Needs(np.zeros_like(none), none, np.zeros_like(none) if lands else none)
