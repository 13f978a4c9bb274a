import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ipoa_mission.geometry import Points
from ipoa_mission.report import palette
from ipoa_mission.report.compare import Comparison
from ipoa_mission.report.number_format import signed
from ipoa_mission.report.plots import sheet

MAX_LABELS = 30


def draw_comparison(comparison: Comparison, planned: Points, flown: Points | None, title: str = "") -> Figure:
    """Paths are (n, 3)."""
    with sheet(9.2, 3.8) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.5))
        _draw_paths(left, planned, flown)
        _draw_legs(right, comparison)
        words = ["path estimated", *(["path flown"] if flown is not None else []), "time estimated", "time flown"]
        figure.legend([*left.lines, *right.containers], words, loc="outside lower center", ncols=4, frameon=False)
        if title:
            figure.suptitle(title, fontsize=10)
    return figure


def _draw_paths(axes: Axes, planned: Points, flown: Points | None) -> None:
    axes.plot(planned[:, 0], planned[:, 1], color=palette.BLUE, linewidth=1.6, label="estimated")
    if flown is not None:
        axes.plot(
            flown[:, 0], flown[:, 1], color=palette.VERMILLION, linewidth=1.2, linestyle=(0, (4, 2)), label="flown"
        )
    axes.set(xlabel="east [m]", ylabel="north [m]", title="from above")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(color="#E3E3E3", linewidth=0.5)


def _draw_legs(axes: Axes, comparison: Comparison) -> None:
    legs = comparison.legs
    at = np.arange(len(legs))
    axes.bar(at - 0.2, [leg.estimated_s for leg in legs], 0.38, color=palette.BLUE, label="estimated")
    axes.bar(
        at + 0.2,
        [leg.flown_s for leg in legs],
        0.38,
        color="white",
        edgecolor=palette.VERMILLION,
        hatch="////",
        linewidth=0.8,
        label="flown",
    )
    step = max(1, -(-len(legs) // MAX_LABELS))
    axes.set_xticks(at[::step], [str(leg.seq) for leg in legs[::step]])
    axes.set(xlabel="item", ylabel="time for the leg [s]", title=_words(comparison))


def _words(comparison: Comparison) -> str:
    estimated, flown = comparison.estimated_route_s, comparison.flown_route_s
    if not flown > 0:
        return "leg by leg"
    error = signed(100 * comparison.route_error, 1, "%")
    return f"route: estimated {estimated:.1f} s, flown {flown:.1f} s ({error})"
