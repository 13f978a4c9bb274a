"""The problems: CEC2022, seeded maps in `missions/paper/` (the paper's are unpublished), and the campus.

Maps follow the paper's method: absolute coordinates, cost summed over nodes, no polish. `campus.toml` has the paper's
distance from start to goal and 15 m/s.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ipoa_mission import Box, Command, NoRoute, Plan, Scenario, assemble_mission, estimate, fly_built_in, read_scenario
from ipoa_mission.errors import imported
from ipoa_mission.files import packed
from ipoa_mission.geometry import polyline_length, turning_angles
from ipoa_mission.optimize.search import Candidates, Costs, Optimum
from ipoa_mission.planning.problem import curve_cost, follow, prepare, surround
from ipoa_mission.planning.proof import TOUCHING, prove_curve
from ipoa_mission.planning.spline import Spline

#: F_i* of Table 1
OPTIMA = (300.0, 400.0, 600.0, 800.0, 900.0, 1800.0, 2000.0, 2200.0, 2300.0, 2400.0, 2600.0, 2700.0)
FUNCTIONS = tuple(f"f{i}" for i in range(1, 13))
MAPS = ("map-8-1", "map-8-2", "map-8-3", "map-8-4", "map-8-5", "map-6-1", "map-10-1")
#: Table 5's experiments; the other tables use the first.
WEIGHTS = {"1": (0.7, 0.15, 0.15), "2": (0.15, 0.7, 0.15), "3": (0.15, 0.15, 0.7)}
#: The paper does not give this number.
INNER = 8

Measures: TypeAlias = dict[str, float | list[float]]


@dataclass(frozen=True)
class Problem:
    """A cost (n, D) -> (n,) to minimize, its box, and further measures of an optimum."""

    cost: Callable[[Candidates], Costs]
    box: Box
    measure: Callable[[Optimum], Measures] = lambda _optimum: {}


def cec2022(function: str, dimension: int) -> Problem:
    """Return cost minus optimum of "f1" to "f12", by `minionpy`; `opfunu` 1.0.4 is wrong on eleven of them."""
    cec = imported("minionpy.cec", "the CEC2022 functions need minionpy, which is not installed", "paper")
    number = FUNCTIONS.index(function)
    raw = cec.CEC2022Functions(number + 1, dimension)

    def error_of(candidates: Candidates) -> Costs:
        return np.asarray(raw(candidates), dtype=np.float64) - OPTIMA[number]

    return Problem(error_of, Box(np.full(dimension, -100.0), np.full(dimension, 100.0)))


def map_scenario(case: str) -> Scenario:
    """Return a map, with the weights of an experiment of Table 5 for a case like "map-8-1/2"."""
    name, _, experiment = case.partition("/")
    scenario = paper_scenario(name)
    weights = WEIGHTS[experiment or "1"]
    return scenario.model_copy(update={"cost": scenario.cost.model_copy(update={"omega": weights})})


def paper_scenario(name: str) -> Scenario:
    return read_scenario(packed(f"paper/{name}.toml"))


def path_problem(scenario: Scenario) -> Problem:
    guide = np.vstack([scenario.start_point, scenario.goal_point])
    around = follow(guide, scenario.planning.control_points, scenario)
    encoding = surround("absolute", around, 0.0, scenario)

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
    first = int(np.argmax(optimum.history <= optimum.cost + 0.01 * abs(optimum.cost)))
    return float(round(optimum.evaluations[first] / optimum.evaluations[-1] * 1000, 1))


def campus_scenario() -> Scenario:
    """Return the campus with the paper's method: cost over nodes, no polish."""
    scenario = paper_scenario("campus")
    return scenario.model_copy(
        update={
            "planning": scenario.planning.model_copy(update={"planner": "paper"}),
            "cost": scenario.cost.model_copy(update={"form": "nodes"}),
        }
    )


def campus_problem() -> Problem:
    scenario = campus_scenario()
    problem = path_problem(scenario)

    def measure(optimum: Optimum) -> Measures:
        measures = problem.measure(optimum)
        if measures["feasible"]:
            control = np.array(measures["control"], dtype=np.float64).reshape(-1, 3)
            measures |= flown(Spline(control), scenario, optimum)
        return measures

    return Problem(problem.cost, problem.box, measure)


def flown(curve: Spline, scenario: Scenario, optimum: Optimum) -> Measures:
    """Return the flown `time` from the first waypoint to the last [s], and the estimated one.

    Without a clear choice of waypoints `flyable` is 0. The search kept its safety distance at nodes only.
    """
    close = scenario.model_copy(update={"safety_distance": 0.0})
    plan = Plan(curve, curve_cost(curve, close), prove_curve(curve, close), "", 0, optimum.evaluations, optimum.history)
    try:
        mission = assemble_mission(plan, close)
    except NoRoute:
        return {"flyable": 0.0}
    record = fly_built_in(mission)
    predicted = estimate(mission)
    waypoints = [k for k, item in enumerate(mission.items) if item.command == Command.NAV_WAYPOINT]
    first = waypoints[0]
    last = waypoints[-1]
    done = {item.seq - 1: item.done_s for item in predicted.items}
    return {
        "flyable": 1.0,
        "waypoints": float(len(waypoints)),
        "time": round(record.item_reached_s[last] - record.item_reached_s[first], 3),
        "estimate": round(done[last] - done[first], 3),
        "time_landed": round(record.total_s, 3),
        "estimate_landed": round(predicted.total_s, 3),
    }
