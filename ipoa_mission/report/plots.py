"""Pictures for papers; the same input gives the same bytes."""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TypeAlias

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.ticker import MaxNLocator

from ipoa_mission.errors import WrongSuffix
from ipoa_mission.files import write_atomically
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.report import palette
from ipoa_mission.report.ground_mesh import ground_mesh
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace

View: TypeAlias = Literal["top", "front"]

WIDTH = 3.5  # [inch]
MARKERS_PER_PATH = 8
GROUND = LinearSegmentedColormap.from_list("ground", [palette.LOW_GROUND, palette.HIGH_GROUND])
ROOFS = LinearSegmentedColormap.from_list("roofs", [palette.LOW_ROOF, palette.HIGH_ROOF])
STYLE: Mapping[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": palette.OUTLINE,
    "axes.axisbelow": True,
    "svg.hashsalt": "ipoa-mission",
    "savefig.facecolor": "white",
}


def draw_views(scenario: Scenario, paths: Mapping[str, Points], views: Sequence[View] = ("top", "front")) -> Figure:
    """Draw a scenario with paths from above and from the side, as in the paper's Figures 9-11.

    Args:
        scenario: the world.
        paths: each (n, 3) [m] under its name.
        views: `top` with north up, `front` looks north with east to the right.

    Returns:
        A matplotlib figure.

    Example:
        >>> from ipoa_mission import draw_views, estimate, read_mission, read_scenario, write_picture
        >>> flown = estimate(read_mission("missions/sitl.plan")).track.points
        >>> figure = draw_views(read_scenario("missions/sitl.toml"), {"predicted": flown}, ["top"])
        >>> write_picture(figure, "sitl.png")
    """
    draw = {"top": _draw_top, "front": _draw_front}
    with sheet(WIDTH * len(views), 3.7) as figure:
        for n, view in enumerate(views):
            axes = figure.add_subplot(1, len(views), n + 1)
            draw[view](axes, scenario.airspace, paths)
            _mark_ends(axes, scenario, (0, 1) if view == "top" else (0, 2))
        if paths:
            handles, labels = figure.axes[0].get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=min(len(paths), 6), frameon=False)
    return figure


def write_picture(figure: Figure, path: str | Path) -> None:
    """Write a figure; the same figure gives the same bytes.

    Args:
        figure: a matplotlib figure.
        path: ends in `.png`, `.svg` or `.pdf`.

    Raises:
        BadInput: another ending, or a folder that may not be written.

    Example:
        >>> from matplotlib.figure import Figure
        >>> write_picture(Figure(), "nothing.svg")
    """
    path = Path(path)
    undated: dict[str, dict[str, str | None]] = {
        ".png": {"Software": None},
        ".svg": {"Date": None, "Creator": None},
        ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    }
    if path.suffix not in undated:
        raise WrongSuffix("expected a name that ends in .png, .svg or .pdf", place=path)
    buffer = io.BytesIO()
    with matplotlib.rc_context(dict(STYLE)):
        figure.savefig(buffer, format=path.suffix[1:], metadata=undated[path.suffix])
    write_atomically(path, buffer.getvalue())


@contextmanager
def sheet(width: float, height: float) -> Iterator[Figure]:
    """Provide a figure [inch], with a rounded layout: the solver differs in the last bits from run to run."""
    with matplotlib.rc_context(dict(STYLE)):
        figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        for axes in figure.axes:
            axes.set_position(tuple(np.round(axes.get_position(original=True).bounds, 6)))


def _draw_top(axes: Axes, airspace: Airspace, paths: Mapping[str, Points]) -> None:
    east, north, up = ground_mesh(airspace, 240)
    extent = (east[0, 0], east[0, -1], north[0, 0], north[-1, 0])
    axes.imshow(
        up, extent=extent, origin="lower", cmap=GROUND, interpolation="bilinear", vmin=up.min(), vmax=_upper_limit(up)
    )
    if np.ptp(up) > 1.0:
        contours = axes.contour(east, north, up, levels=_levels(up), colors="#8C7F63", linewidths=0.4, alpha=0.7)
        axes.clabel(contours, fontsize=5, fmt="%g m")
    tops = [obstacle.bounds[1, 2] for obstacle in airspace.obstacles if obstacle.solid]
    for obstacle in sorted(airspace.obstacles, key=lambda o: float(o.bounds[1, 2])):
        shade = ROOFS(obstacle.bounds[1, 2] / max([1.0, *tops]))
        rings = [np.vstack([ring, ring[:1]]) for ring in obstacle.outline()]
        whole = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in _alternating(rings)))
        axes.add_patch(PathPatch(whole, facecolor=shade, edgecolor=palette.OUTLINE, linewidth=0.4))
    _draw_lines(axes, paths, (0, 1))
    axes.set(
        xlim=extent[:2], ylim=extent[2:], xlabel="east [m]", ylabel="north [m]", aspect="equal", title="from above"
    )


def _draw_front(axes: Axes, airspace: Airspace, paths: Mapping[str, Points]) -> None:
    east, _, up = ground_mesh(airspace, 240)
    far_first = sorted(airspace.obstacles, key=lambda o: -float(o.bounds[0, 1]))
    tops = [float(obstacle.bounds[1, 2]) for obstacle in far_first if obstacle.solid]
    shapes = PolyCollection(
        [obstacle.silhouette(0) for obstacle in far_first],
        facecolors=[ROOFS(obstacle.bounds[1, 2] / max([1.0, *tops]), alpha=0.55) for obstacle in far_first],
        edgecolors=palette.OUTLINE,
        linewidths=0.4,
    )
    axes.add_collection(shapes, autolim=False)
    least = min(float(up.min()), *(float(path[:, 2].min()) for path in paths.values()), 0.0)
    highest = max([float(up.max()), *tops, *(float(path[:, 2].max()) for path in paths.values())])
    floor = least - 0.04 * (highest - least)
    axes.fill_between(east[0], floor, up.max(axis=0), color=palette.LOW_GROUND, zorder=0)
    axes.fill_between(east[0], floor, up.min(axis=0), color=palette.HIGH_GROUND, zorder=2)
    _draw_lines(axes, paths, (0, 2))
    axes.set(xlim=(east[0, 0], east[0, -1]), ylim=(floor, highest + 0.05 * (highest - least)))
    axes.set(xlabel="east [m]", ylabel="up [m]", title="from the south")


def _draw_lines(axes: Axes, paths: Mapping[str, Points], plane: tuple[int, int]) -> None:
    for n, (name, path) in enumerate(paths.items()):
        axes.plot(*path[:, plane].T, label=name, linewidth=1.6, zorder=5, **_look(n, _marks(path)))


def _mark_ends(axes: Axes, scenario: Scenario, plane: tuple[int, int]) -> None:
    for words, point in (("start", scenario.start_point), ("goal", scenario.goal_point)):
        spot = tuple(point[list(plane)])
        axes.plot(*spot, marker="o", markersize=6, markerfacecolor="white", markeredgecolor=palette.BLACK, zorder=6)
        axes.annotate(
            words,
            spot,
            xytext=(0, 7),
            ha="center",
            textcoords="offset points",
            fontsize=7,
            zorder=7,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
        )


def _marks(path: Points) -> list[int]:
    along = arc_lengths(path)
    return sorted(set(np.searchsorted(along, np.linspace(0.06, 0.94, MARKERS_PER_PATH) * along[-1]).tolist()))


def _look(n: int, marks: list[int]) -> dict[str, Any]:
    return {
        "color": palette.PATHS[n % len(palette.PATHS)],
        "marker": palette.MARKERS[n % len(palette.MARKERS)],
        "markersize": 4,
        "markeredgecolor": "white",
        "markeredgewidth": 0.5,
        "markevery": marks,
    }


def _alternating(rings: list[Points]) -> list[Points]:
    """Orient the outer ring to the left and holes to the right, for filling by winding number."""
    left = [float((r[:-1, 0] * r[1:, 1] - r[1:, 0] * r[:-1, 1]).sum()) > 0 for r in rings]
    return [ring if left[n] == (n == 0) else ring[::-1] for n, ring in enumerate(rings)]


def _levels(up: Points) -> Vector:
    levels = MaxNLocator(8).tick_values(up.min(), up.max())
    return np.asarray(levels[(levels > up.min()) & (levels < up.max())])


def _upper_limit(up: Points) -> float:
    return max(float(up.max()), float(up.min()) + 5.0)
