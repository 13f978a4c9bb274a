import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from ipoa_mission.errors import BadInput, DamagedFile, NoCoordinateSystem, NotCovered, imported
from ipoa_mission.geometry import Vector

UNITS = {"": 1.0, "m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0}
UNITS |= {"ft": 0.3048, "foot": 0.3048, "feet": 0.3048, "us survey foot": 1200 / 3937, "ftus": 1200 / 3937}
LOWEST, HIGHEST = -500.0, 9_000.0  # of the ground [m]
DROP = 100.0  # larger steps may be spoiled heights [m]
EXTRA_POSTS = 2  # around the area
FILL_REACH = 100  # pixels


@dataclass(frozen=True, eq=False)
class RasterFile:
    """Column 0, row 0 is the center of the first pixel."""

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
        a, b, c, d, e, f = self._affine
        if self.system.is_geographic:  # nearest the raster's middle
            middle = a * self.dataset.width / 2 + b * self.dataset.height / 2 + c
            x = (np.asarray(x) - middle + 180.0) % 360.0 - 180.0 + middle
        x, y = np.asarray(x) - c, np.asarray(y) - f
        area = a * e - b * d
        return (e * x - b * y) / area - 0.5, (a * y - d * x) / area - 0.5

    def places(self, column: Vector, row: Vector) -> tuple[Vector, Vector]:
        """Return latitude and longitude of posts [deg], each (n,)."""
        a, b, c, d, e, f = self._affine
        x, y = column + 0.5, row + 0.5
        longitude, latitude = self._from_degrees.transform(a * x + b * y + c, d * x + e * y + f, direction="INVERSE")
        return np.asarray(latitude), np.asarray(longitude)

    def expect_cover(self, pixels: NDArray[np.float64]) -> None:
        """Raise, with the side or the missing posts."""
        outside = {
            "left": -0.5 - pixels[0].min(),
            "right": pixels[0].max() - self.dataset.width + 0.5,
            "upper": -0.5 - pixels[1].min(),
            "lower": pixels[1].max() - self.dataset.height + 0.5,
        }
        side = max(outside, key=lambda each: outside[each])
        if not outside[side] < 1e-6:
            missing = f"{outside[side]:.1f} posts" if outside[side] < self.dataset.width else "far"
            raise NotCovered(
                f"expected a model of the whole flight area, which lies {missing} beyond its {side} edge",
                hint="take a larger model, narrow `bounds` (bounds.margin = 50), or swap latitude and longitude",
                place=self.path,
            )

    def read(
        self, pixels: Sequence[NDArray[np.float64]], fill: bool
    ) -> tuple[tuple[int, int], NDArray[np.float64], tuple[str, ...]]:
        """Return first row and column, heights [m] (rows, columns), and remarks."""
        left, top = (int(np.floor(min(level[i].min() for level in pixels))) for i in (0, 1))
        right, bottom = (int(np.ceil(max(level[i].max() for level in pixels))) for i in (0, 1))
        rows = max(top - EXTRA_POSTS, 0), min(bottom + EXTRA_POSTS + 1, self.dataset.height)
        columns = max(left - EXTRA_POSTS, 0), min(right + EXTRA_POSTS + 1, self.dataset.width)
        if self.dataset.height < 4 or self.dataset.width < 4:
            raise BadInput("expected at least 4 x 4 heights", place=self.path)
        rows, columns = _at_least_four(rows, self.dataset.height), _at_least_four(columns, self.dataset.width)
        band = self.dataset.read(1, window=(rows, columns), masked=True)
        missing = np.ma.getmaskarray(band) | ~np.isfinite(band.data.astype(float))
        if self.nodata is not None:
            missing |= band.data == self.nodata
        heights = (band.data * self.dataset.scales[0] + self.dataset.offsets[0]) * self._unit
        heights = np.where(missing, np.nan, heights.astype(float))
        first = rows[0], columns[0]
        undeclared = heights[heights < LOWEST]
        heights[heights < LOWEST] = np.nan
        why = f", since no ground is at {undeclared[0]:g} m" if undeclared.size else ""
        others = heights[(heights != 0) & np.isfinite(heights)]
        if others.size and others.min() > DROP and (heights == 0).any():
            why += f", since they are 0 m, and all others above {others.min():.0f} m"
            heights[heights == 0] = np.nan
        heights, remarks = self._complete(heights, first, fill, why)
        return first, heights, (*remarks, *self._oddities(heights, first))

    def _oddities(self, heights: NDArray[np.float64], first: tuple[int, int]) -> Iterator[str]:
        if self.dataset.count > 1:
            names = ", ".join(name for name in self.dataset.descriptions if name)
            yield f"heights are those of band 1 of {self.dataset.count}{f' ({names})' if names else ''}"
        for axis, side in ((0, "row"), (1, "column")):
            falls = np.abs(np.diff(heights, axis=axis))
            if falls.max(initial=0.0) > DROP:
                where = self._where(falls == falls.max(), first)
                yield f"heights differ by {falls.max():.0f} m from one {side} to the next {where}: is one missing?"

    def _complete(
        self, heights: NDArray[np.float64], first: tuple[int, int], fill: bool, why: str
    ) -> tuple[NDArray[np.float64], tuple[str, ...]]:
        wild = heights > HIGHEST
        if wild.any():
            words = f"expected heights of ground, not {heights[wild][0]:g} m {self._where(wild, first)}"
            hint = "if this number marks a missing height, set terrain.nodata to it"
            raise BadInput(words, hint=hint, code="heights-absurd", place=self.path)
        missing = np.isnan(heights)
        if not missing.any():
            return heights, ()
        gaps = f"{missing.sum()} of {missing.size} heights are missing, the first {self._where(missing, first)}{why}"
        if not fill:
            words = f"{gaps}"
            hint = 'terrain.voids = "fill" fills them from their neighbors'
            raise BadInput(words, hint=hint, code="heights-missing", place=self.path)
        from rasterio.fill import fillnodata

        holed = np.where(missing, LOWEST - 1, heights).astype("float32")
        filled = np.asarray(fillnodata(holed, mask=~missing, max_search_distance=FILL_REACH), float)
        if (filled < LOWEST).any():
            message = f"{gaps}, and some are too far from any other to be filled"
            raise BadInput(message, code="heights-missing", place=self.path)
        return np.where(missing, filled, heights), (f"{gaps}: filled from their neighbors",)

    def _where(self, which: NDArray[np.bool_], first: tuple[int, int]) -> str:
        row, column = np.argwhere(which)[0] + first
        latitude, longitude = self.places(np.array([column]), np.array([row]))
        return f"at row {row}, column {column} (latitude {latitude[0]:.5f}, longitude {longitude[0]:.5f})"

    @property
    def _affine(self) -> tuple[float, float, float, float, float, float]:
        a, b, c, d, e, f = tuple(self.dataset.transform)[:6]
        return a, b, c, d, e, f

    @cached_property
    def _from_degrees(self) -> Transformer:
        return Transformer.from_crs("OGC:CRS84", self.system.to_2d(), always_xy=True)

    @property
    def _unit(self) -> float:
        name = (self.dataset.units[0] or "").strip().lower()
        vertical = [axis for axis in self.system.axis_info if axis.direction == "up"]
        down = [axis.name for axis in self.system.axis_info if axis.direction == "down"]
        if down:
            raise BadInput(f"expected heights, not depths ({down[0]})", place=self.path)
        if not name and vertical:
            return float(vertical[0].unit_conversion_factor)
        if name not in UNITS:
            raise BadInput(f"expected heights in meters or feet, not in {name!r}", place=self.path)
        return UNITS[name]


@contextmanager
def open_raster(path: Path, nodata: float | None) -> Iterator[RasterFile]:
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
            yield RasterFile(path, dataset, nodata)
    except (rasterio.errors.RasterioError, ProjError, UnicodeDecodeError) as error:
        raise DamagedFile(
            f"expected an elevation model, but it is damaged: {str(error).splitlines()[0]:.200}",
            hint="copy or download it again: files that were cut short look like this",
            place=path,
        ) from error


def _expect_as_many(path: Path, heights: int) -> None:
    """Refuse a wrong count of heights, which GDAL fills or drops."""
    lines = path.read_bytes().splitlines(keepends=True) if path.is_file() else []
    keys = (line.split()[:1] for line in lines)
    head = next((n for n, key in enumerate(keys) if key and (not key[0][:1].isalpha() or key[0].lower() == b"nan")), 0)
    blank = np.frombuffer(b" " + b"".join(lines[head:]), np.uint8) <= ord(" ")
    if lines and (found := int((blank[:-1] & ~blank[1:]).sum())) != heights:
        raise BadInput(f"expected {heights} heights, as its header says, not {found}", code="damaged-file", place=path)


def _at_least_four(span: tuple[int, int], size: int) -> tuple[int, int]:
    first = max(min(span[0], size - 4), 0)
    return first, max(span[1], first + 4)
