"""Read Shapefile, FlatGeobuf and GeoPackage by GDAL (pyogrio, with pyarrow).

Some formats open other files, and GDAL ignores the suffix: the first bytes must match it.
"""

import warnings
from collections.abc import Sequence
from decimal import Decimal
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from pyproj import CRS

from ipoa_mission.errors import (
    BadInput,
    DamagedFile,
    InvalidRing,
    NoCoordinateSystem,
    NothingThere,
    WrongFormat,
    imported,
)
from ipoa_mission.files import read_bytes
from ipoa_mission.maps.feature import BATCH, EMPTY_SHAPE, Corners, Feature, is_altitude, on_earth
from ipoa_mission.maps.json_shapes import ToDegrees, degrees_of
from ipoa_mission.maps.kinds import restore_key
from ipoa_mission.maps.map_window import MapWindow
from ipoa_mission.maps.properties import feature_of_properties, tags_of

FIRST_BYTES = {".shp": b"\x00\x00\x27\x0a", ".fgb": b"fgb", ".gpkg": b"SQLite format 3\x00"}


def read_table(path: Path, around: MapWindow) -> tuple[Feature, ...]:
    arrow = imported("pyarrow", f"{path}: reading it needs pyarrow, which is not installed", "maps", BadInput)
    suffix = path.suffix.lower()
    if not read_bytes(path, 16).startswith(FIRST_BYTES[suffix]):
        raise WrongFormat(f"expected a {suffix} file, but its first bytes are those of another format", place=path)
    try:
        features = tuple(chain.from_iterable(_layers(path, around)))
    except (RuntimeError, ValueError, OSError, UnboundLocalError, arrow.ArrowException) as error:  # of each library
        raise DamagedFile(f"expected a whole {suffix} file: {str(error).partition(chr(10))[0]}", place=path) from error
    if not features and not around.elsewhere:
        raise NothingThere("expected rows with shapes, but there are none that can be read", place=path)
    return features


def _layers(path: Path, around: MapWindow) -> list[list[Feature]]:
    pyogrio = imported("pyogrio", f"{path}: reading it needs pyogrio, which is not installed", "maps", BadInput)
    if path.suffix.lower() == ".shp":
        _expect_whole(path)
    with warnings.catch_warnings(action="ignore"):  # GDAL's repairs
        layers = [str(name) for name, kind in pyogrio.list_layers(path) if kind is not None]
        places = {name: f"{path}: {name}" if len(layers) > 1 else f"{path}: row" for name in layers}
        return [_layer(pyogrio, path, name, place, around) for name, place in places.items()]


def _layer(pyogrio: Any, path: Path, name: str, place: str, around: MapWindow) -> list[Feature]:
    info = pyogrio.read_info(path, layer=name)
    count = 0
    features = list[Feature]()
    if not info["crs"]:
        words = "expected a file that names its coordinate system"
        raise NoCoordinateSystem(words, place=path, hint="a Shapefile names it in the .prj file next to it")
    to_degrees = degrees_of(CRS.from_user_input(info["crs"]))
    is_cut = path.suffix.lower() == ".shp"
    chosen = {"layer": name, "return_fids": True, "batch_size": BATCH, "use_pyarrow": True}
    with pyogrio.raw.open_arrow(path, **chosen) as (meta, batches):
        column = meta["geometry_name"] or "wkb_geometry"
        for batch in batches:
            count += batch.num_rows
            number = batch.schema.names[0]
            places = [f"{place}[{n}]" for n in batch.column(number).to_pylist()]
            wkb = batch.column(column).to_numpy(zero_copy_only=False)
            shapes = _drawn(wkb, to_degrees, places)
            wanted = np.flatnonzero(around.wants(shapely.bounds(shapes)))
            rows = batch.drop_columns([number, column]).take(wanted).to_pylist()
            highest = _highest(wkb[wanted]).tolist()
            for n, row, altitude in zip(wanted.tolist(), rows, highest, strict=True):
                values = {key: float(value) if isinstance(value, Decimal) else value for key, value in row.items()}
                plain = {restore_key(key, str(value)) if is_cut else key: value for key, value in values.items()}
                features.append(feature_of_properties(places[n], shapes[n], plain, dict(tags_of(plain)), altitude))
    if count < info["features"]:
        raise DamagedFile(f"expected {info['features']} rows, but only {count} can be read", place=path)
    return features


def _expect_whole(path: Path) -> None:
    header = 100  # [bytes]
    sizes = {}
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


def _highest(wkb: NDArray[Any]) -> NDArray[np.float64]:
    """Return the greatest third coordinate of each shape [m], -inf without one."""
    shapes = shapely.from_wkb(wkb, on_invalid="ignore")
    corners, numbers = shapely.get_coordinates(shapes, include_z=True, return_index=True)
    highest = np.full(len(shapes), -np.inf)
    np.maximum.at(highest, numbers, [up if is_altitude(up) else -np.inf for up in corners[:, 2].tolist()])
    return highest


def _drawn(wkb: NDArray[Any], to_degrees: ToDegrees, places: Sequence[str]) -> NDArray[Any]:

    def convert(corners: Corners) -> Corners:
        hint = "the file names a coordinate system (a Shapefile in its .prj) that its coordinates do not fit"
        return on_earth(to_degrees(corners), places[0], hint)

    try:
        shapes = shapely.force_2d(shapely.from_wkb(wkb))
        shapes[shapely.is_missing(shapes)] = EMPTY_SHAPE
        return np.asarray(shapely.transform(shapes, convert))
    except (shapely.errors.GEOSException, BadInput) as error:
        if len(wkb) > 1:
            half = len(wkb) // 2
            first = _drawn(wkb[:half], to_degrees, places[:half])
            return np.concatenate([first, _drawn(wkb[half:], to_degrees, places[half:])])
        if isinstance(error, BadInput):
            raise
        raise InvalidRing(f"expected a shape: {error}", place=places[0]) from error
