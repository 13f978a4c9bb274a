"""Measure IPOA and POA as printed, and mealpy's POA: one long search in absolute coordinates.

mealpy runs in its own interpreter. Our kernel checks the cost of its best candidate.
"""

import json
import subprocess
import time
from pathlib import Path

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.optimize.registry import build_optimizer
from ipoa_mission.optimize.search import minimize
from ipoa_mission.planning.obstacle_grid import LEAST
from ipoa_mission.planning.problem import PreparedProblem, encode, prepare
from ipoa_mission.planning.spline import Spline, even_basis
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.obstacles.obstacle import CYLINDER, SPHERE
from ipoa_mission.world.terrain import Analytic

POPULATION, ITERATIONS = 30, 1000
AGREE = 0.01  # relative: our kernel has the terrain on a fine grid


def search(name: str, scenario: Scenario, seed: int) -> tuple[Spline, float, int]:
    """Return the curve of the printed optimizer, CPU seconds and number of evaluations."""
    problem = prepare(scenario)
    encoding = encode("absolute", scenario.places, scenario.planning.control_points, 0.0, scenario)
    optimizer = build_optimizer(name, {"population": POPULATION, "iterations": ITERATIONS})
    started = time.process_time()
    found = minimize(problem.costs(encoding), encoding.box, optimizer, np.random.default_rng(seed))
    return encoding.curve(found.x), time.process_time() - started, int(found.evaluations[-1])


def mealpy_poa(scenario: Scenario, interpreter: str, iterations: int = ITERATIONS) -> tuple[Spline, float, int]:
    """Return the curve of mealpy's POA, CPU seconds and number of evaluations.

    Raises:
        MissionError: mealpy cannot be run, or its cost differs from ours.
    """
    problem = prepare(scenario)
    script = Path(__file__).with_name("mealpy_poa.py")
    asked = json.dumps(_as_json(problem) | {"population": POPULATION, "iterations": iterations})
    ran = subprocess.run([interpreter, script], input=asked, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise MissionError(f"{interpreter}: expected a Python that has mealpy: {ran.stderr.strip()[-300:]}")
    found = json.loads(ran.stdout)
    encoding = encode("absolute", scenario.places, scenario.planning.control_points, 0.0, scenario)
    candidate = np.array(found["candidate"])
    ours = float(problem.costs(encoding)(candidate[None])[0])
    if abs(ours - found["cost"]) > AGREE * ours:
        raise MissionError(f"the user's cost is {found['cost']:.3f} where ours is {ours:.3f}: expected the same")
    return encoding.curve(candidate), found["seconds"], found["evaluations"]


def _as_json(problem: PreparedProblem) -> dict[str, object]:
    scenario, rules = problem.task, problem.rules
    terrain = scenario.airspace.terrain
    assert isinstance(terrain, Analytic)
    rows = [part.grid_row() for body in scenario.airspace.obstacles for part in body.parts]
    land: dict[str, object] = {name: getattr(terrain, name) for name in ("a", "b", "c", "d", "e", "f", "g", "base")}
    return {
        "start": scenario.places[0].tolist(),
        "goal": scenario.places[-1].tolist(),
        "lower": list(scenario.airspace.bounds.lower),
        "upper": list(scenario.airspace.bounds.upper),
        "basis": even_basis(scenario.planning.control_points + 2, problem.nodes).tolist(),
        "spheres": [row.numbers[:4] for row in rows if row.kind == SPHERE],
        "cylinders": [row.numbers for row in rows if row.kind == CYLINDER],
        "terrain": land | {"peaks": [[p.height, p.east, p.north, p.a, p.b] for p in terrain.peaks]},
        "rules": {name: float(getattr(rules, name)) for name in rules._fields} | {"least": LEAST},
    }
