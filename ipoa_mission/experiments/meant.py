"""What the paper must have meant, in sentences: every number in them is computed from rows."""

from collections.abc import Sequence

import numpy as np

from ipoa_mission.experiments import published
from ipoa_mission.experiments.paper import (
    contradictions,
    dimension_of_the_print,
    errors,
    mean_log_error,
    off_the_print,
    widest_sd,
)
from ipoa_mission.experiments.paper_maps import mean_over_maps
from ipoa_mission.experiments.rows import Row, Rows, settings_text
from ipoa_mission.experiments.runs import CHECKPOINTS
from ipoa_mission.experiments.series import (
    CEC_ABLATION,
    CEC_D10,
    CEC_D20,
    MAPS_PAPER,
)


def meant(rows: Rows) -> list[str]:
    """Sentences, from the rows of every series by its name."""
    return [
        *_by_its_formulas(rows[CEC_ABLATION.name]),
        *_by_its_numbers(rows[CEC_D20.name], rows[CEC_D10.name]),
        *_by_its_measures(rows[MAPS_PAPER.name]),
    ]


def _by_its_formulas(rows: Sequence[Row]) -> list[str]:
    literal, best = (
        mean_log_error(rows, "ipoa", settings_text(**s)) for s in ({"reading": "literal"}, {"prey": "best"})
    )
    default = mean_log_error(rows, "ipoa")
    off, off_literal = off_the_print(rows), off_the_print(rows, settings=settings_text(reading="literal"))
    return [
        "Eq. (27) multiplies the whole position by (1 + s), with s from a heavy-tailed distribution. Read so, IPOA "
        f"comes to a mean log10 error of {literal:.2f}; with the factor on the exploitation step alone, to "
        f"{default:.2f}. From the printed means the first is off by {off_literal:.2f} and the second by {off:.2f} "
        "(mean of |ln(ours / printed)|); the second is the default here.",
        "The prey is the best position in the words of section 4.3 and a random one in Algorithm 1. A random member "
        f"gives {default:.2f}, the best gives {best:.2f}; the default is the random member, as in POA.",
    ]


def _by_its_numbers(rows: Sequence[Row], rows_10: Sequence[Row]) -> list[str]:
    nearer_10 = [row[0] for row in dimension_of_the_print(rows, rows_10).rows if "D = 10" in row[-1]]
    at_20, at_10 = (errors(some, "f4", "poa").mean() + 800 for some in (rows, rows_10))
    pairs = contradictions().rows
    proved = [f"{row[0]} against {row[1]}" for row in pairs if "<" in row[-1]]
    f7 = published.TABLE_3["f7"]
    return [
        f"**Some rows of Table 3 look like D = 10**: {', '.join(nearer_10)} lie nearer to it than to D = 20; others "
        f"only D = 20 can give. POA's f4, {published.TABLE_3['f4']['mean'][2]} in print, comes to {at_20:.1f} at "
        f"D = 20 and to {at_10:.1f} at D = 10.",
        f"**Table 4 does not belong to Table 3**: {len(pairs)} pairs whose printed means lie more than six standard "
        f"errors apart have printed p values above 0.05; for {len(proved)} of them ({', '.join(proved)}) arithmetic "
        "alone shows that the samples cannot even overlap.",
        f"POA's SD on f7, {f7['sd'][2]} in print, must be 28.35: with that mean and that best it cannot be above "
        f"{widest_sd(f7, 2):.0f}, and the place printed beside it, 4, is that of 28.35.",
    ]


def _by_its_measures(rows: Sequence[Row]) -> list[str]:
    smooth = [mean_over_maps(rows, name, "turn_smooth") for name in published.ALGORITHMS]
    corner = [mean_over_maps(rows, name, "turn") for name in published.ALGORITHMS]
    tables = [*published.TABLE_6.values(), *published.TABLE_7.values()]
    printed = {measure: [value for table in tables for value in table[measure]] for measure in ("turn", "iterations")}
    ours = [mean_over_maps(rows, name, "iterations") for name in published.ALGORITHMS]
    early = int(np.argmin(np.abs(CHECKPOINTS - 0.08)))
    still = [row.history[early] / row.cost - 1 for row in rows if row.trial.algorithm in published.ALGORITHMS]
    return [
        f"Turn, {min(printed['turn']):.0f}° to {max(printed['turn']):.0f}° in print, can only be the angle between "
        f"legs of the control points: there it is {min(corner):.0f}° to {max(corner):.0f}° here, and between a hundred "
        f"nodes of the smooth curve {min(smooth):.0f}° to {max(smooth):.0f}°.",
        f"Iterations, {min(printed['iterations']):.0f} to {max(printed['iterations']):.0f} of a thousand in print, are "
        "not defined. By our definition, the first within 1 % of the last cost, the six need "
        f"{min(ours):.0f} to {max(ours):.0f}. At the eightieth iteration half of our runs are still more than "
        f"{np.median(still):.0%} above what they end with: the paper counts something looser, or its costs stall "
        "earlier.",
    ]
