"""Plan paths on seeded random maps in `missions/paper/`; the paper's are unpublished.

The paper's method: absolute coordinates, cost summed over nodes, no polish.
"""

import numpy as np

from ipoa_mission import Scenario, read_scenario
from ipoa_mission.errors import BadInput, UnknownName
from ipoa_mission.files import packed
from ipoa_mission.geometry import polyline_length, turning_angles
from ipoa_mission.optimize.search import Optimum
from ipoa_mission.paper.cec2022 import Measures, Problem
from ipoa_mission.planning.problem import encode, prepare
from ipoa_mission.planning.proof import TOUCHING, prove_curve
from ipoa_mission.planning.spline import Spline

MAPS = ("map-8-1", "map-8-2", "map-8-3", "map-8-4", "map-8-5", "map-6-1", "map-10-1")
#: Table 5's experiments; the other tables use the first.
WEIGHTS = {1: (0.7, 0.15, 0.15), 2: (0.15, 0.7, 0.15), 3: (0.15, 0.15, 0.7)}
#: The paper does not give this number.
INNER = 8
#: share of the final cost
CONVERGED = 0.01


def map_problem(case: str, dimension: int) -> Problem:
    """Return the problem of a map, or map and experiment of Table 5, "map-8-1/2". Raises BadInput."""
    if dimension != 3 * INNER:
        raise BadInput(f"expected {3 * INNER}, not {dimension}", place="dimension")
    return path_problem(map_scenario(case))


def map_scenario(case: str) -> Scenario:
    """Raises BadInput."""
    name, _, experiment = case.partition("/")
    weights = {str(number): omega for number, omega in WEIGHTS.items()}.get(experiment or "1")
    if name not in MAPS or weights is None:
        raise UnknownName(
            f"expected one of {', '.join(MAPS)}, with or without /1, /2 or /3, not {case!r}", place="case"
        )
    scenario = paper_scenario(name)
    return scenario.model_copy(update={"cost": scenario.cost.model_copy(update={"omega": weights})})


def paper_scenario(name: str) -> Scenario:
    """Raises BadInput."""
    return read_scenario(packed(f"paper/{name}.toml"))


def path_problem(scenario: Scenario) -> Problem:
    guide = np.vstack([scenario.start_point, scenario.goal_point])
    encoding = encode("absolute", guide, scenario.planning.control_points, 0.0, scenario)

    def measure(optimum: Optimum) -> Measures:
        return measures_of(encoding.curve(optimum.x), scenario) | {"iterations": iterations_to_converge(optimum)}

    return Problem(prepare(scenario).costs(encoding), encoding.box, measure)


def measures_of(curve: Spline, scenario: Scenario) -> Measures:
    """Return the paper's measures of a path (Table A2).

    `distance`: length of the curve [m]. `turn`: mean turning angle between legs of the control points; over the curve's
    hundred nodes it contradicts the tables. `dis_obs`: mean distance of the hull at those nodes to the nearest obstacle
    [m]. `clearance`: least distance of the hull along the whole curve [m]. `feasible`: touches nothing, leaves no
    bound.
    """
    nodes = curve.points(np.linspace(0.0, 1.0, scenario.planning.samples))
    hull = scenario.airspace.obstacle_distance(nodes) - scenario.vehicle.radius
    least = {"obstacles": np.inf, "ground": np.inf, "bounds": np.inf}
    for check in prove_curve(curve, scenario).checks:
        if check.limit in least:
            least[check.limit] = min(least[check.limit], check.nearest.distance)
    clearance = min(least["obstacles"] - scenario.vehicle.radius, least["ground"])
    return {
        "distance": round(polyline_length(curve.sample(1000)), 4),
        "turn": round(float(np.degrees(turning_angles(curve.control)).mean()), 4),
        "turn_smooth": round(float(np.degrees(turning_angles(nodes)).mean()), 4),
        "dis_obs": round(float(hull.mean()), 4),
        "clearance": round(float(clearance), 4),
        "feasible": float(clearance >= 0 and least["bounds"] >= -TOUCHING),
        "control": [round(float(c), 3) for c in curve.control.ravel()],
    }


def iterations_to_converge(optimum: Optimum) -> float:
    """Return the iteration, of a thousand, from which the best cost is within 1 % of the final one."""
    first = int(np.argmax(optimum.history <= optimum.cost + CONVERGED * abs(optimum.cost)))
    return float(round(optimum.evaluations[first] / optimum.evaluations[-1] * 1000, 1))
