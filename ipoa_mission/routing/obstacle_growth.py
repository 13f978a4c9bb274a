from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.forecast.contingency.contingency_samples import ReturnLeg
from ipoa_mission.forecast.contingency.shortfalls import Shortfall
from ipoa_mission.forecast.deviation.kept_limits import DeviationBound, grown, shrunk
from ipoa_mission.geometry import Vector
from ipoa_mission.planning.path_problem import PathProblem, PathTask, problem_of
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Cylinder, Obstacle

GROWTH_FACTOR = 1.15  # of the missing distance
GROWTH_MARGIN = 0.03  # to the missing distance [m]
NEAREST_MARGIN = 0.3  # [m]
SAMPLE_STEP = 0.5  # [m]
EVEN_BOUND = DeviationBound(1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class ObstacleGrowth:
    """Growth of obstacles (n,), and tightening of height limits and bounds [m].

    `below_overhangs`: growth of the free volume below (n,); negative: none. `above_landings`: above.
    """

    growth: Vector
    below_overhangs: Vector
    above_landings: Vector
    above: float = 0.0
    below: float = 0.0
    inside: float = 0.0

    def more(self, attempt: Attempt, scenario: Scenario) -> "ObstacleGrowth":
        broken = [kept for kept in attempt.guarantee.broken if kept.in_cruise]
        curve = attempt.plan.curve
        shortfalls = attempt.short
        tightening = {kept.limit: _needed(-kept.slack) for kept in broken}
        low = [shortfall for shortfall in shortfalls if not shortfall.body and shortfall.part < ReturnLeg.RETURNS]
        tightening["ground"] = max([tightening.get("ground", 0.0), *(_needed(shortfall.missing) for shortfall in low)])
        needs = list[tuple[list[int], float]]()  # numbers of obstacles, and a distance [m]
        for kept in broken:
            if kept.limit == "obstacles":
                named = [n for n, body in enumerate(scenario.airspace.obstacles) if body.name == kept.to]
                needs.append((named, tightening["obstacles"]))
        for shortfall in shortfalls:
            if shortfall.body and not shortfall.overhead and not shortfall.comes_down:
                needs.append(([shortfall.number], _needed(shortfall.missing)))
        growth = self.growth
        spots = curve.sample(max(2, int(curve.length / SAMPLE_STEP)))
        for numbers, missing in needs:
            growth = np.maximum(growth, _growth(spots, numbers, missing, scenario))
        return ObstacleGrowth(
            growth,
            _wider(self.below_overhangs, (shortfall for shortfall in shortfalls if shortfall.overhead)),
            _wider(self.above_landings, (shortfall for shortfall in shortfalls if shortfall.comes_down)),
            self.above + tightening.get("ground", 0.0),
            self.below + tightening.get("ceiling", 0.0),
            self.inside + tightening.get("bounds", 0.0),
        )

    def enlarge(self, enlarged: PathTask, scenario: Scenario, gaps: bool) -> PathProblem:
        """Return the problem with these needs added; with `gaps`, no gap is closed."""
        air = enlarged.airspace
        bodies = tuple(
            _upright(air, wide, column, tower) if max(column, tower) >= 0.0 else body
            for body, wide, column, tower in zip(
                grown(enlarged, scenario, self.growth, EVEN_BOUND, gaps),
                air.obstacles,
                self.below_overhangs.tolist(),
                self.above_landings.tolist(),
                strict=True,
            )
        )
        inside = DeviationBound(self.inside, self.inside, self.inside)
        bounds = shrunk(air.bounds, scenario.places, inside) if self.inside else air.bounds
        return problem_of(enlarged).tightened(self.above, self.below, Airspace(bounds, air.terrain, bodies))


def _needed(missing: float) -> float:
    return missing * GROWTH_FACTOR + GROWTH_MARGIN


def _wider(rooms: Vector, short: Iterable[Shortfall]) -> Vector:
    wider = rooms.copy()
    for shortfall in short:
        n = shortfall.number
        room = 0.0 if rooms[n] < 0.0 else rooms[n] + shortfall.missing * GROWTH_FACTOR + GROWTH_MARGIN
        wider[n] = max(wider[n], room)
    return wider


def _upright(air: Airspace, body: Obstacle, column: float, tower: float) -> Obstacle:
    (west, south, base), (east, north, top) = body.bounds
    floor = min(air.bounds.lower[2], base) if column >= 0.0 else base
    ceiling = max(air.bounds.upper[2], top) if tower >= 0.0 else top
    wider = max(column, tower)
    if body.column is not None:
        return body.grown(wider, base - floor, ceiling - top)
    radius = max(east - west, north - south) / 2 + wider
    return Cylinder(body.name, (west + east) / 2, (south + north) / 2, radius, floor, ceiling)


def _growth(spots: np.ndarray, numbers: list[int], missing: float, scenario: Scenario) -> Vector:
    """Return the growth (n,) that moves `spots` (k, 3) away from obstacles of these numbers by `missing` [m]."""
    bodies = scenario.airspace.obstacles
    required = scenario.limits.obstacle_distance
    number = {id(body): n for n, body in enumerate(bodies)}
    away = np.full(len(bodies), np.inf)
    for body, _, distance in scenario.airspace.near(spots, required + 4 * missing + 10.0):
        away[number[id(body)]] = float(distance.min())
    nearest = float(away[numbers].min(initial=np.inf))
    nearest = nearest if np.isfinite(nearest) else float(away.min())
    return np.where(away <= nearest + missing + NEAREST_MARGIN, np.maximum(away + missing - required, 0.0), 0.0)


def approximation_growth(scenario: Scenario) -> ObstacleGrowth:
    none = initial_growth(scenario)
    return replace(none, growth=none.growth + 2 * GROWTH_MARGIN, above=2 * GROWTH_MARGIN)


def initial_growth(scenario: Scenario) -> ObstacleGrowth:
    """Return no growth, but tightening above landings if the vehicle may land by choice."""
    none = np.full(len(scenario.airspace.obstacles), -1.0)
    vehicle = scenario.vehicle
    failsafes = vehicle.autopilot.failsafes(vehicle.autopilot_parameters(), vehicle.version)
    lands = scenario.safety.returns == "planned" and any(failsafe.lands_by_choice for failsafe in failsafes)
    return ObstacleGrowth(np.zeros_like(none), none, np.zeros_like(none) if lands else none)
