"""What of the paper came out, in sentences: every number in them is computed from rows."""

from collections.abc import Sequence

from ipoa_mission.experiments import published
from ipoa_mission.experiments.maps import MAPS
from ipoa_mission.experiments.paper import (
    ipoa_against,
    mean_log_error,
)
from ipoa_mission.experiments.paper_maps import mean_over_maps, on_length, table_improvements
from ipoa_mission.experiments.rows import Row, Rows, settings_text
from ipoa_mission.experiments.series import (
    CEC_D20,
    CEC_EQUAL,
    EQUAL,
    MAPS_PAPER,
)
from ipoa_mission.experiments.tables import per_cent


def came_out(rows: Rows) -> list[str]:
    """Sentences, from the rows of every series by its name."""
    return [
        *_on_functions(rows[CEC_D20.name], rows[CEC_EQUAL.name]),
        *_on_maps(rows[MAPS_PAPER.name]),
    ]


def _on_functions(rows: Sequence[Row], equal: Sequence[Row]) -> list[str]:
    signs = ipoa_against(rows)
    score = {name: mean_log_error(rows, name) for name in ("ipoa", "poa")}
    alike = {name: mean_log_error(equal, name, settings_text(**EQUAL[name])) for name in ("ipoa", "poa")}
    every = [sign for found in signs.values() for sign in found]
    does = "does improve" if score["ipoa"] < score["poa"] else "does not improve"
    printed = [p for found in published.TABLE_4.values() for p in found]
    return [
        f"**IPOA {does} on POA**, the algorithm that it is made from: mean log10 error {score['ipoa']:.2f} "
        f"against {score['poa']:.2f}; it is told to be better on {signs['poa'].count('+')} of the twelve functions and "
        f"worse on {signs['poa'].count('-')}. It spends half as many evaluations again for it; where both are given "
        f"90,060, it is {alike['ipoa']:.2f} against {alike['poa']:.2f}.",
        f"**Of sixty comparisons with its five rivals IPOA wins {every.count('+')}**, loses {every.count('-')}, and "
        f"{every.count('=')} are not told apart (rank-sum, Holm over all sixty); the losses are to "
        + ", ".join(f"{name.upper()} ({found.count('-')})" for name, found in signs.items() if "-" in found)
        + f". In print {sum(p < 0.05 for p in printed)} of the sixty have p < 0.05, uncorrected.",
    ]


def _on_maps(rows: Sequence[Row]) -> list[str]:
    length = {name: mean_over_maps(rows, name, "distance") for name in published.ALGORITHMS}
    gains = [claims["poa"][0] for where, claims in published.IMPROVEMENTS.items() if where != "Table 8"]
    signs = on_length(rows, list(MAPS))["poa"]
    cells = [cell for row in table_improvements().rows for cell in row[2:] if cell]
    return [
        f"**On random maps of the paper's size**, by the paper's own method, IPOA's paths are {length['ipoa']:.0f} m "
        f"on average and POA's {length['poa']:.0f} m ({per_cent(length['ipoa'], length['poa'])}; in print "
        f"-{min(gains):.0f} % to -{max(gains):.0f} %). That is a mean: of the seven maps a test tells them apart on "
        f"{len(signs) - signs.count('=')} (shorter on {signs.count('+')}).",
        f"Of the {len(cells)} percentages that the text draws from its own tables, "
        f"{sum('!' not in cell for cell in cells)} follow from them.",
    ]
