"""Read Shapefile, FlatGeobuf and GeoPackage by GDAL (pyogrio), and GeoParquet by pyarrow.

GDAL ignores the suffix, and some formats open other files: the first bytes must match it.
"""

import json
import warnings
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, DamagedFile, NoCoordinateSystem, NothingThere, TooLarge, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import Corners, Feature, on_earth, read_all
from ipoa_mission.maps.geojson import degrees_of
from ipoa_mission.maps.keys import Means, meaning
from ipoa_mission.maps.kinds import uncut
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.properties import PACKED, blank_keys, tags_of, truncated

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


class _Shapes(NamedTuple):
    """Shapes, their conversion, and box columns: west, south, east, north [deg]."""

    column: str
    to_degrees: Callable[[Corners], Corners]
    boxes: tuple[str, ...]


def read_parquet(path: Path, around: MapWindow) -> Iterator[list[Feature]]:
    needed = f"{path}: reading it needs pyarrow, which is not installed"
    parquet = imported("pyarrow.parquet", needed, "maps", BadInput)
    arrow = imported("pyarrow", needed, "maps", BadInput)
    if read_bytes(path, 4) != b"PAR1":
        raise WrongFormat("expected a Parquet file, but its first bytes are those of another format", place=path)
    any_there = False
    try:
        with parquet.ParquetFile(path) as file:
            for features in _rows(file, arrow, path, around):
                any_there = True
                yield features
    except (arrow.ArrowException, OSError, ValueError) as error:
        raise DamagedFile(f"expected a whole Parquet file: {str(error).partition(chr(10))[0]}", place=path) from error
    if not any_there and not around.elsewhere:
        raise NothingThere("expected rows with shapes, but the file has none", place=path)


def _rows(file: Any, arrow: Any, path: Path, around: MapWindow) -> Iterator[list[Feature]]:
    shapes = _shapes_of(file, arrow, path)
    columns = [shapes.column, *_tag_columns(file.schema_arrow, arrow, shapes.column)]
    row, largest = 0, 2_000_000_000  # unpacked [bytes]
    for number in range(file.num_row_groups):
        group = file.metadata.row_group(number)
        if group.total_byte_size > largest:
            raise TooLarge(f"expected groups of rows of at most {largest / 1e9:g} GB", place=path)
        if (box := _box_of(group, shapes.boxes)) is not None and not around.wants(box, group.num_rows).any():
            row += group.num_rows
            continue
        for batch in file.iter_batches(4096, [number], columns):
            if features := _features(batch, shapes, path, row, around):
                yield features
            row += batch.num_rows


def _shapes_of(file: Any, arrow: Any, path: Path) -> _Shapes:
    metadata = (file.schema_arrow.metadata or {}).get(b"geo")
    if metadata is None:
        raise NothingThere(
            "expected a GeoParquet file, but none of its columns is a geometry",
            hint="a table of places becomes one by GeoPandas: GeoDataFrame.to_parquet",
            place=path,
        )
    try:
        geo = json.loads(metadata)
        column = geo["primary_column"]
        about = geo["columns"][column]
        encoding, system = about["encoding"], about.get("crs", "OGC:CRS84")
        covering = (about.get("covering") or {}).get("bbox") or {}
        boxes = tuple(".".join(covering[side]) for side in ("xmin", "ymin", "xmax", "ymax")) if covering else ()
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise BadInput("expected GeoParquet's metadata of its columns", place=f"{path}: geo") from error
    schema = file.schema_arrow
    kind = schema.field(column).type if column in schema.names else None
    if encoding != "WKB" or kind not in (arrow.binary(), arrow.large_binary()):
        raise BadInput(f"expected shapes as WKB, not as {encoding!r:.40} in {kind}", place=f"{path}: {column}")
    if system is None:
        raise NoCoordinateSystem("expected a file that names its coordinate system", place=path)
    try:
        known = CRS.from_user_input(system)
    except (CRSError, TypeError) as error:
        raise NoCoordinateSystem("expected a coordinate system as PROJ's JSON has it", place=f"{path}: crs") from error
    return _Shapes(column, degrees_of(known), boxes if known.is_geographic else ())


def _tag_columns(schema: Any, arrow: Any, shapes: str) -> Iterator[str]:
    for field in schema:
        if field.name == "names" and arrow.types.is_struct(field.type):
            yield "names.primary"  # Overture's
        elif field.name == shapes:
            continue
        elif field.name in PACKED or not arrow.types.is_nested(field.type) or meaning(field.name) is not Means.NOTHING:
            yield field.name


def _box_of(group: Any, columns: tuple[str, ...]) -> NDArray[np.float64] | None:
    about = {}
    for n in range(group.num_columns if columns else 0):
        column = group.column(n)
        if column.path_in_schema in columns:
            about[column.path_in_schema] = column.statistics
    if not columns or any(about.get(name) is None or not about[name].has_min_max for name in columns):
        return None
    west, south, east, north = (about[name] for name in columns)
    box = np.array([[west.min, south.min, east.max, north.max]], float)
    goes_round = west.max > east.max or west.min > east.min  # across longitude 180
    return None if goes_round or not np.isfinite(box).all() else box


def _features(batch: Any, shapes: _Shapes, path: Path, row: int, around: MapWindow) -> list[Feature]:
    drawn = _drawn(batch.column(shapes.column).to_numpy(zero_copy_only=False), shapes.to_degrees, path, row)
    wanted = np.flatnonzero(around.wants(shapely.bounds(drawn)))
    tags = batch.drop_columns([shapes.column]).take(wanted).to_pylist() if len(wanted) else []
    return [_in_row(f"{path}: row[{row + n}]", drawn[n], each) for n, each in zip(wanted.tolist(), tags, strict=True)]


def _drawn(wkb: NDArray[Any], to_degrees: Callable[[Corners], Corners], path: Path, row: int) -> NDArray[Any]:
    """Return shapes in degrees; null becomes empty."""
    try:
        shapes = shapely.force_2d(shapely.from_wkb(wkb))
        shapes[shapely.is_missing(shapes)] = shapely.GeometryCollection()
        return np.asarray(shapely.transform(shapes, lambda corners: on_earth(to_degrees(corners), str(path))))
    except (shapely.errors.GEOSException, BadInput) as error:
        if len(wkb) == 1:
            bad = error if isinstance(error, BadInput) else BadInput(f"expected a shape: {error}", code="invalid-ring")
            bad.place = f"{path}: row[{row}]"
            raise bad from error
        half = len(wkb) // 2
        first = _drawn(wkb[:half], to_degrees, path, row)
        return np.concatenate([first, _drawn(wkb[half:], to_degrees, path, row + half)])


def _in_row(place: str, shape: Any, row: Mapping[str, Any]) -> Feature:
    plain = {name: _plain(value) for name, value in row.items()}
    return Feature(place, shape, dict(tags_of(plain)), frozenset(blank_keys(plain)), truncated(plain, shape))


def _plain(value: Any) -> Any:
    """Convert to JSON; Arrow reads a map as pairs."""
    if isinstance(value, Decimal):
        return float(value)
    is_map = isinstance(value, list) and all(isinstance(pair, tuple) for pair in value)
    return dict(value) if is_map else value
