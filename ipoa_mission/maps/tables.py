"""Shapefile, FlatGeobuf and GeoPackage, as GDAL reads them (needs pyogrio): each row is a feature.

GDAL goes by what a file holds, not by its name, and some formats name other files: a file must begin as its name says.
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
from ipoa_mission.maps.properties import blank_keys, cut_off, tags_of

#: How files begin, by their suffix.
BEGINS = {".shp": b"\x00\x00\x27\x0a", ".fgb": b"fgb", ".gpkg": b"SQLite format 3\x00"}
HEADER, ROW = 100, 8  # of a .shx [bytes]
MOST_ROWS = 5_000_000
WRONG_SYSTEM = "the file names a coordinate system (a Shapefile in its .prj) that its coordinates do not fit"


def read_table(path: Path) -> tuple[Feature, ...]:
    """The features of all layers that have shapes; fields are tags.

    Raises:
        BadInput: naming the file, the layer and the row, and what was expected there.
        BadInput: pyogrio is not installed.
    """
    pyogrio = imported("pyogrio", f"{path}: reading it needs pyogrio, which is not installed", "maps", BadInput)
    suffix = path.suffix.lower()
    if not read_bytes(path, 16).startswith(BEGINS[suffix]):
        raise WrongFormat(f"expected a {suffix} file, but it does not begin like one", place=path)
    if suffix == ".shp":
        _expect_whole(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what GDAL mends it says; what it makes of it is judged here
            layers = [str(name) for name, kind in pyogrio.list_layers(path) if kind is not None]
            features = [feature for layer in layers for feature in _rows(path, layer, pyogrio, len(layers) > 1)]
    except (RuntimeError, ValueError, UnboundLocalError) as error:  # of pyogrio (with a .prj that is none), PROJ, texts
        beside = "; the .shx and .dbf files must lie beside a .shp" if suffix == ".shp" else ""
        raise DamagedFile(f"cannot be read: {error}{beside}", place=path) from error
    if not features:
        raise NothingThere("expected shapes, but there are none that can be read", place=path)
    return tuple(features)


def _rows(path: Path, layer: str, pyogrio: Any, named: bool) -> tuple[Feature, ...]:
    meta, numbers, shapes, fields = pyogrio.raw.read(path, layer=layer, return_fids=True, max_features=MOST_ROWS)
    place = f"{path}: {layer}" if named else f"{path}: row"
    if not meta["crs"]:
        raise NoCoordinateSystem(
            "expected a file that names its coordinate system",
            hint="a Shapefile says it in the .prj file beside it",
            place=path,
        )
    to_degrees = Transformer.from_crs(CRS.from_user_input(meta["crs"]), "OGC:CRS84", always_xy=True)
    if (count := pyogrio.read_info(path, layer=layer)["features"]) > len(numbers):
        raise DamagedFile(f"expected {count} rows, but only {len(numbers)} can be read", place=path)
    is_cut = path.suffix.lower() == ".shp"
    rows = (
        {
            uncut(str(name), str(column[n])) if is_cut else str(name): _plain(column[n])
            for name, column in zip(meta["fields"], fields, strict=True)
        }
        for n in range(len(numbers))
    )
    each = zip(numbers, shapes, rows, strict=True)
    return read_all(_feature, ((f"{place}[{number}]", shape, row, to_degrees) for number, shape, row in each))


def _expect_whole(path: Path) -> None:
    """See that the files of a Shapefile are all there, whole, and of as many rows.

    Raises:
        BadInput: they are not.
    """
    sizes = {}
    for suffix in (".shx", ".dbf"):
        beside = next(
            (one for one in (path.with_suffix(suffix), path.with_suffix(suffix.upper())) if one.exists()), None
        )
        if beside is None:
            raise DamagedFile(
                f"expected the {suffix} file beside it", hint="a Shapefile is .shp, .shx and .dbf", place=path
            )
        sizes[suffix] = read_bytes(beside, HEADER), beside.stat().st_size
    for begin, size in ((read_bytes(path, HEADER), path.stat().st_size), sizes[".shx"]):
        if len(begin) < HEADER or int.from_bytes(begin[24:28], "big") * 2 > size:
            raise DamagedFile("expected a whole Shapefile, but its end is missing", place=path)
    begin, size = sizes[".dbf"]
    rows, first, each = (int.from_bytes(begin[a:b], "little") for a, b in ((4, 8), (8, 10), (10, 12)))
    if first + rows * each > size or rows != (sizes[".shx"][1] - HEADER) // ROW:
        raise DamagedFile(
            f"expected a .dbf file with the {(sizes['.shx'][1] - HEADER) // ROW} rows of the .shx", place=path
        )


def _feature(place: str, shape: Any, row: dict[str, Any], to_degrees: Transformer) -> Feature:
    def convert(corners: Corners) -> Corners:
        return on_earth(np.column_stack(to_degrees.transform(*corners.T)), place, WRONG_SYSTEM)

    tags, blank, missing = dict(tags_of(row)), frozenset(blank_keys(row)), cut_off(row)
    if shape is None:
        return Feature(place, shapely.GeometryCollection(), tags, blank)
    try:
        flat = shapely.transform(shapely.force_2d(shapely.from_wkb(shape)), convert)
    except shapely.errors.GEOSException as error:
        raise BadInput(f"expected a shape: {error}", place=place) from error
    return Feature(place, flat, tags, blank, missing and missing._replace(shape=flat))


def _plain(value: Any) -> Any:
    """A field's value without NumPy's type."""
    return value.item() if isinstance(value, np.generic) else value
