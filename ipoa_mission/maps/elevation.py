"""Read elevation models (GeoTIFF, SRTM .hgt, any GDAL raster).

Heights belong to posts, the centers of pixels. The local grid is raised so that no post is above it.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from ipoa_mission.errors import BadInput, DamagedFile, NoCoordinateSystem, NotCovered, imported
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Vector
from ipoa_mission.maps.geoid import ElevationRules, undulation
from ipoa_mission.maps.lengths import UNIT_FACTORS
from ipoa_mission.world.terrain import Grid

UPPER_LEVEL = 1000.0  # second altitude of conversion [m]
HEIGHT_UNITS = {**UNIT_FACTORS, "": 1.0, **dict.fromkeys(("us survey foot", "ftus"), 1200 / 3937)}
LOWEST = -500.0  # ground [m]
HIGHEST = 9_000.0  # ground [m]
SUSPECT_STEP = 100.0  # larger ones may be spoiled heights [m]


class _Posts(NamedTuple):
    """Heights (rows, columns) [m]; row and column of the first."""

    heights: NDArray[np.float64]
    first: tuple[int, int]


def local_grid(
    path: Path, rules: ElevationRules, frame: LocalFrame, lower: tuple[float, float], upper: tuple[float, float]
) -> tuple[Grid, tuple[str, ...]]:
    """Return the ground between corners (east, north) [m] above home, and remarks."""
    with _open_raster(path, rules.nodata) as raster:
        area = _pixels(raster, frame, _knots(lower[0], upper[0]), _knots(lower[1], upper[1]), 0.0)
        raster.expect_cover(area)
        apart = _post_distance(raster, frame, area)
        nodes = _nodes(lower, upper, rules.spacing or apart)
        knots = _knots(nodes[0][0], nodes[0][-1]), _knots(nodes[1][0], nodes[1][-1])
        pixels = [_pixels(raster, frame, *knots, up) for up in (0.0, UPPER_LEVEL)]
        posts, remarks = raster.read(pixels)
        posts, conversion = _above_sea(posts, raster, rules)
        places = _places(raster, frame, posts)
    spacing = float(nodes[0][1] - nodes[0][0])
    ground = _ground_at(nodes, posts, knots, pixels)
    lift = _raise_over_posts(ground, places, lower, spacing)
    used = f"ground every {spacing:.3g} m from posts {apart:.3g} m apart, raised by {max(lift, 0.001):.2g} m at most"
    remarks = (*remarks, conversion, used)
    grid = Grid(lower[0], lower[1], spacing, ground)
    if all(low <= 0 <= high for low, high in zip(lower, upper, strict=True)):
        grid, levelled = _level(grid, rules, frame, path)
        remarks += levelled
    return grid, tuple(f"{path.name}: {remark}" for remark in remarks)


def ground_altitude(path: Path, latitude_deg: float, longitude_deg: float) -> float:
    """Return the height at a place [m AMSL]."""
    frame = LocalFrame(Geodetic(latitude_deg, longitude_deg))
    origin = np.zeros(1)
    with _open_raster(path, None) as raster:
        pixels = _pixels(raster, frame, origin, origin, 0.0)
        raster.expect_cover(pixels)
        posts, _ = raster.read([pixels])
        posts, _ = _above_sea(posts, raster, ElevationRules())
    return float(_interpolate(posts, pixels[0].ravel(), pixels[1].ravel())[0])


def _interpolate(posts: _Posts, column: Any, row: Any) -> NDArray[np.float64]:
    spots = [row - posts.first[0], column - posts.first[1]]
    return np.asarray(scipy.ndimage.map_coordinates(posts.heights, spots, order=1, mode="nearest"))


def _nodes(lower: tuple[float, float], upper: tuple[float, float], spacing: float) -> tuple[Vector, Vector]:
    most = 8_000_000
    columns, rows = (max(int(np.ceil((upper[i] - lower[i]) / spacing - 1e-9)) + 1, 2) for i in (0, 1))
    if columns * rows > most:
        least = spacing * np.sqrt(columns * rows / most)
        words = f"expected {least:.1f} m or more over so wide an area, not {spacing:.3g} m"
        raise BadInput(words, place="terrain.spacing")
    return np.asarray(lower[0] + spacing * np.arange(columns)), np.asarray(lower[1] + spacing * np.arange(rows))


def _knots(low: float, high: float) -> Vector:
    return np.linspace(low, high, 33, dtype=np.float64)


def _pixels(raster: "_Raster", frame: LocalFrame, east: Vector, north: Vector, up: float) -> NDArray[np.float64]:
    lattice = np.stack(np.meshgrid(east, north, indexing="ij"), axis=-1).reshape(-1, 2)
    latitude, longitude, altitude = frame.to_geodetic(np.column_stack([lattice, np.full(len(lattice), up)]))
    return np.stack([*raster.pixels(latitude, longitude), altitude]).reshape(3, len(east), len(north))


def _places(raster: "_Raster", frame: LocalFrame, posts: _Posts) -> NDArray[np.float64]:
    rows, columns = (begin + np.arange(count) for begin, count in zip(posts.first, posts.heights.shape, strict=True))
    knots = [_knots(lines[0], lines[-1]) for lines in (rows, columns)]
    row, column = np.meshgrid(*knots, indexing="ij")
    latitude, longitude = raster.places(column.ravel(), row.ravel())
    levels = [
        [
            scipy.interpolate.RectBivariateSpline(*knots, axis.reshape(row.shape))(rows, columns)
            for axis in frame.to_local(latitude, longitude, np.full(row.size, altitude)).T
        ]
        for altitude in (frame.home.altitude, frame.home.altitude + UPPER_LEVEL)
    ]
    share = (posts.heights - frame.home.altitude) / UPPER_LEVEL
    return np.stack([low + share * (high - low) for low, high in zip(*levels, strict=True)])


def _ground_at(
    nodes: tuple[Vector, Vector], posts: _Posts, knots: tuple[Vector, Vector], pixels: list[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Return the ground above home at the nodes, (rows, columns)."""
    smooth = scipy.interpolate.RectBivariateSpline
    low = [smooth(*knots, values)(*nodes).T for values in pixels[0]]
    high = [smooth(*knots, values)(*nodes).T for values in pixels[1]]
    up = np.zeros_like(low[0])
    for _ in range(2):
        column, row = (low[i] + up / UPPER_LEVEL * (high[i] - low[i]) for i in (0, 1))
        up = (_interpolate(posts, column, row) - low[2]) / (high[2] - low[2]) * UPPER_LEVEL
    return np.asarray(up)


def _raise_over_posts(
    ground: NDArray[np.float64], posts: NDArray[np.float64], lower: tuple[float, float], spacing: float
) -> float:
    """Raise `ground` in place over posts (3, rows, columns); return the greatest raise [m]."""
    east, north, up = posts.reshape(3, -1)
    rows, columns = ground.shape
    x = (east - lower[0]) / spacing
    y = (north - lower[1]) / spacing
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    x = x[inside]
    y = y[inside]
    up = up[inside]
    missing = up - scipy.ndimage.map_coordinates(ground, [y, x], order=1, mode="nearest")
    short = missing > 0
    column = np.minimum(x[short].astype(int), columns - 2)
    row = np.minimum(y[short].astype(int), rows - 2)
    raised = np.zeros_like(ground)
    for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
        np.maximum.at(raised, (row + down, column + right), missing[short])
    ground += raised
    return float(raised.max())


def _post_distance(raster: "_Raster", frame: LocalFrame, area: NDArray[np.float64]) -> float:
    column, row = (float(area[i].mean()) for i in (0, 1))
    places = raster.places(np.array([column, column + 1, column]), np.array([row, row, row + 1]))
    post, right, down = frame.to_local(*places, np.full(3, frame.home.altitude))
    return float(min(np.linalg.norm(right - post), np.linalg.norm(down - post)))


def _above_sea(posts: _Posts, raster: "_Raster", rules: ElevationRules) -> tuple[_Posts, str]:
    datum = rules.heights or ("ellipsoidal" if raster.ellipsoidal else "amsl")
    if datum == "amsl" or rules.level_at_home:
        return posts, f"heights taken as {'above mean sea level' if datum == 'amsl' else 'differences only'}"
    row, column = (begin + count / 2 for begin, count in zip(posts.first, posts.heights.shape, strict=True))
    latitude, longitude = raster.places(np.array([column]), np.array([row]))
    geoid, source = undulation(float(latitude[0]), float(longitude[0]), rules.geoid, raster.path)
    words = f"heights above the ellipsoid, less {geoid:.2f} m of geoid ({source})"
    return posts._replace(heights=posts.heights - geoid), words


def _level(grid: Grid, rules: ElevationRules, frame: LocalFrame, path: Path) -> tuple[Grid, tuple[str, ...]]:
    """Shift the grid to 0 at home if asked, else check home's altitude."""
    at_home = float(grid.height(np.zeros((1, 2)))[0])
    if rules.level_at_home:
        level = Grid(grid.east, grid.north, grid.spacing, grid.heights - at_home)
        return level, (f"moved by {-at_home:.2f} m, so that the ground at home is at 0",)
    if abs(at_home) > 10.0:  # [m]
        altitude = frame.home.altitude
        words = f"expected about {altitude + at_home:.1f} m, the ground there in {path}, not {altitude:g} m"
        hint = f"set home.altitude_amsl = {altitude + at_home:.1f}, or terrain.level_at_home = true"
        raise BadInput(words, hint=hint, code="home-not-on-ground", place="home.altitude_amsl")
    if round(at_home, 2) == 0.0:
        return grid, ()
    return grid, (f"ground at home {at_home:+.2f} m from home's altitude",)


@dataclass(frozen=True, eq=False)
class _Raster:
    path: Path
    dataset: Any
    nodata: float | None

    @cached_property
    def system(self) -> CRS:
        if self.dataset.crs is None:
            raise NoCoordinateSystem("expected an elevation model that names its coordinate system", place=self.path)
        return CRS.from_wkt(self.dataset.crs.to_wkt())

    @property
    def ellipsoidal(self) -> bool:
        """Return whether one system has three axes: ellipsoidal heights."""
        return not self.system.is_compound and len(self.system.axis_info) == 3

    def pixels(self, latitude_deg: Vector, longitude_deg: Vector) -> tuple[Vector, Vector]:
        x, y = self._from_degrees.transform(longitude_deg, latitude_deg)
        a, b, c, d, e, f = self.dataset.transform[:6]
        if self.system.is_geographic:  # nearest the raster's middle
            middle = a * self.dataset.width / 2 + b * self.dataset.height / 2 + c
            x = (np.asarray(x) - middle + 180.0) % 360.0 - 180.0 + middle
        x, y = np.asarray(x) - c, np.asarray(y) - f
        area = a * e - b * d
        return (e * x - b * y) / area - 0.5, (a * y - d * x) / area - 0.5

    def places(self, column: Vector, row: Vector) -> tuple[Vector, Vector]:
        """Return latitude and longitude of posts [deg], each (n,)."""
        a, b, c, d, e, f = self.dataset.transform[:6]
        x, y = column + 0.5, row + 0.5
        longitude, latitude = self._from_degrees.transform(a * x + b * y + c, d * x + e * y + f, direction="INVERSE")
        return np.asarray(latitude), np.asarray(longitude)

    def expect_cover(self, pixels: NDArray[np.float64]) -> None:
        outside = {
            "left": -0.5 - pixels[0].min(),
            "right": pixels[0].max() - self.dataset.width + 0.5,
            "upper": -0.5 - pixels[1].min(),
            "lower": pixels[1].max() - self.dataset.height + 0.5,
        }
        side = max(outside, key=lambda side: outside[side])
        if not outside[side] < 1e-6:
            missing = f"{outside[side]:.1f} posts" if outside[side] < self.dataset.width else "far"
            words = f"expected a model of the whole flight area, which lies {missing} beyond its {side} edge"
            hint = "take a larger model, narrow `bounds` (bounds.margin = 50), or swap latitude and longitude"
            raise NotCovered(words, hint=hint, place=self.path)

    def read(self, pixels: Sequence[NDArray[np.float64]]) -> tuple[_Posts, tuple[str, ...]]:
        if self.dataset.height < 4 or self.dataset.width < 4:
            raise BadInput("expected at least 4 x 4 heights", place=self.path)
        columns = _span([level[0] for level in pixels], self.dataset.width)
        rows = _span([level[1] for level in pixels], self.dataset.height)
        band = self.dataset.read(1, window=(rows, columns), masked=True)
        missing = np.ma.getmaskarray(band) | ~np.isfinite(band.data.astype(float))
        if self.nodata is not None:
            missing |= band.data == self.nodata
        heights = (band.data * self.dataset.scales[0] + self.dataset.offsets[0]) * self._unit
        heights = np.where(missing, np.nan, heights.astype(float))
        undeclared = heights[heights < LOWEST]
        heights[heights < LOWEST] = np.nan
        why = f", since no ground is at {undeclared[0]:g} m" if undeclared.size else ""
        others = heights[(heights != 0) & np.isfinite(heights)]
        if others.size and others.min() > SUSPECT_STEP and (heights == 0).any():
            why += f", since they are 0 m, and all others above {others.min():.0f} m"
            heights[heights == 0] = np.nan
        posts = _Posts(heights, (rows[0], columns[0]))
        self._expect_complete(posts, why)
        return posts, tuple(self._oddities(posts))

    def _oddities(self, posts: _Posts) -> Iterator[str]:
        if self.dataset.count > 1:
            names = ", ".join(name for name in self.dataset.descriptions if name)
            yield f"heights are those of band 1 of {self.dataset.count}{f' ({names})' if names else ''}"
        for axis, side in ((0, "row"), (1, "column")):
            steps = np.abs(np.diff(posts.heights, axis=axis))
            if (most := steps.max(initial=0.0)) > SUSPECT_STEP:
                where = self._where(steps == most, posts)
                yield f"heights differ by {most:.0f} m from one {side} to the next {where}: one may be missing"

    def _expect_complete(self, posts: _Posts, why: str) -> None:
        wild = posts.heights > HIGHEST
        missing = np.isnan(posts.heights)
        if wild.any():
            words = f"expected heights of ground, not {posts.heights[wild][0]:g} m {self._where(wild, posts)}"
            hint = "if this number marks a missing height, set terrain.nodata to it"
            raise BadInput(words, hint=hint, code="heights-absurd", place=self.path)
        if missing.any():
            gaps = f"{missing.sum()} of {missing.size} heights are missing, the first {self._where(missing, posts)}"
            hint = "fill them from their neighbors: gdal_fillnodata.py model.tif filled.tif"
            raise BadInput(f"{gaps}{why}", hint=hint, code="heights-missing", place=self.path)

    def _where(self, mask: NDArray[np.bool_], posts: _Posts) -> str:
        row, column = np.argwhere(mask)[0] + posts.first
        latitude, longitude = self.places(np.array([column]), np.array([row]))
        return f"at row {row}, column {column} (latitude {latitude[0]:.5f}, longitude {longitude[0]:.5f})"

    @cached_property
    def _from_degrees(self) -> Transformer:
        return Transformer.from_crs("OGC:CRS84", self.system.to_2d(), always_xy=True)

    @property
    def _unit(self) -> float:
        name = (self.dataset.units[0] or "").strip().lower()
        for axis in self.system.axis_info:
            if axis.direction == "down":
                raise BadInput(f"expected heights, not depths ({axis.name})", place=self.path)
            if axis.direction == "up" and not name:
                return float(axis.unit_conversion_factor)
        if name not in HEIGHT_UNITS:
            raise BadInput(f"expected heights in meters or feet, not in {name!r}", place=self.path)
        return HEIGHT_UNITS[name]


def _span(pixels: Sequence[Vector], size: int) -> tuple[int, int]:
    """Return begin and end: two posts more on each side, at least four."""
    first = max(int(np.floor(min(level.min() for level in pixels))) - 2, 0)
    end = min(int(np.ceil(max(level.max() for level in pixels))) + 3, size)
    first = max(min(first, size - 4), 0)
    return first, max(end, first + 4)


@contextmanager
def _open_raster(path: Path, nodata: float | None) -> Iterator[_Raster]:
    needed = f"{path}: reading an elevation model needs rasterio, which is not installed"
    rasterio = imported("rasterio", needed, "maps", BadInput)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)  # `system` refuses it
            dataset = rasterio.open(path)
    except rasterio.errors.RasterioIOError as error:
        raise DamagedFile(f"expected an elevation model: {error}", place=path) from error
    try:
        with dataset:
            if dataset.colorinterp[0].name in ("red", "palette"):
                words = "expected an elevation model, but it is a picture"
                hint = "to show it under the studio's map: gdal_translate -of MBTILES, then `studio --tiles`"
                raise BadInput(words, hint=hint, code="picture", place=path)
            if dataset.driver == "AAIGrid":
                _expect_as_many(path, dataset.width * dataset.height)
            yield _Raster(path, dataset, nodata)
    except (rasterio.errors.RasterioError, ProjError, UnicodeDecodeError) as error:
        words = f"expected an elevation model, but it is damaged: {str(error).splitlines()[0]:.200}"
        hint = "copy or download it again: files that were cut short look like this"
        raise DamagedFile(words, hint=hint, place=path) from error


def _expect_as_many(path: Path, heights: int) -> None:
    """Refuse a wrong count of heights, which GDAL fills or drops."""
    lines = path.read_bytes().splitlines(keepends=True) if path.is_file() else []
    keys = (line.split()[:1] for line in lines)
    head = next((n for n, key in enumerate(keys) if key and (not key[0][:1].isalpha() or key[0].lower() == b"nan")), 0)
    blank = np.frombuffer(b" " + b"".join(lines[head:]), np.uint8) <= ord(" ")
    if lines and (count := int((blank[:-1] & ~blank[1:]).sum())) != heights:
        raise BadInput(f"expected {heights} heights, as its header says, not {count}", code="damaged-file", place=path)
