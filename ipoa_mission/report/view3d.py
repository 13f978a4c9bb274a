"""The 3D view of a picture: parallel projection, solids painted from far to near, paths drawn where they can be seen.

Matplotlib's own 3D drawing sorts whole collections, so a path comes to lie wholly before or behind a building. Here
the viewpoint is fixed first, everything is projected, and a path is solid where the line of sight is free and
dotted where something stands before it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D, proj3d
from numpy.typing import NDArray

from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.report import palette
from ipoa_mission.report.ground_mesh import ground_mesh
from ipoa_mission.world.airspace import Airspace

GROUND = LinearSegmentedColormap.from_list("ground", [palette.LOW_GROUND, palette.HIGH_GROUND])
ROOFS = LinearSegmentedColormap.from_list("roofs", [palette.LOW_ROOF, palette.HIGH_ROOF])
LIGHT = np.array([-0.45, -0.35, 0.82]) / np.linalg.norm([-0.45, -0.35, 0.82])


@dataclass(frozen=True)
class Look:
    """From where the box is seen, and how finely what is in it is drawn."""

    elevation_deg: float = 34.0
    azimuth_deg: float = -62.0
    lowest: float = 0.28  # the box's height as a share of its longer side,
    highest: float = 0.85  # at most
    cells: int = 70  # of the ground along the longer side
    sight_points: int = 160  # at which a line of sight is tried
    pieces: int = 300  # of a path


LOOK = Look()


class _FlatPolygons(PolyCollection):
    """Polygons that are projected already: 3D axes ask every collection to do that."""

    def do_3d_projection(self) -> float:
        return 0.0


class _FlatLines(LineCollection):
    """Lines that are projected already."""

    def do_3d_projection(self) -> float:
        return 0.0


def draw_space(axes: Axes3D, airspace: Airspace, paths: Mapping[str, Points]) -> None:
    """Draw ground, obstacles and paths (n, 3) into 3D axes, seen from the south-east above."""
    east, north, up = ground_mesh(airspace, LOOK.cells)
    lower, upper = _frame(airspace, paths, up)
    shape = (upper - lower) / (upper - lower)[:2].max()
    shape[2] = np.clip(shape[2], LOOK.lowest, LOOK.highest)
    _set_stage(axes, lower, upper, shape)
    sight = _sight() / shape * (upper - lower)  # towards the viewer, in metres
    cell = float(np.hypot(east[0, 1] - east[0, 0], north[1, 0] - north[0, 0]))
    stretch = shape / (upper - lower)

    polygons, colors, depths = _ground_tiles(east, north, up, stretch, cell)
    for obstacle in airspace.obstacles:
        for tile in obstacle.tiles(cell):
            polygons.append(tile)
            colors.append(_lit(_roof_color(obstacle.bounds[1, 2], lower[2], upper[2]), _normal(tile * stretch)))
            depths.append(_depth(tile, stretch))
    lines = [line for obstacle in airspace.obstacles for whole in obstacle.edges() for line in _cut(whole, cell)]
    depths += [_depth(line, stretch) + 0.3 * cell * stretch[0] for line in lines]
    edge_colors = [*colors, *[to_rgb(palette.OUTLINE)] * len(lines)]
    colors += [(0.0, 0.0, 0.0)] * len(lines)
    shapes = [*polygons, *(line[[0, 1, 0]] for line in lines)]
    ends = np.cumsum([len(shape) for shape in shapes])[:-1]
    flat = np.split(_projected(axes, np.vstack(shapes)), ends)
    order = np.argsort(depths, kind="stable")
    solids = _FlatPolygons(
        [flat[i] for i in order],
        facecolors=[colors[i] for i in order],
        edgecolors=[edge_colors[i] for i in order],
        linewidths=0.35,
        zorder=1,
        rasterized=True,
    )
    solids.set_clip_on(False)
    axes.add_collection(solids, autolim=False)
    for n, (name, path) in enumerate(paths.items()):
        _draw_path(axes, airspace, path, sight, name, n)


def _draw_path(axes: Axes3D, airspace: Airspace, path: Points, sight: Vector, name: str, n: int) -> None:
    points = _resampled(path)
    flat, seen = _projected(axes, points), visible((points[1:] + points[:-1]) / 2, airspace, sight)
    pieces = np.stack([flat[:-1], flat[1:]], axis=1)
    color = palette.PATHS[n % len(palette.PATHS)]
    hidden = _FlatLines(list(pieces[~seen][::2]), colors=color, linewidths=0.9, zorder=2)
    plain = _FlatLines(list(pieces[seen]), colors=color, linewidths=1.8, capstyle="round", zorder=3)
    for lines in (hidden, plain):
        lines.set_clip_on(False)
        axes.add_collection(lines, autolim=False)
    marks = np.arange(len(flat))[LOOK.pieces // 16 :: LOOK.pieces // 8]
    marks = marks[np.append(seen, True)[marks]]
    Axes.plot(
        axes,
        *flat[marks].T,
        linestyle="",
        label=name,
        zorder=4,
        clip_on=False,
        **look_of(n),
    )


def look_of(n: int) -> dict[str, Any]:
    """What sets the n-th line apart: its color and its markers."""
    return {
        "color": palette.PATHS[n % len(palette.PATHS)],
        "marker": palette.MARKERS[n % len(palette.MARKERS)],
        "markersize": 4,
        "markeredgecolor": "white",
        "markeredgewidth": 0.5,
    }


def visible(points: Points, airspace: Airspace, sight: Vector) -> NDArray[np.bool_]:
    """Whether a viewer in the direction `sight` (3,) sees each point (n, 3), (n,): nothing stands on the line to it."""
    lower, upper = np.asarray(airspace.bounds.lower), np.asarray(airspace.bounds.upper)
    reach = np.linalg.norm((upper - lower)[:2]) / np.linalg.norm(sight[:2])
    along = np.linspace(0.0, 1.0, LOOK.sight_points + 1)[1:] ** 1.5 * reach
    looks = points[:, None, :] + along[:, None] * sight
    clear = airspace.clearance(looks.reshape(-1, 3)).reshape(looks.shape[:2])
    return np.asarray((clear > 0).all(axis=1))


def _sight() -> Vector:
    elevation, azimuth = np.radians([LOOK.elevation_deg, LOOK.azimuth_deg])
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def _frame(airspace: Airspace, paths: Mapping[str, Points], up: NDArray[np.float64]) -> tuple[Vector, Vector]:
    """The box that is drawn: the bounds' ground plan, from the lowest ground to the highest thing."""
    lower, upper = np.array(airspace.bounds.lower), np.array(airspace.bounds.upper)
    tops = [obstacle.bounds[1, 2] for obstacle in airspace.obstacles] + [path[:, 2].max() for path in paths.values()]
    lower[2] = min(up.min(), *(path[:, 2].min() for path in paths.values())) if paths else up.min()
    upper[2] = max([up.max(), lower[2] + 1.0, *tops])
    return lower, upper


def _set_stage(axes: Axes3D, lower: Vector, upper: Vector, shape: Vector) -> None:
    axes.set_proj_type("ortho")
    axes.view_init(elev=LOOK.elevation_deg, azim=LOOK.azimuth_deg)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    axes.set_box_aspect(tuple(shape), zoom=1.3)
    axes.set_xlabel("east [m]", labelpad=-2, fontsize=7)
    axes.set_ylabel("north [m]", labelpad=-2, fontsize=7)
    axes.set_zlabel("up [m]", labelpad=-7, fontsize=7)
    axes.tick_params(labelsize=6.5, pad=-1)
    axes.computed_zorder = False
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis.set_major_locator(MaxNLocator(3 if axis is axes.zaxis else 5))
        axis._axinfo["grid"].update(color="#D9D9D9", linewidth=0.5)


def _ground_tiles(
    east: NDArray[np.float64], north: NDArray[np.float64], up: NDArray[np.float64], stretch: Vector, cell: float
) -> tuple[list[Points], list[tuple[float, ...]], list[float]]:
    """Cells of the ground, each a little farther away than it is: what stands on a cell is painted after it."""
    nodes = np.stack([east, north, up], axis=-1)
    least, most = float(up.min()), float(up.max())
    cells = [
        nodes[[i, i, i + 1, i + 1], [j, j + 1, j + 1, j]]
        for i in range(nodes.shape[0] - 1)
        for j in range(nodes.shape[1] - 1)
    ]
    colors = [_lit(_ground_color(tile[:, 2].mean(), least, most), _normal(tile * stretch)) for tile in cells]
    return cells, colors, [_depth(tile, stretch) - cell * stretch[0] for tile in cells]


def _resampled(path: Points) -> Points:
    along = arc_lengths(path)
    wanted = np.linspace(0.0, along[-1], LOOK.pieces + 1)
    return np.column_stack([np.interp(wanted, along, axis) for axis in path.T])


def _cut(line: Points, size: float) -> list[Points]:
    """Pieces (2, 3) of a line, none longer than `size`."""
    pieces = []
    for a, b in pairwise(line):
        steps = np.linspace(0.0, 1.0, max(1, int(np.ceil(np.linalg.norm(b - a) / size))) + 1)[:, None]
        pieces += [np.array(piece) for piece in pairwise(a + steps * (b - a))]
    return pieces


def _projected(axes: Axes3D, points: Points) -> NDArray[np.float64]:
    x, y, _ = proj3d.proj_transform(*points.T, axes.get_proj())
    return np.column_stack([x, y])


def _depth(polygon: Points, stretch: Vector) -> float:
    """How near the viewer a polygon lies: larger is nearer."""
    return float((polygon.mean(axis=0) * stretch) @ _sight())


def _normal(polygon: Points) -> Vector:
    normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[1])
    size = np.linalg.norm(normal)
    if size == 0:
        return np.array([0.0, 0.0, 1.0])
    return np.asarray(normal / size if normal @ _sight() > 0 else -normal / size)


def _lit(color: tuple[float, ...], normal: Vector) -> tuple[float, ...]:
    """A matt color in the light: between 62 % and 104 % of it."""
    brightness = 0.62 + 0.42 * max(0.0, float(normal @ LIGHT))
    return tuple(min(1.0, channel * brightness) for channel in color)


def _ground_color(up: float, least: float, most: float) -> tuple[float, ...]:
    return tuple(GROUND((up - least) / max(most - least, 5.0))[:3])


def _roof_color(top: float, least: float, most: float) -> tuple[float, ...]:
    return tuple(ROOFS((top - least) / (most - least))[:3])
