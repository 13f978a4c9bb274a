"""Where a path must keep farther away than the scenario asks, so that what is flown along it keeps what is asked."""

from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.forecast.tube.limits import Rim
from ipoa_mission.forecast.tube.promise import Promise
from ipoa_mission.forecast.tube.room import grown, shrunk
from ipoa_mission.geometry import Vector
from ipoa_mission.planning.path_problem import PathProblem, PathTask, problem_of
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace

MORE = 1.15  # times what is missing
A_LITTLE = 0.03  # and so much [m]
AS_NEAR = 0.3  # an obstacle is moved away from that is farther than the nearest by what is missing and so much [m]
LOOK_EVERY = 0.5  # along a curve [m]
EVEN = Rim(1.0, 1.0, 1.0)  # as far up and down as to the sides


@dataclass(frozen=True, eq=False)
class Needs:
    """By how much obstacles (n,) must be larger, and limits of height and bounds tighter [m]."""

    growth: Vector
    above: float = 0.0
    below: float = 0.0
    inside: float = 0.0

    def more(self, promise: Promise, curve: Spline, scenario: Scenario) -> "Needs":
        """What is needed beside this by what a promise is short of, of a flight along a curve."""
        short = {kept.limit: -kept.slack * MORE + A_LITTLE for kept in promise.broken if kept.on_the_way}
        growth = self.growth
        for kept in promise.broken:
            if kept.on_the_way and kept.limit == "obstacles":
                spots = curve.sample(max(2, int(curve.length / LOOK_EVERY)))
                growth = np.maximum(growth, _growth(spots, kept.to, short["obstacles"], scenario))
        return Needs(
            growth,
            self.above + short.get("ground", 0.0),
            self.below + short.get("ceiling", 0.0),
            self.inside + short.get("bounds", 0.0),
        )

    def room(self, roomy: PathTask, scenario: Scenario, gaps: bool) -> PathProblem:
        """The scenario with the room that `roomy` has and what is needed beside; with `gaps` it closes no gap.

        Nothing closes in on a place that the scenario gives.
        """
        bodies, air = grown(roomy, scenario, self.growth, EVEN, gaps), roomy.airspace
        inside = Rim(self.inside, self.inside, self.inside)
        bounds = shrunk(air.bounds, scenario.places, inside) if self.inside else air.bounds
        return problem_of(roomy).tightened(self.above, self.below, Airspace(bounds, air.terrain, bodies))


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
    return replace(
        nothing(scenario), growth=np.full(len(scenario.airspace.obstacles), 2 * A_LITTLE), above=2 * A_LITTLE
    )


def nothing(scenario: Scenario) -> Needs:
    """No need of more."""
    return Needs(np.zeros(len(scenario.airspace.obstacles)))
