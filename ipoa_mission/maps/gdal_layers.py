"""Read Shapefile, FlatGeobuf and GeoPackage by GDAL (pyogrio).

GDAL ignores the suffix, and some formats open other files: the first bytes must match it.
"""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pyproj import CRS, Transformer

from ipoa_mission.errors import BadInput, DamagedFile, NoCoordinateSystem, NothingThere, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import Corners, Feature, on_earth, read_all
from ipoa_mission.maps.kinds import uncut
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.properties import blank_keys, tags_of, truncated

FIRST_BYTES = {".shp": b"\x00\x00\x27\x0a", ".fgb": b"fgb", ".gpkg": b"SQLite format 3\x00"}


def read_layers(path: Path, around: MapWindow) -> tuple[Feature, ...]:
    pyogrio = imported("pyogrio", f"{path}: reading it needs pyogrio, which is not installed", "maps", BadInput)
    suffix = path.suffix.lower()
    if not read_bytes(path, 16).startswith(FIRST_BYTES[suffix]):
        raise WrongFormat(f"expected a {suffix} file, but its first bytes are those of another format", place=path)
    if suffix == ".shp":
        _expect_whole(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # GDAL's repairs
            layers = [str(name) for name, kind in pyogrio.list_layers(path) if kind is not None]
            several = len(layers) > 1
            features = [feature for name in layers for feature in _Layer(path, name, pyogrio, several).read(around)]
    except (RuntimeError, ValueError, UnboundLocalError) as error:  # invalid .prj, PROJ, texts
        note = "; the .shx and .dbf files must be next to a .shp" if suffix == ".shp" else ""
        raise DamagedFile(f"cannot be read: {error}{note}", place=path) from error
    if not features and not around.elsewhere:
        raise NothingThere("expected shapes, but there are none that can be read", place=path)
    around.expect_near(path)
    return tuple(features)


class _Layer:
    def __init__(self, path: Path, name: str, pyogrio: Any, named: bool) -> None:
        self._path, self._info = path, pyogrio.read_info(path, layer=name)
        self._place = f"{path}: {name}" if named else f"{path}: row"
        self._name, self._pyogrio = name, pyogrio
        if not self._info["crs"]:
            words = "expected a file that names its coordinate system"
            raise NoCoordinateSystem(words, place=path, hint="a Shapefile names it in the .prj file next to it")
        self._degrees = Transformer.from_crs(CRS.from_user_input(self._info["crs"]), "OGC:CRS84", always_xy=True)

    def read(self, around: MapWindow) -> list[Feature]:
        count, box, nulls = self._info["features"], self._box(around), list[Feature]()
        if box is not None and self._path.suffix.lower() != ".fgb":  # a FlatGeobuf with such rows has no index
            column = self._info["geometry_name"].replace('"', '""')
            nulls = self._features(where=f'"{column}" IS NULL' if column else "OGR_GEOMETRY IS NULL")
        if box is None or not self._is_indexed_whole(count - len(nulls)):
            features = self._features()
            if count > len(features):
                raise DamagedFile(f"expected {count} rows, but only {len(features)} can be read", place=self._path)
            return features
        features = self._features(bbox=box)
        boxes = np.array([feature.shape.bounds for feature in features], float).reshape(-1, 4)
        around.elsewhere += count - len(features) - len(nulls)
        return [*nulls, *(feature for feature, near in zip(features, around.wants(boxes), strict=True) if near)]

    def _box(self, around: MapWindow) -> tuple[float, ...] | None:
        """Return the window in the layer's coordinates; None: read all."""
        window, bounds = around.window, self._info["total_bounds"]
        if window is None or bounds is None or window.west < -180.0 or window.east > 180.0:
            return None
        west, south, east, north = bounds = np.array(self._degrees.transform_bounds(*bounds))
        box: tuple[float, ...] = self._degrees.transform_bounds(*window, direction="INVERSE")
        sound = -180.0 <= west <= east <= 180.0 and -90.0 <= south <= north <= 90.0 and np.isfinite(box).all()
        if not sound:
            return None
        around.wants(bounds[None], things=0)
        return box

    def _is_indexed_whole(self, shapes: int) -> bool:
        """Return whether all rows are in a spatial index; refuse a truncated file."""
        suffix, count = self._path.suffix.lower(), self._info["features"]
        if suffix == ".shp":  # an index may be older
            return not any(self._path.with_suffix(index).exists() for index in (".qix", ".sbn"))
        try:
            if suffix == ".gpkg":
                name, column = self._name.replace('"', '""'), self._info["geometry_name"]
                rows = self._pyogrio.raw.read(self._path, sql=f'SELECT COUNT(*) AS n FROM "rtree_{name}_{column}"')
                return int(rows[3][0][0]) == shapes
            if not self._info["capabilities"]["random_read"]:
                return False
            self._read(fids=[count - 1])
        except RuntimeError:
            if suffix == ".gpkg":  # no index
                return True
            raise DamagedFile(f"expected {count} rows, but the last cannot be read", place=self._path) from None
        return True

    def _read(self, **chosen: Any) -> Any:
        return self._pyogrio.raw.read(self._path, layer=self._name, return_fids=True, **chosen)

    def _features(self, **chosen: Any) -> list[Feature]:
        most = 5_000_000
        for reserved in (min(most, max(1, self._info["features"] + 1)), most):
            meta, numbers, shapes, fields = self._read(max_features=reserved, **chosen)
            if len(numbers) < reserved:
                break
        columns = [column.tolist() for column in fields]
        is_cut = self._path.suffix.lower() == ".shp"
        rows = (
            {
                uncut(str(name), str(column[n])) if is_cut else str(name): column[n]
                for name, column in zip(meta["fields"], columns, strict=True)
            }
            for n in range(len(numbers))
        )
        each = zip(numbers, shapes, rows, strict=True)
        return [*read_all(_feature, ((f"{self._place}[{n}]", shape, row, self._degrees) for n, shape, row in each))]


def _expect_whole(path: Path) -> None:
    """Check that a Shapefile's files are whole, with equal rows."""
    header, sizes = 100, {}  # [bytes]
    for suffix in (".shx", ".dbf"):
        sidecar = next((p for p in map(path.with_suffix, (suffix, suffix.upper())) if p.exists()), None)
        if sidecar is None:
            words = f"expected the {suffix} file next to it"
            raise DamagedFile(words, hint="a Shapefile is .shp, .shx and .dbf", place=path)
        sizes[suffix] = read_bytes(sidecar, header), sidecar.stat().st_size
    for begin, size in ((read_bytes(path, header), path.stat().st_size), sizes[".shx"]):
        if len(begin) < header or int.from_bytes(begin[24:28], "big") * 2 > size:
            raise DamagedFile("expected a whole Shapefile, but its end is missing", place=path)
    begin, size = sizes[".dbf"]
    rows, first, length = (int.from_bytes(begin[a:b], "little") for a, b in ((4, 8), (8, 10), (10, 12)))
    indexed = (sizes[".shx"][1] - header) // 8
    if first + rows * length > size or rows != indexed:
        raise DamagedFile(f"expected a .dbf file with the {indexed} rows of the .shx", place=path)


def _feature(place: str, shape: Any, row: dict[str, Any], to_degrees: Transformer) -> Feature:
    def convert(corners: Corners) -> Corners:
        hint = "the file names a coordinate system (a Shapefile in its .prj) that its coordinates do not fit"
        return on_earth(np.column_stack(to_degrees.transform(*corners.T)), place, hint)

    tags, blank = dict(tags_of(row)), frozenset(blank_keys(row))
    if shape is None:
        return Feature(place, shapely.GeometryCollection(), tags, blank)
    try:
        flat = shapely.transform(shapely.force_2d(shapely.from_wkb(shape)), convert)
    except shapely.errors.GEOSException as error:
        raise BadInput(f"expected a shape: {error}", place=place) from error
    return Feature(place, flat, tags, blank, truncated(row, flat))
