"""What the sentences of the page of findings stand on: every number in them by name, from the rows of runs.

The sentences themselves are in `findings.md`. Each begins with the name of one of `signs`: what its words take for
granted about the numbers.
"""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from ipoa_mission.experiments import published
from ipoa_mission.experiments.beyond import OURS, ours_against, ours_against_on_maps, table_ablation
from ipoa_mission.experiments.cec2022 import FUNCTIONS
from ipoa_mission.experiments.figures import chaotic_iterates
from ipoa_mission.experiments.maps import MAPS
from ipoa_mission.experiments.paper import (
    contradictions,
    dimension_of_the_print,
    firsts,
    ipoa_against,
    mean_log_error,
    off_the_print,
    printed_firsts,
    widest_sd,
)
from ipoa_mission.experiments.paper_maps import mean_over_maps, on_length, table_improvements
from ipoa_mission.experiments.published import ALGORITHMS
from ipoa_mission.experiments.rows import Row, Rows, mean_evaluations, results, settings_text
from ipoa_mission.experiments.runs import CHECKPOINTS
from ipoa_mission.experiments.series import (
    BEYOND,
    CAMPUS,
    CEC_ABLATION,
    CEC_BEYOND,
    CEC_D10,
    CEC_D20,
    CEC_EQUAL,
    EQUAL,
    MAPS_BEYOND,
    MAPS_PAPER,
)
from ipoa_mission.experiments.statistics import places
from ipoa_mission.experiments.tables import per_cent

Facts: TypeAlias = dict[str, float | str]


def facts(rows: Rows) -> Facts:
    """Every number, and every list of names, in the page's sentences; `rows` are those of every series by its name."""
    d20, maps = rows[CEC_D20.name], rows[MAPS_PAPER.name]
    return (
        _on_functions(d20, rows[CEC_EQUAL.name])
        | _of_the_print(d20)
        | _of_the_text()
        | _at_ten_dimensions(d20, rows[CEC_D10.name])
        | _of_strategies_and_readings(rows[CEC_ABLATION.name])
        | _beyond(rows[CEC_BEYOND.name], d20)
        | _on_maps([*maps, *rows[MAPS_BEYOND.name]])
        | _of_measures(maps)
        | _on_the_campus(rows[CAMPUS.name])
        | _of_chaos()
    )


def signs(f: Mapping[str, float | str]) -> dict[str, bool]:
    """For each sentence, by the name that it begins with: whether the facts are as its words say."""
    n = {name: value for name, value in f.items() if not isinstance(value, str)}
    return {
        "improves_on_poa": n["score_ipoa"] < n["score_poa"]
        and n["equal_ipoa"] < n["equal_poa"]
        and n["better_than_poa"] > n["worse_than_poa"],
        "wins_more_than_it_loses": n["wins"] > n["losses"] > 0,
        "shorter_on_average": n["length_ipoa"] < n["length_poa"] and n["maps_told"] < len(MAPS) / 2,
        "most_percentages_follow": n["percentages"] / 2 < n["percentages_that_follow"] < n["percentages"],
        "fewer_firsts_than_printed": n["first_means"] < n["printed_first_means"]
        and n["firsts"] < n["printed_firsts"]
        and bool(f["ahead_of_ipoa"]),
        "no_column_met": f["columns_met"] == "none",
        "fewer_lowest_medians": n["lowest_medians"] < 7 and f["functions_of_shortest_box"] == "none",
        "mpoa_leads_at_equal_budget": str(f["equal_scores"]).startswith("MPOA") and n["evaluations_of_a_rival"] > 1,
        "without_all_four_is_worse": bool(f["strategies"]) and n["without_all_worse"] > n["without_all_better"],
        "none_is_near": max(n["score_rcmaes"], n["score_lshade"], n["score_ours"]) < n["best_of_six"] - 1,
        "others_are_shorter": n["shortest_length"] < n["length_ipoa"] and n["cheapest_cost"] < n["cost_ipoa"],
        "many_paths_touch": min(n["touching_ipoa"], n["touching_poa"]) > n["touching_ours"]
        and n["maps_cmaes_better"] > n["maps_cmaes_worse"],
        "few_can_be_flown": max(n["flown_ipoa"], n["flown_poa"]) < n["flown_ours"],
        "exploitation_alone_is_nearer": n["off_default"] < n["off_literal"] and n["score_default"] < n["score_literal"],
        "random_prey_is_better": n["score_default"] < n["score_best_prey"],
        "poa_f4_is_nearer_at_10": abs(n["poa_f4_at_10"] - n["printed_poa_f4"])
        < abs(n["poa_f4_at_20"] - n["printed_poa_f4"])
        and bool(f["nearer_at_10"]),
        "tables_contradict": n["contradicting"] > n["proved"] > 0,
        "printed_sd_is_impossible": n["printed_poa_f7_sd"] > n["widest_poa_f7_sd"] > 28.35,
        "turn_is_of_control_points": n["most_smooth_turn"] < n["printed_least_turn"] < n["most_turn"],
        "searches_go_on": n["least_iterations"] > n["printed_most_iterations"] and n["above_the_end"] > 0.1,
    }


def _on_functions(rows: Sequence[Row], equal: Sequence[Row]) -> Facts:
    against = ipoa_against(rows)
    every = [sign for outcomes in against.values() for sign in outcomes]
    score = {name: mean_log_error(rows, name) for name in ALGORITHMS}
    alike = {name: mean_log_error(equal, name, settings_text(**wanted)) for name, wanted in EQUAL.items()}
    spent = {name: mean_evaluations(rows, name) for name in ALGORITHMS}
    return {
        "score_ipoa": score["ipoa"],
        "score_poa": score["poa"],
        "best_of_six": min(score.values()),
        "ahead_of_ipoa": " and ".join(f"{n.upper()} ({s:.2f})" for n, s in score.items() if s < score["ipoa"]),
        "equal_ipoa": alike["ipoa"],
        "equal_poa": alike["poa"],
        "equal_scores": ", ".join(f"{n.upper()} {s:.2f}" for n, s in sorted(alike.items(), key=lambda pair: pair[1])),
        "evaluations_of_a_rival": spent["ipoa"] / min(spent.values()),
        "better_than_poa": against["poa"].count("+"),
        "worse_than_poa": against["poa"].count("-"),
        "wins": every.count("+"),
        "losses": every.count("-"),
        "ties": every.count("="),
        "losses_to": ", ".join(
            f"{name.upper()} ({outcomes.count('-')})" for name, outcomes in against.items() if "-" in outcomes
        ),
        "printed_small_p": sum(p < 0.05 for outcomes in published.TABLE_4.values() for p in outcomes),
    }


def _of_the_print(rows: Sequence[Row]) -> Facts:
    apart = {name: off_the_print(rows, name) for name in ALGORITHMS}
    met = [name.upper() for name, value in apart.items() if value < np.log(1.25)]
    return {
        "first_means": sum(places([results(rows, f, a).mean() for a in ALGORITHMS])[0] == 1 for f in FUNCTIONS),
        "printed_first_means": sum(places(published.TABLE_3[f]["mean"])[0] == 1 for f in FUNCTIONS),
        "firsts": firsts(rows),
        "printed_firsts": printed_firsts(),
        "columns_met": ", ".join(met) or "none",
        "off_the_print": ", ".join(f"{name.upper()} {value:.2f}" for name, value in apart.items()),
    }


def _of_the_text() -> Facts:
    """What the print says of itself."""
    cells = [cell for row in table_improvements().rows for cell in row[2:] if cell]
    gains = [claims["poa"][0] for where, claims in published.IMPROVEMENTS.items() if where != "Table 8"]
    pairs = contradictions().rows
    proved = [f"{row[0]} against {row[1]}" for row in pairs if "<" in row[-1]]
    f7 = published.TABLE_3["f7"]
    return {
        "percentages": len(cells),
        "percentages_that_follow": sum("!" not in cell for cell in cells),
        "least_gain": min(gains),
        "most_gain": max(gains),
        "contradicting": len(pairs),
        "proved": len(proved),
        "proved_pairs": ", ".join(proved),
        "printed_poa_f4": published.TABLE_3["f4"]["mean"][2],
        "printed_poa_f7_sd": f7["sd"][2],
        "widest_poa_f7_sd": widest_sd(f7, 2),
    }


def _at_ten_dimensions(rows: Sequence[Row], rows_10: Sequence[Row]) -> Facts:
    lowest = [f for f in FUNCTIONS if places([np.median(results(rows_10, f, a)) for a in ALGORITHMS])[0] == 1]
    narrowest = [f for f in FUNCTIONS if places([_box(rows_10, f, a) for a in ALGORITHMS])[0] == 1]
    at_20, at_10 = (float(results(some, "f4", "poa").mean() + 800) for some in (rows, rows_10))
    return {
        "lowest_medians": len(lowest),
        "functions_of_lowest_median": ", ".join(lowest) or "none",
        "functions_of_shortest_box": ", ".join(narrowest) or "none",
        "nearer_at_10": ", ".join(r[0] for r in dimension_of_the_print(rows, rows_10).rows if "D = 10" in r[-1]),
        "poa_f4_at_20": at_20,
        "poa_f4_at_10": at_10,
    }


def _box(rows: Sequence[Row], function: str, name: str) -> float:
    """The length of the box in a box plot: from the first quartile to the third."""
    return float(np.subtract(*np.percentile(results(rows, function, name), [75, 25])))


def _of_strategies_and_readings(rows: Sequence[Row]) -> Facts:
    table = table_ablation(rows)
    column = next(k for k, words in enumerate(table.heading) if words.startswith("better"))
    counts_without = {row[0]: row[column] for row in table.rows if row[0].startswith("without ")}
    better, _, worse = (int(count) for count in counts_without["without all four"].split(" / "))
    return {
        "strategies": "; ".join(f"{label} {counts}" for label, counts in counts_without.items()),
        "without_all_better": better,
        "without_all_worse": worse,
        "score_default": mean_log_error(rows, "ipoa"),
        "score_literal": mean_log_error(rows, "ipoa", settings_text(reading="literal")),
        "score_best_prey": mean_log_error(rows, "ipoa", settings_text(prey="best")),
        "off_default": off_the_print(rows),
        "off_literal": off_the_print(rows, settings=settings_text(reading="literal")),
    }


def _beyond(rows: Sequence[Row], paper: Sequence[Row]) -> Facts:
    score = {name: mean_log_error(rows, name) for name in BEYOND}
    cmaes = ours_against(rows, paper)["rcmaes"]
    pairs = [(results(rows, f, OURS).mean(), results(rows, f, "rcmaes").mean()) for f in FUNCTIONS]
    return {
        "ours": OURS,
        "score_ours": score[OURS],
        "score_rcmaes": score["rcmaes"],
        "score_lshade": score["lshade"],
        "score_de": score["de"],
        "better_than_cmaes": cmaes.count("+"),
        "worse_than_cmaes": cmaes.count("-"),
        "ahead_of_cmaes": sum(bool(ours < theirs) for ours, theirs in pairs),
    }


def _on_maps(rows: Sequence[Row]) -> Facts:
    length = {name: mean_over_maps(rows, name, "distance") for name in ALGORITHMS}
    cost = {name: mean_over_maps(rows, name) for name in ALGORITHMS}
    shortest, cheapest = min(length, key=length.__getitem__), min(cost, key=cost.__getitem__)
    against_poa, cmaes = on_length(rows, list(MAPS))["poa"], ours_against_on_maps(rows)["rcmaes"]
    return {
        "length_ipoa": length["ipoa"],
        "length_poa": length["poa"],
        "shorter_than_poa": per_cent(length["ipoa"], length["poa"]),
        "maps_told": len(against_poa) - against_poa.count("="),
        "maps_shorter": against_poa.count("+"),
        "shortest": shortest.upper(),
        "shortest_length": length[shortest],
        "cheapest": cheapest.upper(),
        "cheapest_cost": cost[cheapest],
        "cost_ipoa": cost["ipoa"],
        "cost_ours": mean_over_maps(rows, OURS),
        "touching_ipoa": 1 - mean_over_maps(rows, "ipoa", "feasible"),
        "touching_poa": 1 - mean_over_maps(rows, "poa", "feasible"),
        "touching_ours": 1 - mean_over_maps(rows, OURS, "feasible"),
        "maps_cmaes_better": cmaes.count("-"),
        "maps_cmaes_worse": cmaes.count("+"),
    }


def _of_measures(rows: Sequence[Row]) -> Facts:
    facts_of_measures: Facts = {}
    tables = [*published.TABLE_6.values(), *published.TABLE_7.values()]
    for measure in ("turn", "iterations"):
        printed = [value for table in tables for value in table[measure]]
        facts_of_measures |= {f"printed_least_{measure}": min(printed), f"printed_most_{measure}": max(printed)}
    for name, measure in (("turn", "turn"), ("smooth_turn", "turn_smooth"), ("iterations", "iterations")):
        ours = [mean_over_maps(rows, algorithm, measure) for algorithm in ALGORITHMS]
        facts_of_measures |= {f"least_{name}": min(ours), f"most_{name}": max(ours)}
    early = int(np.argmin(np.abs(CHECKPOINTS - 0.08)))
    still = [row.history[early] / row.cost - 1 for row in rows if row.trial.algorithm in ALGORITHMS]
    return facts_of_measures | {"above_the_end": float(np.median(still))}


def _on_the_campus(rows: Sequence[Row]) -> Facts:
    def mean(name: str, measure: str) -> str:
        values = [row.measures.get(measure) for row in rows if row.trial.algorithm == name]
        measured = [value for value in values if isinstance(value, float)]
        return f"{np.mean(measured):.1f}" if measured else "no"

    facts_of_campus: Facts = {}
    for called, name in (("ipoa", "ipoa"), ("poa", "poa"), ("ours", OURS)):
        facts_of_campus |= {
            f"campus_length_{called}": mean(name, "distance"),
            f"campus_time_{called}": mean(name, "time"),
        }
        flown = sum(row.measures.get("flyable") == 1 for row in rows if row.trial.algorithm == name)
        facts_of_campus[f"flown_{called}"] = flown
    return facts_of_campus


def _of_chaos() -> Facts:
    size = np.abs(chaotic_iterates(1000))
    return {"chaotic_outer": float(np.mean(size > 0.9)), "chaotic_inner": float(np.mean(size < 0.1))}
