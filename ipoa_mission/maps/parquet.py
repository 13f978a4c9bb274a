"""Read GeoParquet by pyarrow."""

import json
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from pyproj import CRS
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, DamagedFile, NoCoordinateSystem, NothingThere, TooLarge, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import Corners, Feature, on_earth
from ipoa_mission.maps.geojson import degrees_of
from ipoa_mission.maps.keys import Means, meaning
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.properties import PACKED, blank_keys, tags_of, truncated


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
    return [_feature(f"{path}: row[{row + n}]", drawn[n], each) for n, each in zip(wanted.tolist(), tags, strict=True)]


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


def _feature(place: str, shape: Any, row: Mapping[str, Any]) -> Feature:
    plain = {name: _plain(value) for name, value in row.items()}
    return Feature(place, shape, dict(tags_of(plain)), frozenset(blank_keys(plain)), truncated(plain, shape))


def _plain(value: Any) -> Any:
    """Convert to JSON; Arrow reads a map as pairs."""
    if isinstance(value, Decimal):
        return float(value)
    is_map = isinstance(value, list) and all(isinstance(pair, tuple) for pair in value)
    return dict(value) if is_map else value
