"""Our optimizers beside mealpy's, on the same function with the same budget: seconds of CPU, and their ratio.

Timed side by side, alternating, because two numbers from two machines, or two hours, mean nothing.
Needs: pip install mealpy minionpy, in an environment of its own, for mealpy holds NumPy at 1.26.
Example: python -m tools.benchmarks.optimizers --repeats 3
"""

import statistics
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from mealpy import FloatVar
from mealpy.swarm_based.HHO import OriginalHHO
from mealpy.swarm_based.POA import OriginalPOA
from mealpy.swarm_based.SSA import OriginalSSA

from ipoa_mission.optimize.registry import build_optimizer, optimizer_names
from ipoa_mission.optimize.search import Candidates, Costs, minimize
from ipoa_mission.paper.benchmark_problem import Problem
from ipoa_mission.paper.cec2022 import cec2022
from tools import command_line

PEERS = {"poa": OriginalPOA, "hho": OriginalHHO, "ssa": OriginalSSA}
N, T = 30, 1000


def seconds(job: Callable[[], object]) -> float:
    started = time.process_time()
    job()
    return time.process_time() - started


def run_ours(name: str, problem: Problem, cost: Callable[[Candidates], Costs]) -> int:
    found = minimize(cost, problem.box, build_optimizer(name, {}), np.random.default_rng(1))
    return int(found.evaluations[-1])


def run_theirs(name: str, problem: Problem, cost_of: Callable[[Candidates], Costs], iterations: int) -> int:
    spent = 0

    def cost(x: np.ndarray) -> float:
        nonlocal spent
        spent += 1
        return float(cost_of(x[None])[0])

    bounds = FloatVar(lb=problem.box.lower, ub=problem.box.upper)
    PEERS[name](epoch=iterations, pop_size=N).solve(
        {"bounds": bounds, "minmax": "min", "obj_func": cost, "log_to": None}, seed=1
    )
    return spent


def nothing(x: Candidates) -> Costs:
    return np.arange(len(x), dtype=np.float64)


if __name__ == "__main__":
    parser = command_line(__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=T, help="of mealpy's; its seconds are scaled to ours")
    options = parser.parse_args()
    problem = cec2022("f6", 20)
    print(f"CEC2022 f6, D = 20, N = {N}, T = {T}; CPU seconds, median of {options.repeats}")
    for name in optimizer_names():
        evaluations = 0
        ours, loops = list[float](), list[float]()
        theirs, their_loops = list[float](), list[float]()
        for _ in range(options.repeats):
            started = time.process_time()
            evaluations = run_ours(name, problem, problem.cost)
            ours.append(time.process_time() - started)
            loops.append(seconds(partial(run_ours, name, problem, nothing)))
            if name in PEERS:
                for cost_of, kept in ((problem.cost, theirs), (nothing, their_loops)):
                    started = time.process_time()
                    calls = run_theirs(name, problem, cost_of, options.iterations)
                    kept.append((time.process_time() - started) / calls * evaluations)
        line = f"{name:>17}: {statistics.median(ours):6.3f} s for {evaluations} evaluations"
        line += f" (without the cost {statistics.median(loops):.3f} s)"
        if theirs:
            whole, loop = statistics.median(theirs), statistics.median(their_loops)
            line += f"; mealpy {whole:.2f} s for as many, {whole / statistics.median(ours):.0f} times ours"
            line += f" (without the cost {loop:.2f} s, {loop / statistics.median(loops):.0f} times)"
        print(line, flush=True)
