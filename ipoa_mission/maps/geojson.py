"""Read GeoJSON (RFC 7946), also one value a line; ED-269 and Overpass's JSON, too.

QGIS may name another `crs`. A large file is read as a stream of features.
"""

import json
import re
from codecs import BOM_UTF8
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain, islice
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any, BinaryIO

from pyproj import CRS
from pyproj.exceptions import CRSError

from ipoa_mission.errors import BadInput, NoCoordinateSystem, TooLarge, WrongFormat
from ipoa_mission.files import read_bytes, read_text, why_no_json
from ipoa_mission.maps.feature import BATCH, EMPTY_SHAPE, Feature, read_all
from ipoa_mission.maps.geozones import ed269_features, is_ed269, layers_apart, limit_tags, zone_tags
from ipoa_mission.maps.json_shapes import SHAPES, ToDegrees, degrees_of, shape_of, unchanged
from ipoa_mission.maps.osm import is_overpass, overpass_features
from ipoa_mission.maps.properties import blank_keys, find_truncated, tags_of

LARGEST_WHOLE = 20_000_000  # a larger file is read as a stream [bytes]
_NOT_BLANK = re.compile(r"[^ \t\n\r\x1e]")  # RFC 8142: \x1e


def read_geojson(path: Path) -> tuple[Feature, ...]:
    text = read_text(path)
    try:
        values = _values(text)
    except json.JSONDecodeError as error:
        words = f"{error.msg[:1].lower()}{error.msg[1:]}"
        raise WrongFormat(words, hint=why_no_json(text, error.pos), place=f"{path}: line {error.lineno}") from error
    except ValueError:
        raise TooLarge("expected numbers that fit in 64 bits, not one of thousands of digits", place=path) from None
    except RecursionError:
        raise TooLarge("expected a map, not endlessly nested brackets", place=path) from None
    if len(values) == 1:
        return _features_of(values[0], path, str(path))
    numbered = ((value, path, f"{path}: value {n}") for n, value in enumerate(values, 1))
    return tuple(chain.from_iterable(read_all(_features_of, numbered)))


def _values(text: str) -> list[Any]:
    decode = json.JSONDecoder().raw_decode
    values = list[Any]()
    index = _first(text, 0)
    while index < len(text) or not values:
        if values and text[index] != "{":
            raise json.JSONDecodeError("Extra data", text, index)
        value, end = decode(text, index)
        values.append(value)
        index = _first(text, end)
    return values


def _first(text: str, index: int) -> int:
    """Return the place of the next letter that is not blank."""
    match = _NOT_BLANK.search(text, index)
    return len(text) if match is None else match.start()


def _features_of(document: Any, path: Path, place: str) -> tuple[Feature, ...]:
    if is_ed269(document):
        return ed269_features(document, path)
    if is_overpass(document):
        return overpass_features(document, path)
    kind = document.get("type") if isinstance(document, dict) else None
    if kind == "FeatureCollection":
        features = document.get("features")
        if not isinstance(features, list):
            raise BadInput("expected a list", place=f"{place}: features")
        placed = [(f"{place}: features[{i}]{_number(feature)}", feature) for i, feature in enumerate(features)]
    elif kind == "Feature":
        placed = [(f"{place}: feature", document)]
    elif isinstance(kind, str) and kind in {*SHAPES, "GeometryCollection"}:
        placed = [(f"{place}: feature", {"type": "Feature", "geometry": document})]
    else:
        cityjson = (
            "CityJSON is not read: export footprints with a `height` [m] as GeoJSON or GeoPackage, for example with "
            "QGIS; cjio writes neither"
        )
        usual = "a map is GeoJSON (one value, or one a line) or Overpass's JSON"
        hint = cityjson if str(kind).startswith("CityJSON") else usual
        raise WrongFormat(f"expected 'FeatureCollection', not {kind!r:.40}", hint=hint, place=f"{place}: type")
    return _features(placed, _coordinate_system(document.get("crs"), path))


def _features(placed: Sequence[tuple[str, Any]], to_degrees: ToDegrees) -> tuple[Feature, ...]:
    apart = ((place, part, to_degrees) for place, feature in placed for part in layers_apart(feature))
    return read_all(_feature, apart)


def _number(feature: Any) -> str:
    number = feature.get("id") if isinstance(feature, dict) else None
    return f" ({number})" if isinstance(number, str) and number else ""


def _feature(place: str, feature: Any, to_degrees: ToDegrees) -> Feature:
    if not isinstance(feature, dict) or feature.get("type") != "Feature":
        raise BadInput("expected a Feature", place=place)
    geometry, properties = feature.get("geometry"), feature.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    tags = dict(tags_of(properties)) | dict(zone_tags(properties))
    if isinstance(feature.get("id"), str | int):
        tags.setdefault("@id", str(feature["id"]))
    shape = EMPTY_SHAPE if geometry is None else shape_of(geometry, f"{place}.geometry", to_degrees)
    if isinstance(geometry, dict) and isinstance(geometry.get("layer"), dict):
        tags |= dict(limit_tags(geometry["layer"]))
    return Feature(place, shape, tags, frozenset(blank_keys(properties)), find_truncated(properties, shape))


def _coordinate_system(crs: Any, path: Path) -> ToDegrees:
    """Read `crs` (GeoJSON of 2008, and QGIS)."""
    if crs is None:
        return unchanged
    try:
        return degrees_of(CRS.from_user_input(crs["properties"]["name"]))
    except (KeyError, TypeError, CRSError) as error:
        words = "expected the name of a coordinate system, such as 'EPSG:32633'"
        raise NoCoordinateSystem(words, place=f"{path}: crs") from error


def is_large(path: Path) -> bool:
    return path.is_file() and path.stat().st_size > LARGEST_WHOLE


def stream_geojson(path: Path) -> Iterator[Sequence[Feature]]:
    """Read batches of features; a document of another kind whole."""
    kind = _first_at("type", path)
    read = 0
    try:
        if kind == "FeatureCollection":
            to_degrees = _coordinate_system(_first_at("crs", path), path)
            for values in _batches("features.item", path, "features[{}]"):
                placed = [(f"{path}: features[{n}]{_number(value)}", value) for n, value in enumerate(values, read)]
                yield _features(placed, to_degrees)
                read += len(values)
        elif kind == "Feature":
            for values in _batches("", path, "value {}", 1):
                numbered = ((value, path, f"{path}: value {n}") for n, value in enumerate(values, read + 1))
                yield tuple(chain.from_iterable(read_all(_features_of, numbered)))
                read += len(values)
    except RecursionError:
        raise TooLarge("expected a map, not endlessly nested brackets", place=path) from None
    if not read:
        yield read_geojson(path)


def _first_at(key: str, path: Path) -> Any:
    """Return a member of the first value in a file; None where it has none, or is not JSON."""
    read_bytes(path, 1)  # or Unreadable
    with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as data:
        if data.find(f'"{key}"'.encode()) < 0:
            return None
    with suppress(WrongFormat):
        return next(chain.from_iterable(_batches(key, path, "", most=1)), None)
    return None


def _batches(prefix: str, path: Path, number: str, first: int = 0, most: int = BATCH) -> Iterator[list[Any]]:
    """Parse the values at a prefix of a file, or all its values, `most` at a time; errors count from `first`."""
    import ijson

    with path.open("rb") as file:
        chunks = _Chunks(file, path)
        values = ijson.items(chunks, prefix, multiple_values=not prefix, use_float=True, buf_size=16_384)
        while True:
            batch = list[Any]()
            try:
                batch.extend(islice(values, most))
            except ijson.JSONError as error:
                words, *_ = re.split(r"\n|\\n", str(error).removeprefix("b'"))
                place = f"{path}: {number.format(first + len(batch))}"
                raise WrongFormat(f"expected JSON here and after it, not a {words}", place=place) from error
            if not batch:
                return
            yield batch
            first += len(batch)


class _Chunks:
    """Reads a file without its byte order mark and the separators of RFC 8142."""

    def __init__(self, file: BinaryIO, path: Path) -> None:
        self._file = file
        self._path = path
        self._depth = 0
        file.seek(len(BOM_UTF8) if file.read(len(BOM_UTF8)) == BOM_UTF8 else 0)

    def read(self, size: int) -> bytes:
        data = self._file.read(size)
        self._depth += data.count(b"[") + data.count(b"{") - data.count(b"]") - data.count(b"}")
        if self._depth > 5000:  # deeper than any map
            raise TooLarge("expected a map, not endlessly nested brackets", place=self._path)
        return data.replace(b"\x1e", b"\n")
