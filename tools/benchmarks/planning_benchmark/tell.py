"""Make tables in Markdown and pictures, each a pure function of the rows."""

from collections.abc import Callable, Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ipoa_mission.report import palette
from ipoa_mission.report.plots import STYLE
from tools.benchmarks.planning_benchmark.maps import MAPS, benchmark_map
from tools.benchmarks.planning_benchmark.rows import Row

COMPARED = ("planner", "ompl", "printed", "reference")  # parts with the same cost on the same maps


def tables(rows: Sequence[Row]) -> dict[str, str]:
    told = {
        "methods": methods(rows),
        "maps": each_map(rows),
        "speed": speed(rows),
        "length": lengths(rows),
        "versions": versions(rows),
    }
    return {title: table for title, table in told.items() if table}


def methods(rows: Sequence[Row]) -> str:
    """Compare cost over the reference, and CPU time, of every method on all its maps."""
    best, lines = least(rows), []
    for method, setting in _methods(rows):
        runs = [
            row
            for row in rows
            if row.part in COMPARED and row.map in best and row.method == method and setting in ("", row.setting)
        ]
        over = np.array([row.cost / best[row.map] for row in runs if row.safe and row.cost is not None])
        if not runs:
            continue
        seconds = np.median([row.cpu_s for row in runs])
        safe = f"{len(over)} of {len(runs)}"
        if len(over):
            shares = (f"{np.median(over):.4f}", f"{np.quantile(over, 0.9):.4f}", f"{over.max():.4f}")
        else:
            shares = ("-", "-", "-")
        count = len({row.map for row in runs})
        lines.append((f"{method} {setting}".strip(), str(count), *shares, safe, f"{seconds:.2f}"))
    head = ("method", "maps", "cost over reference, median", "90 %", "worst", "safe", "CPU, median [s]")
    return _table(head, lines) if lines else ""


def each_map(rows: Sequence[Row]) -> str:
    """Compare by map: the reference, our planner, and OMPL's best after each time."""
    best, lines = least(rows), []
    for map_ in dict.fromkeys([*MAPS, *(row.map for row in rows if row.part == "planner")]):
        ours = [row for row in rows if (row.part, row.map) == ("planner", map_)]
        if not ours:
            continue
        costs = [row.cost for row in ours if row.cost is not None]
        line = [map_, f"{best[map_]:.2f}" if map_ in best else "-", f"{np.median(costs):.2f}" if costs else "-"]
        line.append(f"{max(costs):.2f}" if len(costs) == len(ours) else "none")
        for setting in ("1 s", "5 s"):
            theirs = [row for row in rows if (row.part, row.map, row.setting) == ("ompl", map_, setting) and row.safe]
            winner = min(theirs, key=lambda row: row.cost or np.inf, default=None)
            line.append("-" if winner is None else f"{winner.cost:.2f} ({winner.method})")
        line.append(f"{np.median([row.cpu_s for row in ours]):.2f}")
        lines.append(tuple(line))
    head = ("map", "reference", "ours, median", "ours, worst", "OMPL, 1 s", "OMPL, 5 s", "our CPU [s]")
    return _table(head, lines) if lines else ""


def speed(rows: Sequence[Row]) -> str:
    """Compare IPOA and POA as printed with mealpy's POA."""
    lines = []
    slow = [row.cpu_s for row in rows if row.method == "mealpy poa"]
    for method in ("ipoa", "poa", "mealpy poa"):
        runs = [row for row in rows if (row.part, row.method) == ("printed", method)]
        if runs:
            seconds = float(np.median([row.cpu_s for row in runs]))
            ratio = f"{np.median(slow) / seconds:.0f}" if slow else "-"
            lines.append((method, runs[0].setting, f"{seconds:.2f}", ratio))
    return _table(("search", "", "CPU, median [s]", "times as fast as mealpy's POA"), lines) if lines else ""


def lengths(rows: Sequence[Row]) -> str:
    """Compare lengths where only length counts."""
    rows = [row for row in rows if row.part == "length"]
    lines = []
    for map_ in dict.fromkeys(row.map for row in rows):
        here = [row for row in rows if row.map == map_ and row.length_m is not None]
        ours = [row.length_m for row in here if row.method == "planner" and row.length_m]
        shortest = min(row.length_m for row in here if row.length_m)
        if ours:
            over = f"{max(ours) / shortest:.4f}"
            lines.append((map_.partition("/")[0], f"{shortest:.2f}", f"{np.median(ours):.2f}", over))
    return _table(("map", "shortest [m]", "ours, median [m]", "ours, worst over shortest"), lines) if lines else ""


def versions(rows: Sequence[Row]) -> str:
    lines = [
        (part, " ".join(sorted({row.date for row in rows if row.part == part})), made)
        for part, made in dict.fromkeys((row.part, row.versions) for row in rows)
    ]
    return _table(("rows", "date", "versions"), lines)


def least(rows: Sequence[Row]) -> dict[str, float]:
    """Return the cost of the best safe path of any method on each map with a reference."""
    best = {row.map: np.inf for row in rows if row.part == "reference"}
    for row in rows:
        if row.map in best and row.part in COMPARED and row.safe and row.cost is not None:
            best[row.map] = min(best[row.map], row.cost)
    return best


def pictures(rows: Sequence[Row]) -> dict[str, Figure]:
    """Plot the detour's cost and CPU time against obstacles, map size and control points."""
    numbers: dict[str, Callable[[Row], float]] = {
        "obstacles": lambda row: float(row.map.split("-")[1]),
        "map size": lambda row: float(row.map.split("-")[2]),
        "control points": lambda row: float(row.map.partition("/")[2]),
    }
    titles = {"obstacles": "masts", "map size": "side of a map with 100 masts [m]", "control points": "control points"}
    if not {row.part for row in rows} >= set(numbers):
        return {}
    with matplotlib.rc_context(dict(STYLE)):
        figure = Figure(figsize=(7.2, 4.2), layout="constrained")
        axes = figure.subplots(2, 3, sharex="col")
        for column, (part, number) in enumerate(numbers.items()):
            runs = [row for row in rows if row.part == part and row.cost is not None]
            at = sorted({number(row) for row in runs})
            cost, seconds = axes[0][column], axes[1][column]
            for axis, value in ((cost, _per_meter(part)), (seconds, lambda row: row.cpu_s)):
                values = [[value(row) for row in runs if number(row) == x] for x in at]
                middle = [float(np.median(each)) for each in values]
                axis.fill_between(
                    at, [min(v) for v in values], [max(v) for v in values], color=palette.SKY_BLUE, alpha=0.4
                )
                axis.plot(at, middle, color=palette.BLUE, marker="o", markersize=3)
                axis.grid(alpha=0.3)
            cost.set_xscale("log")
            cost.set_xticks(at[::2], [f"{x:g}" for x in at[::2]])
            cost.set_xticks([], minor=True)
            cost.ticklabel_format(axis="y", useOffset=False)
            seconds.set_ylim(bottom=0)
            seconds.set_xlabel(titles[part])
        axes[0][0].set_ylabel("cost over that of\nthe straight line")
        axes[0][2].set_ylabel("cost")
        axes[1][0].set_ylabel("CPU [s]")
    return {"scaling": figure}


def _per_meter(part: str) -> Callable[[Row], float]:
    def value(row: Row) -> float:
        assert row.cost is not None
        if part == "control points":
            return row.cost
        scenario = benchmark_map(row.map)
        return row.cost / (scenario.cost.omega[0] * float(np.linalg.norm(scenario.goal_point - scenario.start_point)))

    return value


def _methods(rows: Sequence[Row]) -> list[tuple[str, str]]:
    found = [("planner", "")] if any(row.part == "planner" for row in rows) else []
    found += list(dict.fromkeys((row.method, row.setting) for row in rows if row.part == "ompl"))
    found += [(name, "") for name in ("ipoa", "poa", "mealpy poa") if any(row.method == name for row in rows)]
    return sorted(found, key=lambda each: (each[0] != "planner", each[1]))


def _table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    rule = "|" + "---|" * len(head)
    return "\n".join(["| " + " | ".join(head) + " |", rule, *("| " + " | ".join(line) + " |" for line in lines)])
