"""Generate the rows of each part, one after the other in one process on one core."""

import itertools
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import polyline_length
from ipoa_mission.planning.cost import curve_cost
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.planning.proof import prove_curve
from ipoa_mission.scenario import Scenario
from tools.benchmarks.planning_benchmark.maps import FIELDS, MAPS, SIDES, benchmark_map, weighing
from tools.benchmarks.planning_benchmark.metaheuristics import mealpy_poa, search
from tools.benchmarks.planning_benchmark.rows import Row, today

SECONDS = (1.0, 5.0)  # times given to OMPL
CONTROL_POINTS = (4, 6, 8, 12, 16, 24, 32)
LENGTH_ONLY = (1.0, 0.0, 0.0)


@dataclass(frozen=True)
class Work:
    """Define the maps and the effort of a measurement."""

    maps: tuple[str, ...]
    seeds: int
    starts: int  # of the reference's searches
    mealpy: str  # an interpreter with mealpy; empty: none


def planner(work: Work) -> Iterator[Row]:
    """Measure our planner after a first run that is not counted."""
    yield from _planned(work, "planner", work.maps)


def printed(work: Work) -> Iterator[Row]:
    """Measure IPOA and POA as printed, and mealpy's POA, on the maps of the paper's size."""
    maps = [name for name in work.maps if name.startswith(("spheres", "cylinders"))]
    row = partial(Row, "printed", versions=_versions("numba"), date=today())
    for name in ("ipoa", "poa"):
        search(name, benchmark_map(MAPS[0]), 0)
    for map_ in maps:
        scenario = benchmark_map(map_)
        for name, seed in itertools.product(("ipoa", "poa"), range(work.seeds)):
            curve, seconds, evaluations = search(name, scenario, seed)
            safe, cost = prove_curve(curve, scenario).holds, curve_cost(curve, scenario)
            yield row(map_, name, f"{evaluations} evaluations", seed, cost.total, cost.length, safe, seconds)
    for map_ in maps[:: max(len(maps) // 2, 1)] if work.mealpy else []:
        scenario = benchmark_map(map_)
        curve, seconds, evaluations = mealpy_poa(scenario, work.mealpy)
        safe, cost = prove_curve(curve, scenario).holds, curve_cost(curve, scenario)
        yield row(map_, "mealpy poa", f"{evaluations} evaluations", 0, cost.total, cost.length, safe, seconds)


def ompl(work: Work) -> Iterator[Row]:
    """Measure each of OMPL's planners after each time."""
    from tools.benchmarks.planning_benchmark.ompl_peers import PLANNERS, best_paths

    row = partial(Row, "ompl", versions=_versions("ompl"), date=today())
    for map_, name in itertools.product(work.maps, PLANNERS):
        scenario = benchmark_map(map_)
        for seconds, found in zip(SECONDS, best_paths(name, scenario, SECONDS), strict=True):
            if found is None:
                yield row(map_, name, f"{seconds:g} s", 0, None, None, False, seconds)
            else:
                cost, points = found
                yield row(map_, name, f"{seconds:g} s", 0, cost, polyline_length(points), True, seconds)


def reference(work: Work) -> Iterator[Row]:
    """Search the reference optimum, also from the results of the planner and OMPL."""
    yield from _referred(work, "reference", work.maps)


def length(work: Work) -> Iterator[Row]:
    """Measure the planner with length as the only cost, and the reference for it."""
    maps = tuple(f"{name}/length" for name in work.maps)
    yield from _planned(work, "length", maps)
    yield from _referred(work, "length", maps)


def scaling(work: Work) -> Iterator[Row]:
    """Measure the planner on fields of masts: more masts, more control points, larger maps."""
    yield from _planned(work, "obstacles", tuple(f"field-{n}-1" for n in FIELDS))
    yield from _planned(work, "map size", tuple(f"side-100-{side}" for side in SIDES))
    yield from _planned(work, "control points", tuple(f"cylinders-8-2/{n}" for n in CONTROL_POINTS))


PARTS = {each.__name__: each for each in (planner, printed, ompl, reference, length, scaling)}


def _planned(work: Work, part: str, maps: tuple[str, ...]) -> Iterator[Row]:
    row = partial(Row, part, versions=_versions("ipoa-mission"), date=today())
    plan_path(benchmark_map(MAPS[0]))
    for map_, seed in itertools.product(maps, range(work.seeds)):
        scenario, started = _scenario(map_), time.process_time()
        try:
            plan = plan_path(scenario, seed=seed)
        except MissionError:
            yield row(map_, "planner", "", seed, None, None, False, time.process_time() - started)
            continue
        spent, cost = time.process_time() - started, plan.cost
        safe = prove_curve(plan.curve, scenario).holds
        yield row(map_, "planner", "", seed, cost.total, cost.length, safe, spent)


def _referred(work: Work, part: str, maps: tuple[str, ...]) -> Iterator[Row]:
    from tools.benchmarks.planning_benchmark.ompl_peers import best_paths
    from tools.benchmarks.planning_benchmark.reference import reference

    row = partial(Row, part, versions=_versions("cma", "ompl"), date=today())
    for map_ in maps:
        scenario, started = _scenario(map_), time.process_time()
        given = [plan_path(scenario, seed=100 + k).curve.sample(200) for k in range(2)]
        given += [found[1] for found in best_paths("BIT*", scenario, (2.0,)) if found is not None]
        cost, candidate = reference(scenario, 1, work.starts, given)
        spent = time.process_time() - started
        yield row(map_, "reference", "", 1, cost, candidate.curve.length, True, spent)


def _scenario(name: str) -> Scenario:
    """Return a map, or one under other conditions: "cylinders-8-2/length", or ".../16" with 16 control points."""
    name, _, condition = name.partition("/")
    scenario = benchmark_map(name)
    if condition == "length":
        return weighing(scenario, LENGTH_ONLY)
    if condition:
        planning = scenario.planning.model_copy(update={"control_points": int(condition)})
        return scenario.model_copy(update={"planning": planning})
    return scenario


def _versions(*packages: str) -> str:
    return ", ".join(f"{name} {version(name)}" for name in dict.fromkeys(("numpy", *packages)))
