"""Elevation models (GeoTIFF, SRTM .hgt, any GDAL format).

Heights belong to posts, the centers of pixels. The local grid is raised so that no post is above it.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Vector
from ipoa_mission.maps.geoid import undulation
from ipoa_mission.maps.raster import RasterFile, open_raster
from ipoa_mission.world.frame import Geodetic, LocalFrame
from ipoa_mission.world.terrain import Grid

KNOTS = 33  # lattice lines of exact conversion
UPPER_LEVEL = 1000.0  # second altitude of conversion [m]
MOST_NODES = 8_000_000
HOME_TOLERANCE = 10.0  # [m]


@dataclass(frozen=True)
class ElevationRules:
    """`heights` None: the coordinate system's datum, or mean sea level; `geoid`: [m] or a PROJ grid."""

    heights: Literal["amsl", "ellipsoidal"] | None = None
    geoid: float | Path | None = None
    spacing: float | None = None
    voids: Literal["refuse", "fill"] = "refuse"
    nodata: float | None = None
    level_at_home: bool = False


def local_grid(
    path: Path, rules: ElevationRules, frame: LocalFrame, lower: tuple[float, float], upper: tuple[float, float]
) -> tuple[Grid, tuple[str, ...]]:
    """Return the ground between corners (east, north) [m] above home, and remarks."""
    with open_raster(path, rules.nodata) as raster:
        area = _pixels(raster, frame, _knots(lower[0], upper[0]), _knots(lower[1], upper[1]), 0.0)
        raster.expect_cover(area)
        apart = _post_distance(raster, frame, area)
        nodes = _nodes(lower, upper, rules.spacing or apart)
        knots = _knots(nodes[0][0], nodes[0][-1]), _knots(nodes[1][0], nodes[1][-1])
        pixels = [_pixels(raster, frame, *knots, up) for up in (0.0, UPPER_LEVEL)]
        first, heights, remarks = raster.read(pixels, fill=rules.voids == "fill")
        heights, conversion = _above_sea(heights, raster, first, rules)
        posts = _posts(raster, frame, first, heights)
    spacing = float(nodes[0][1] - nodes[0][0])
    ground = _read_off(heights, first, knots, pixels, nodes)
    lift = _raise_over_posts(ground, posts, lower, spacing)
    grid, levelled = _level(Grid(lower[0], lower[1], spacing, ground), rules, frame, (lower, upper), path)
    used = f"ground every {spacing:.3g} m from posts {apart:.3g} m apart, raised by {max(lift, 0.001):.2g} m at most"
    return grid, tuple(f"{path.name}: {remark}" for remark in (*remarks, *conversion, used, *levelled))


def ground_altitude(path: Path, latitude_deg: float, longitude_deg: float) -> float:
    """Return the height at a place [m AMSL]."""
    frame, here = LocalFrame(Geodetic(latitude_deg, longitude_deg)), np.zeros(1)
    with open_raster(path, None) as raster:
        pixels = _pixels(raster, frame, here, here, 0.0)
        raster.expect_cover(pixels)
        first, heights, _ = raster.read([pixels], fill=False)
        heights, _ = _above_sea(heights, raster, first, ElevationRules())
    spot = [pixels[1].ravel() - first[0], pixels[0].ravel() - first[1]]
    return float(scipy.ndimage.map_coordinates(heights, spot, order=1, mode="nearest")[0])


def _nodes(lower: tuple[float, float], upper: tuple[float, float], spacing: float) -> tuple[Vector, Vector]:
    columns, rows = (max(int(np.ceil((upper[i] - lower[i]) / spacing - 1e-9)) + 1, 2) for i in (0, 1))
    if columns * rows > MOST_NODES:
        least = spacing * np.sqrt(columns * rows / MOST_NODES)
        words = f"expected {least:.1f} m or more over so wide an area, not {spacing:.3g} m"
        raise BadInput(words, place="terrain.spacing")
    return np.asarray(lower[0] + spacing * np.arange(columns)), np.asarray(lower[1] + spacing * np.arange(rows))


def _knots(low: float, high: float) -> Vector:
    return np.linspace(low, high, KNOTS, dtype=np.float64)


def _pixels(raster: RasterFile, frame: LocalFrame, east: Vector, north: Vector, up: float) -> NDArray[np.float64]:
    lattice = np.stack(np.meshgrid(east, north, indexing="ij"), axis=-1).reshape(-1, 2)
    latitude, longitude, altitude = frame.to_geodetic(np.column_stack([lattice, np.full(len(lattice), up)]))
    return np.stack([*raster.pixels(latitude, longitude), altitude]).reshape(3, len(east), len(north))


def _posts(raster: RasterFile, frame: LocalFrame, first: "_First", heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return east, north, up of posts, (3, rows, columns)."""
    rows, columns = (begin + np.arange(count) for begin, count in zip(first, heights.shape, strict=True))
    knots = [_knots(each[0], each[-1]) for each in (rows, columns)]
    row, column = np.meshgrid(*knots, indexing="ij")
    latitude, longitude = raster.places(column.ravel(), row.ravel())
    at = [
        [
            scipy.interpolate.RectBivariateSpline(*knots, axis.reshape(row.shape))(rows, columns)
            for axis in frame.to_local(latitude, longitude, np.full(row.size, altitude)).T
        ]
        for altitude in (frame.home.altitude, frame.home.altitude + UPPER_LEVEL)
    ]
    share = (heights - frame.home.altitude) / UPPER_LEVEL
    return np.stack([low + share * (high - low) for low, high in zip(*at, strict=True)])


def _read_off(
    heights: NDArray[np.float64],
    first: "_First",
    knots: tuple[Vector, Vector],
    pixels: list[NDArray[np.float64]],
    nodes: tuple[Vector, Vector],
) -> NDArray[np.float64]:
    """Return the ground above home at the nodes, (rows, columns); places depend on height, hence two passes."""
    smooth = scipy.interpolate.RectBivariateSpline
    low, high = ([smooth(*knots, values)(*nodes).T for values in level] for level in pixels)
    up = np.zeros_like(low[0])
    for _ in range(2):
        column, row = (low[i] + up / UPPER_LEVEL * (high[i] - low[i]) for i in (0, 1))
        altitude = scipy.ndimage.map_coordinates(heights, [row - first[0], column - first[1]], order=1, mode="nearest")
        up = (altitude - low[2]) / (high[2] - low[2]) * UPPER_LEVEL
    return np.asarray(up)


def _raise_over_posts(
    ground: NDArray[np.float64], posts: NDArray[np.float64], lower: tuple[float, float], spacing: float
) -> float:
    """Raise `ground` in place; return the greatest raise [m]."""
    east, north, up = posts.reshape(3, -1)
    rows, columns = ground.shape
    x, y = (east - lower[0]) / spacing, (north - lower[1]) / spacing
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    x, y, up = x[inside], y[inside], up[inside]
    surface = scipy.ndimage.map_coordinates(ground, [y, x], order=1, mode="nearest")
    missing = up - surface
    short = missing > 0
    column, row = (np.minimum(x[short].astype(int), columns - 2), np.minimum(y[short].astype(int), rows - 2))
    raised = np.zeros_like(ground)
    for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
        np.maximum.at(raised, (row + down, column + right), missing[short])
    ground += raised
    return float(raised.max())


def _post_distance(raster: RasterFile, frame: LocalFrame, area: NDArray[np.float64]) -> float:
    column, row = (float(area[i].mean()) for i in (0, 1))
    places = raster.places(np.array([column, column + 1, column]), np.array([row, row, row + 1]))
    here, right, down = frame.to_local(*places, np.full(3, frame.home.altitude))
    return float(min(np.linalg.norm(right - here), np.linalg.norm(down - here)))


def _above_sea(
    heights: NDArray[np.float64], raster: RasterFile, first: "_First", rules: ElevationRules
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    counted = rules.heights or ("ellipsoidal" if raster.ellipsoidal else "amsl")
    if counted == "amsl" or rules.level_at_home:
        return heights, (f"heights taken as {'above mean sea level' if counted == 'amsl' else 'differences only'}",)
    row, column = first[0] + heights.shape[0] / 2, first[1] + heights.shape[1] / 2
    latitude, longitude = raster.places(np.array([column]), np.array([row]))
    geoid, source = undulation(float(latitude[0]), float(longitude[0]), rules.geoid, raster.path)
    return heights - geoid, (f"heights above the ellipsoid, less {geoid:.2f} m of geoid ({source})",)


def _level(
    grid: Grid,
    rules: ElevationRules,
    frame: LocalFrame,
    corners: tuple[tuple[float, float], tuple[float, float]],
    path: Path,
) -> tuple[Grid, tuple[str, ...]]:
    """Shift the grid to 0 at home if asked, else check home's altitude."""
    if not all(low <= 0 <= high for low, high in zip(*corners, strict=True)):
        return grid, ()
    at_home = float(grid.height(np.zeros((1, 2)))[0])
    if rules.level_at_home:
        level = Grid(grid.east, grid.north, grid.spacing, grid.heights - at_home)
        return level, (f"moved by {-at_home:.2f} m, so that the ground at home is at 0",)
    if abs(at_home) > HOME_TOLERANCE:
        measured, given = frame.home.altitude + at_home, frame.home.altitude
        words = f"expected about {measured:.1f} m, the ground there in {path}, not {given:g} m"
        hint = f"set home.altitude_amsl = {measured:.1f}, or terrain.level_at_home = true"
        raise BadInput(words, hint=hint, code="home-not-on-ground", place="home.altitude_amsl")
    return grid, (f"ground at home {at_home:+.2f} m from home's altitude",) if round(at_home, 2) else ()


_First = tuple[int, int]  # row and column
