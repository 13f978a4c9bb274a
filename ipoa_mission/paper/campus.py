"""Reproduce Table 8: plan, fly on the built-in autopilot, and estimate.

The paper's model of Dalian University is unpublished. `missions/paper/campus.toml` has the same distance from start to
goal, at the same 15 m/s.
"""

import numpy as np

from ipoa_mission import Command, Mission, NoRoute, Scenario, assemble, estimate, fly
from ipoa_mission.errors import BadInput, UnknownName
from ipoa_mission.optimize.search import Optimum
from ipoa_mission.paper.cec2022 import Measures, Problem
from ipoa_mission.paper.paper_maps import paper_scenario, path_problem
from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.planning.spline import Spline


def campus_scenario() -> Scenario:
    """Return the campus with the paper's method: cost over nodes, no polish. Raises BadInput."""
    scenario = paper_scenario("campus")
    return scenario.model_copy(
        update={
            "planning": scenario.planning.model_copy(update={"planner": "paper"}),
            "cost": scenario.cost.model_copy(update={"form": "nodes"}),
        }
    )


def campus_problem(case: str, dimension: int) -> Problem:
    """Return the planning problem of Table 8. Raises BadInput."""
    if case != "campus":
        raise UnknownName(f"expected campus, not {case!r}", place="case")
    scenario = campus_scenario()
    if dimension != 3 * scenario.planning.control_points:
        raise BadInput(f"expected {3 * scenario.planning.control_points}, not {dimension}", place="dimension")
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
        mission = assemble(plan, close)
    except NoRoute:
        return {"flyable": 0.0}
    record, predicted = fly(mission), estimate(mission)
    first, last = _waypoints(mission)
    done = {item.seq: item.done_s for item in predicted.items}
    return {
        "flyable": 1.0,
        "waypoints": float(sum(item.command == Command.NAV_WAYPOINT for item in mission.items)),
        "time": round(record.item_reached_s[last] - record.item_reached_s[first], 3),
        "estimate": round(done[last + 1] - done[first + 1], 3),
        "time_landed": round(record.total_s, 3),
        "estimate_landed": round(predicted.total_s, 3),
    }


def _waypoints(mission: Mission) -> tuple[int, int]:
    route = [k for k, item in enumerate(mission.items) if item.command == Command.NAV_WAYPOINT]
    return route[0] - 1, route[-1]
