from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from ipoa_mission.paper.problems import FUNCTIONS, INNER, MAPS, WEIGHTS
from ipoa_mission.paper.published import ALGORITHMS
from ipoa_mission.paper.rows import Trial, settings_text

Settings: TypeAlias = dict[str, object]

#: evaluations of IPOA at N = 30 and T = 1000 with all strategies
BUDGET = 90_060

BEYOND = ("adaptive-pelican", "rcmaes", "lshade", "de")

#: iterations that spend `BUDGET` at N = 30
EQUAL: dict[str, Settings] = {
    "ipoa": {"iterations": 1000},
    "dbo": {"iterations": 3001},
    "poa": {"iterations": 1501},
    "ssa": {"iterations": 2501},
    "mpoa": {"iterations": 938},
    "hho": {"iterations": 2337},
}

#: IPOA's settings, one at a time
ABLATION: dict[str, Settings] = {
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
        """`runs` None: the paper's number."""
        return [replace(t, run=run) for run in range(self.runs if runs is None else runs) for t in self.firsts]


def _trials(
    problem: str, cases: Sequence[str], dimension: int, algorithms: Sequence[tuple[str, Settings]], budget: int = 0
) -> list[Trial]:
    return [
        Trial(problem, case, dimension, name, settings_text(**settings), budget, 0)
        for case in cases
        for name, settings in algorithms
    ]


def _all_series() -> Iterator[Series]:
    papers: list[tuple[str, Settings]] = [(name, {}) for name in ALGORITHMS]
    rivals: list[tuple[str, Settings]] = [(name, {}) for name in BEYOND]
    ablation = [("ipoa", settings) for settings in ABLATION.values()]
    weighted = tuple(f"map-8-1/{experiment}" for experiment in WEIGHTS)
    yield Series("cec2022-d20", 30, _trials("cec2022", FUNCTIONS, 20, papers))
    yield Series("cec2022-d10", 30, _trials("cec2022", FUNCTIONS, 10, papers))
    yield Series("cec2022-d20-beyond", 30, _trials("cec2022", FUNCTIONS, 20, rivals, BUDGET))
    yield Series("cec2022-d20-equal", 15, _trials("cec2022", FUNCTIONS, 20, list(EQUAL.items()), BUDGET))
    yield Series("cec2022-d20-ablation", 20, _trials("cec2022", FUNCTIONS, 20, ablation))
    yield Series("maps", 10, _trials("map", (*weighted, *MAPS), 3 * INNER, papers))
    yield Series("maps-beyond", 10, _trials("map", MAPS, 3 * INNER, rivals, BUDGET))
    yield Series("maps-ablation", 10, _trials("map", MAPS, 3 * INNER, ablation))
    yield Series("campus", 20, _trials("campus", ("campus",), 3 * INNER, [*papers, rivals[0]]))


SERIES = {series.name: series for series in _all_series()}
