"""Pictures for papers, drawn by matplotlib; the same input gives the same bytes."""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, TypeAlias

import matplotlib
import numpy as np
import shapely
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
from ipoa_mission.geometry import Points, arc_lengths
from ipoa_mission.report.drawn_flight import ground_mesh
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle


class Color(StrEnum):
    """The first seven for color-blind readers: M. Okabe and K. Ito, jfly.uni-koeln.de/color (2008)."""

    BLACK = "#000000"
    ORANGE = "#E69F00"
    SKY_BLUE = "#56B4E9"
    BLUISH_GREEN = "#009E73"
    BLUE = "#0072B2"
    VERMILLION = "#D55E00"
    REDDISH_PURPLE = "#CC79A7"
    LOW_GROUND = "#EFEBE1"
    HIGH_GROUND = "#B5A98F"
    LOW_ROOF = "#C5CCD4"
    HIGH_ROOF = "#7D8A99"
    OUTLINE = "#4A545F"


View: TypeAlias = Literal["top", "front"]


#: Color and marker of each path; markers are for gray prints.
PATH_STYLES = (
    *((Color.BLUE, "o"), (Color.VERMILLION, "s"), (Color.BLUISH_GREEN, "^"), (Color.REDDISH_PURPLE, "D")),
    *((Color.ORANGE, "v"), (Color.SKY_BLUE, "P"), (Color.BLACK, "X")),
)
STYLE: Mapping[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": Color.OUTLINE,
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
    with sheet(3.5 * len(views), 3.7) as figure:
        for n, view in enumerate(views):
            axes = figure.add_subplot(1, len(views), n + 1)
            (_draw_top if view == "top" else _draw_front)(axes, scenario.airspace, paths)
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
    """Provide a figure [inch], with a rounded layout: the solver's last bits differ between runs."""
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
    low = float(up.min())
    high = float(up.max())
    extent = (east[0, 0], east[0, -1], north[0, 0], north[-1, 0])
    tints = LinearSegmentedColormap.from_list("ground", [Color.LOW_GROUND, Color.HIGH_GROUND])
    shading: dict[str, Any] = {"cmap": tints, "vmin": low, "vmax": max(high, low + 5.0)}
    axes.imshow(up, extent=extent, origin="lower", interpolation="bilinear", **shading)
    if high - low > 1.0:
        levels = np.asarray(MaxNLocator(8).tick_values(low, high))
        inside = levels[(levels > low) & (levels < high)]
        contours = axes.contour(east, north, up, levels=inside, colors="#8C7F63", linewidths=0.4, alpha=0.7)
        axes.clabel(contours, fontsize=5, fmt="%g m")
    low_first = sorted(airspace.obstacles, key=lambda o: float(o.bounds[1, 2]))
    for obstacle, color in zip(low_first, _roof_colors(low_first), strict=True):
        outer, *holes = obstacle.outline()
        footprint = shapely.orient_polygons(shapely.Polygon(outer, holes))  # filled by winding number
        rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(footprint)]
        outline = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
        axes.add_patch(PathPatch(outline, facecolor=color, edgecolor=Color.OUTLINE, linewidth=0.4))
    _draw_paths(axes, paths, (0, 1))
    axes.set(xlim=extent[:2], ylim=extent[2:], aspect="equal")
    axes.set(xlabel="east [m]", ylabel="north [m]", title="from above")


def _draw_front(axes: Axes, airspace: Airspace, paths: Mapping[str, Points]) -> None:
    east, _, up = ground_mesh(airspace, 240)
    far_first = sorted(airspace.obstacles, key=lambda o: -float(o.bounds[0, 1]))
    silhouettes = [obstacle.silhouette(0) for obstacle in far_first]
    colors = _roof_colors(far_first, alpha=0.55)
    shapes = PolyCollection(silhouettes, facecolors=colors, edgecolors=Color.OUTLINE, linewidths=0.4)
    axes.add_collection(shapes, autolim=False)
    tops = [float(obstacle.bounds[1, 2]) for obstacle in far_first if obstacle.solid]
    lowest = min(float(up.min()), *(float(path[:, 2].min()) for path in paths.values()), 0.0)
    highest = max([float(up.max()), *tops, *(float(path[:, 2].max()) for path in paths.values())])
    floor = lowest - 0.04 * (highest - lowest)
    axes.fill_between(east[0], floor, up.max(axis=0), color=Color.LOW_GROUND, zorder=0)
    axes.fill_between(east[0], floor, up.min(axis=0), color=Color.HIGH_GROUND, zorder=2)
    _draw_paths(axes, paths, (0, 2))
    axes.set(xlim=(east[0, 0], east[0, -1]), ylim=(floor, highest + 0.05 * (highest - lowest)))
    axes.set(xlabel="east [m]", ylabel="up [m]", title="from the south")


def _roof_colors(obstacles: Sequence[Obstacle], alpha: float | None = None) -> list[Any]:
    roofs = LinearSegmentedColormap.from_list("roofs", [Color.LOW_ROOF, Color.HIGH_ROOF])
    highest = max([1.0, *(obstacle.bounds[1, 2] for obstacle in obstacles if obstacle.solid)])
    return [roofs(obstacle.bounds[1, 2] / highest, alpha=alpha) for obstacle in obstacles]


def _draw_paths(axes: Axes, paths: Mapping[str, Points], plane: tuple[int, int]) -> None:
    for n, (name, path) in enumerate(paths.items()):
        color, marker = PATH_STYLES[n % len(PATH_STYLES)]
        along = arc_lengths(path)
        marked = sorted(set(np.searchsorted(along, np.linspace(0.06, 0.94, num=8) * along[-1]).tolist()))
        marks: dict[str, Any] = {"marker": marker, "markersize": 4, "markevery": marked}
        edges: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5}
        axes.plot(*path[:, plane].T, label=name, color=color, linewidth=1.6, zorder=5, **marks, **edges)


def _mark_ends(axes: Axes, scenario: Scenario, plane: tuple[int, int]) -> None:
    label: dict[str, Any] = {"xytext": (0, 7), "ha": "center", "textcoords": "offset points", "fontsize": 7}
    box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
    for words, point in (("start", scenario.start_point), ("goal", scenario.goal_point)):
        spot = tuple(point[list(plane)])
        axes.plot(*spot, marker="o", markersize=6, markerfacecolor="white", markeredgecolor=Color.BLACK, zorder=6)
        axes.annotate(words, spot, zorder=7, bbox=box, **label)
