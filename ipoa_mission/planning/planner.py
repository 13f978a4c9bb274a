"""From a scenario to a plan: search, then prove."""

from collections.abc import Callable

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import minimise
from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.limits import places
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.problem import encode, pose
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.scenario import Scenario


class NoPath(MissionError):
    """The best path found still collides, leaves the bounds or breaks another limit; the message says which."""


def plan_path(
    scenario: Scenario, seed: int = 0, progress: Callable[[float, str], None] = lambda done, words: None
) -> Plan:
    """The best path that the scenario's optimiser finds, proved to keep every limit.

    `progress` is told the share of the work that is done, and a few words.

    Raises:
        BadInput: the optimiser has no such setting.
        NoPath: no path that keeps the limits was found.
    """
    optimizer = build_optimizer(scenario.optimizer.name, scenario.optimizer.settings)
    problem, guide = pose(scenario), places(scenario)
    paper = scenario.planning.planner == "paper"
    name = scenario.planning.encoding or ("absolute" if paper else "sine")
    direct = float(np.linalg.norm(scenario.goal_point - scenario.start_point))
    encoding = encode(name, guide, scenario.planning.control_points, direct / 2, scenario)
    rng = np.random.default_rng(seed)
    found = minimise(problem.costs(encoding), encoding.box, optimizer, rng)
    curve = encoding.curve(found.x)
    proof = prove_curve(curve, scenario)
    if not proof.holds:
        raise NoPath(f"no safe path was found; the best one is {proof.words()}", hint="try another --seed")
    cost = curve_cost(curve, scenario)
    return Plan(curve, cost, proof, scenario.optimizer.name, seed, found.evaluations, found.history)
