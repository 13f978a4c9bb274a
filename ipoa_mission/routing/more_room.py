"""Where a path must keep farther away than the scenario asks, so that what is flown along it keeps what is asked."""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.forecast.tube.limits import Rim
from ipoa_mission.forecast.tube.room import grown, shrunk
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
EVEN = Rim(1.0, 1.0, 1.0)  # as far up and down as to the sides


@dataclass(frozen=True, eq=False)
class Needs:
    """By how much obstacles (n,) must be larger, and limits of height and bounds tighter [m].

    `columns`: so much wider than obstacles (n,) is what is kept free below them, down to the ground; negative: nothing.
    """

    growth: Vector
    columns: Vector
    above: float = 0.0
    below: float = 0.0
    inside: float = 0.0

    def more(self, attempt: Attempt, scenario: Scenario) -> "Needs":
        """What is needed beside this by what an attempt is short of."""
        promise, curve = attempt.promise, attempt.plan.curve
        short = {kept.limit: -kept.slack * MORE + A_LITTLE for kept in promise.broken if kept.on_the_way}
        wanted = [(one.to, short["obstacles"]) for one in promise.broken if one.on_the_way and one.limit == "obstacles"]
        wanted += [(one.body, one.missing * MORE + A_LITTLE) for one in attempt.short if one.body and not one.overhead]
        growth, columns = self.growth, self.columns.copy()
        spots = curve.sample(max(2, int(curve.length / LOOK_EVERY)))
        for name, missing in wanted:
            growth = np.maximum(growth, _growth(spots, name, missing, scenario))
        number = {body.name: n for n, body in enumerate(scenario.airspace.obstacles)}
        for name, missing in {one.body: one.missing for one in attempt.short if one.overhead}.items():
            wide = columns[number[name]]
            columns[number[name]] = 0.0 if wide < 0.0 else wide + missing * MORE + A_LITTLE
        return Needs(
            growth,
            columns,
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
            _room_below(air, wide, column) if column >= 0.0 else body
            for body, wide, column in zip(
                grown(roomy, scenario, self.growth, EVEN, gaps), air.obstacles, self.columns.tolist(), strict=True
            )
        )
        inside = Rim(self.inside, self.inside, self.inside)
        bounds = shrunk(air.bounds, scenario.places, inside) if self.inside else air.bounds
        return problem_of(roomy).tightened(self.above, self.below, Airspace(bounds, air.terrain, bodies))


def _room_below(air: Airspace, body: Obstacle, wider: float) -> Obstacle:
    """The body, so much wider, and all below it down to the lowest bound."""
    (west, south, base), (east, north, top) = body.bounds
    floor = min(air.bounds.lower[2], base)
    if body.column is not None:
        return body.grown(wider, base - floor, 0.0)
    radius = max(east - west, north - south) / 2 + wider
    return Cylinder(body.name, (west + east) / 2, (south + north) / 2, radius, floor, top)


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
    """No need of more."""
    count = len(scenario.airspace.obstacles)
    return Needs(np.zeros(count), np.full(count, -1.0))
