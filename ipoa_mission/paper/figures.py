"""Draw Figures 3, 5 and 7 to 11 as SVG; the same rows give the same bytes."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from ipoa_mission import Scenario
from ipoa_mission.optimize.ipoa import iterate_chaotic_map
from ipoa_mission.paper.problems import FUNCTIONS, OPTIMA
from ipoa_mission.paper.runs import ALGORITHMS, CHECKPOINTS, TrialRow, results
from ipoa_mission.planning.spline import Spline

#: distinct with color blindness (Okabe and Ito)
COLORS = dict(zip(ALGORITHMS, ("#D55E00", "#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"), strict=True))


def figure_3() -> str:
    z = iterate_chaotic_map(0.7, 300, 1, np.random.default_rng(3))[:, 0]
    figure, (left, right) = panels_of(1, 2, 9, 3.2)
    left.plot(np.arange(1, 301), z, ".", ms=3, color=COLORS["ipoa"])
    left.set(xlabel="iteration", ylabel="z", title="300 iterates, a = 0.7")
    right.hist(z, bins=30, color=COLORS["dbo"], edgecolor="white", linewidth=0.3)
    right.set(xlabel="z", ylabel="count", title="their distribution", xticks=[-1, -0.5, 0, 0.5, 1])
    return draw_svg(figure)


def figure_5() -> str:
    from scipy import stats

    x = np.linspace(-5, 5, 501)
    figure, (axes,) = panels_of(1, 1, 6, 3.6)
    axes.plot(x, stats.cauchy.pdf(x), label="Cauchy, t(1)", color=COLORS["dbo"])
    axes.plot(x, stats.t.pdf(x, 5), label="t(5)", color=COLORS["ipoa"])
    axes.plot(x, stats.t.pdf(x, 30), label="t(30)", color=COLORS["mpoa"])
    axes.plot(x, stats.norm.pdf(x), "--", label="Gauss", color="black")
    axes.set(xlabel="x", ylabel="density")
    axes.legend()
    return draw_svg(figure)


def figure_7(rows: Sequence[TrialRow]) -> str:
    figure, panels = panels_of(3, 4, 14, 9)
    for axes, function, optimum in zip(panels, FUNCTIONS, OPTIMA, strict=True):
        for name in ALGORITHMS:
            curves = [r.history for r in rows if (r.trial.case, r.trial.algorithm) == (function, name)]
            mean = np.maximum(np.mean(curves, axis=0), 1e-8)
            axes.semilogy(CHECKPOINTS, mean, color=COLORS[name], label=name.upper(), lw=1.2)
        axes.set(title=f"{function} (optimum {optimum:g})")
        _plain_log_ticks(axes)
        axes.grid(alpha=0.25)
    for axes in panels[8:]:
        axes.set(xlabel="share of the evaluations")
    for axes in panels[::4]:
        axes.set(ylabel="mean error")
    legend_of_all(figure, panels[0])
    return draw_svg(figure)


def figure_8(rows: Sequence[TrialRow]) -> str:
    figure, panels = panels_of(3, 4, 14, 9)
    for axes, function, optimum in zip(panels, FUNCTIONS, OPTIMA, strict=True):
        samples = [results(rows, function, name) + optimum for name in ALGORITHMS]
        boxes = axes.boxplot(samples, patch_artist=True, flierprops={"markersize": 2}, medianprops={"color": "black"})
        for box, name in zip(boxes["boxes"], ALGORITHMS, strict=True):
            box.set_facecolor(COLORS[name])
        axes.set_xticks(range(1, len(ALGORITHMS) + 1), [name.upper() for name in ALGORITHMS], fontsize=7)
        if max(s.max() for s in samples) > 20 * optimum:
            axes.set_yscale("log")
            _plain_log_ticks(axes)
        axes.grid(axis="y", alpha=0.25)
        axes.set(title=f"{function} (optimum {optimum:g})")
    for axes in panels[::4]:
        axes.set(ylabel="cost")
    return draw_svg(figure)


def panels_of(down: int, across: int, width: float, height: float) -> tuple[Any, Sequence[Any]]:
    """Return a figure of `width` by `height` inches and its axes, row by row; without pyplot, nothing is global."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(np.ravel(figure.subplots(down, across)))


def legend_of_all(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)


def _plain_log_ticks(axes: Any) -> None:
    """Label 60, 200, 1000; powers only where they are shorter."""
    from matplotlib.ticker import LogFormatter

    axes.yaxis.set_major_formatter(LogFormatter())
    axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(1.5, 0.5)))
    axes.tick_params(axis="y", which="both", labelsize=8)


def draw_svg(figure: Any) -> str:
    import matplotlib as mpl

    text = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "ipoa-mission", "svg.fonttype": "none"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def paths_on_maps(rows: Sequence[TrialRow], scenarios: dict[str, Scenario]) -> str:
    figure, panels = panels_of(len(scenarios), 2, 11, 4.6 * len(scenarios))
    for (case, scenario), above, front in zip(scenarios.items(), panels[::2], panels[1::2], strict=True):
        _draw_world(above, front, scenario)
        for name in ALGORITHMS:
            trials = (row for row in rows if (row.trial.case, row.trial.algorithm) == (case, name))
            best = min(trials, key=lambda row: row.cost)
            control = np.array(best.measures["control"], dtype=np.float64).reshape(-1, 3)
            path = Spline(control).points(np.linspace(0, 1, 300))
            style = "-" if best.measures["feasible"] else ":"
            above.plot(path[:, 0], path[:, 1], style, color=COLORS[name], lw=1.4, zorder=3)
            front.plot(path[:, 0], path[:, 2], style, color=COLORS[name], lw=1.4, zorder=3)
            above.plot([], [], "-", color=COLORS[name], label=name.upper())
        above.set(title=f"{case}, from above", xlabel="east [m]", ylabel="north [m]", aspect="equal")
        front.set(title=f"{case}, from the south", xlabel="east [m]", ylabel="up [m]")
    legend_of_all(figure, panels[0])
    return draw_svg(figure)


def _draw_world(above: Any, front: Any, scenario: Scenario) -> None:
    bounds = scenario.airspace.bounds
    east = np.linspace(bounds.lower[0], bounds.upper[0], 121)
    north = np.linspace(bounds.lower[1], bounds.upper[1], 121)
    grid = np.stack(np.meshgrid(east, north), axis=-1)
    ground = scenario.airspace.ground(grid.reshape(-1, 2)).reshape(121, 121)
    extent = (east[0], east[-1], north[0], north[-1])
    above.imshow(ground, extent=extent, origin="lower", cmap="Greens", alpha=0.7, interpolation="none")
    front.fill_between(east, ground.max(axis=0), ground.min(), color="0.85")
    for body in scenario.airspace.obstacles:
        above.fill(*body.outline()[0].T, color="0.4")
        front.fill(*body.silhouette(0).T, facecolor="0.3", edgecolor="0.4", alpha=0.35)
