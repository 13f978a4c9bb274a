from collections.abc import Sequence
from dataclasses import dataclass

from ipoa_mission.paper.cec2022 import FUNCTIONS
from ipoa_mission.paper.paper_maps import INNER, MAPS, WEIGHTS
from ipoa_mission.paper.published import ALGORITHMS
from ipoa_mission.paper.rows import Trial, settings_text

#: evaluations of IPOA at N = 30 and T = 1000 with all strategies
BUDGET = 90_060

BEYOND = ("adaptive-pelican", "rcmaes", "lshade", "de")

#: iterations that spend `BUDGET` at N = 30
EQUAL: dict[str, dict[str, object]] = {
    "ipoa": {"iterations": 1000},
    "dbo": {"iterations": 3001},
    "poa": {"iterations": 1501},
    "ssa": {"iterations": 2501},
    "mpoa": {"iterations": 938},
    "hho": {"iterations": 2337},
}

#: IPOA's settings, one at a time
ABLATION: dict[str, dict[str, object]] = {
    "IPOA as implemented here": {},
    "without chaotic and refracted start": {"chaotic_start": False},
    "without inertia weight": {"inertia": False},
    "without Levy flight": {"levy": False},
    "without t mutation": {"mutation": False},
    "without all four": {"chaotic_start": False, "inertia": False, "levy": False, "mutation": False},
    "literal: Levy on the whole candidate": {"reading": "literal"},
    "literal, 0.01 of the Levy step": {"reading": "literal", "share": 0.01},
    "Levy on the survivor of the exploitation": {"reading": "survivor"},
    "omega = exp(t/T - 1)": {"weight": "exp(t/T-1)"},
    "omega = exp(t/T) - 1": {"weight": "exp(t/T)-1"},
    "prey is the best": {"prey": "best"},
    "t mutation of the best only": {"mutated": "best"},
    "t mutation around each pelican": {"mutated": "own"},
    "nearest known to the print: omega = exp(t/T) - 1, prey best, t around each": {
        "weight": "exp(t/T)-1",
        "prey": "best",
        "mutated": "own",
    },
    "rand for each dimension": {"rand": "dimension"},
    "Levy and t one number a pelican": {"steps": "pelican"},
    "omega = 1 and rand for each dimension": {"inertia": False, "rand": "dimension"},
}


@dataclass(frozen=True)
class Series:
    name: str
    runs: int
    firsts: Sequence[Trial]

    def trials(self, runs: int | None) -> list[Trial]:
        """Return all trials, round after round; `runs` None: the paper's number."""
        return [
            Trial(t.problem, t.case, t.dimension, t.algorithm, t.settings, t.budget, run)
            for run in range(self.runs if runs is None else runs)
            for t in self.firsts
        ]


def _cec(dimension: int, algorithms: Sequence[tuple[str, dict[str, object]]], budget: int = 0) -> list[Trial]:
    return [
        Trial("cec2022", function, dimension, name, settings_text(**settings), budget, 0)
        for function in FUNCTIONS
        for name, settings in algorithms
    ]


def _maps(cases: Sequence[str], algorithms: Sequence[tuple[str, dict[str, object]]], budget: int = 0) -> list[Trial]:
    return [
        Trial("map", case, 3 * INNER, name, settings_text(**settings), budget, 0)
        for case in cases
        for name, settings in algorithms
    ]


CEC_D20 = Series("cec2022-d20", 30, _cec(20, [(name, {}) for name in ALGORITHMS]))
CEC_D10 = Series("cec2022-d10", 30, _cec(10, [(name, {}) for name in ALGORITHMS]))
CEC_BEYOND = Series("cec2022-d20-beyond", 30, _cec(20, [(name, {}) for name in BEYOND], BUDGET))
CEC_EQUAL = Series("cec2022-d20-equal", 15, _cec(20, list(EQUAL.items()), BUDGET))
CEC_ABLATION = Series("cec2022-d20-ablation", 20, _cec(20, [("ipoa", settings) for settings in ABLATION.values()]))

WEIGHTED = tuple(f"map-8-1/{experiment}" for experiment in WEIGHTS)

MAPS_PAPER = Series("maps", 10, _maps([*WEIGHTED, *MAPS], [(name, {}) for name in ALGORITHMS]))
MAPS_BEYOND = Series("maps-beyond", 10, _maps(MAPS, [(name, {}) for name in BEYOND], BUDGET))
MAPS_ABLATION = Series("maps-ablation", 10, _maps(MAPS, [("ipoa", settings) for settings in ABLATION.values()]))

CAMPUS = Series(
    "campus", 20, [Trial("campus", "campus", 3 * INNER, name, "{}", 0, 0) for name in (*ALGORITHMS, BEYOND[0])]
)
