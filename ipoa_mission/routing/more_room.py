"""Where a path must keep farther away than the scenario asks, so that what is flown along it keeps what is asked."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.forecast.tube.limits import Rim, raised
from ipoa_mission.forecast.tube.room import LEAST_GROWTH, keep_gaps_open, lowered, shrunk
from ipoa_mission.geometry import Vector
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Cylinder, Obstacle

MORE = 1.15  # times what is missing
A_LITTLE = 0.03  # and so much [m]
AS_NEAR = 0.3  # an obstacle is moved away from that is farther than the nearest by what is missing and so much [m]
LOOK_EVERY = 0.5  # along a curve [m]


@dataclass(frozen=True, eq=False)
class Needs:
    """By how much obstacles (n,) must be larger, and limits of height and bounds tighter [m].

    `columns`: from which obstacles (n,) down to the ground nothing may be flown.
    """

    growth: Vector
    columns: NDArray[np.bool_]
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
        overhead = {one.body for one in attempt.short if one.overhead}
        columns |= np.array([body.name in overhead for body in scenario.airspace.obstacles], dtype=bool)
        return Needs(
            growth,
            columns,
            self.above + short.get("ground", 0.0),
            self.below + short.get("ceiling", 0.0),
            self.inside + short.get("bounds", 0.0),
        )

    def room(self, roomy: Scenario, scenario: Scenario, gaps: bool) -> Scenario:
        """The scenario with the room that `roomy` has and what is needed beside; with `gaps` it closes no gap.

        Nothing closes in on a place that the scenario gives.
        """
        spare = np.array([body.distance(scenario.places).min() for body in scenario.airspace.obstacles])
        growth = np.clip(spare - scenario.limits.obstacle_distance - LEAST_GROWTH, 0.0, self.growth)
        if gaps and len(growth) > 1:
            keep_gaps_open(growth, scenario.airspace.obstacles, scenario.limits.obstacle_distance, float(growth.max()))
        bodies = tuple(
            _down_to(roomy.airspace, larger) if is_column else larger
            for larger, is_column in zip(
                (
                    body.grown(by, by, by) if by > LEAST_GROWTH else wide
                    for body, wide, by in zip(
                        scenario.airspace.obstacles, roomy.airspace.obstacles, growth.tolist(), strict=True
                    )
                ),
                self.columns.tolist(),
                strict=True,
            )
        )
        inside, air = Rim(self.inside, self.inside, self.inside), roomy.airspace
        try:
            bounds = shrunk(air.bounds, scenario, inside) if self.inside else air.bounds
        except BadInput:
            bounds = air.bounds
        wider = lowered(raised(roomy, self.above) if self.above else roomy, self.below)
        return wider.in_airspace(Airspace(bounds, air.terrain, bodies))


def _down_to(air: Airspace, body: Obstacle) -> Obstacle:
    """The body and all below it, down to the lowest bound."""
    (west, south, base), (east, north, top) = body.bounds
    if body.column is not None:
        return body.grown(0.0, max(base - air.bounds.lower[2], 0.0), 0.0)
    radius = max(east - west, north - south) / 2
    return Cylinder(body.name, (west + east) / 2, (south + north) / 2, radius, min(air.bounds.lower[2], base), top)


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
    return Needs(np.zeros(count), np.zeros(count, dtype=bool))
