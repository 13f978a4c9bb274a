"""Read KML and KMZ: of altitudes the greatest counts."""

import contextlib
import io
import lzma
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, NothingThere, TooLarge, WrongFormat
from ipoa_mission.files import read_text, reading, reading_xml
from ipoa_mission.maps.feature import DEEPEST, EMPTY_SHAPE, Corners, Feature, Missing, is_altitude, on_earth, read_all

# Content in another file.
NOT_READ = {
    "NetworkLink": "whose places are in another file",
    "GroundOverlay": "an image on the ground",
    "PhotoOverlay": "an image in the air",
    "Model": "a body in another file",
}
REMEDY = "save what it shows as a KML of its own, and name that under [[maps]]"
BROKEN_ZIP = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError, NotImplementedError, RuntimeError,
    ValueError,
)  # fmt: skip


def read_kml(path: Path) -> tuple[Feature, ...]:
    return _read(read_text(path).encode(), path)


def read_kmz(path: Path) -> tuple[Feature, ...]:
    """Read the first KML, as Google Earth."""
    largest = 64 << 20  # bytes; a .kmz may expand a thousandfold
    with reading(path):
        try:
            with zipfile.ZipFile(path) as archive:
                names = [name for name in archive.namelist() if name.lower().endswith(".kml")]
                if not names:
                    raise NothingThere("expected a .kml in the archive, but it has none", place=path)
                with archive.open(names[0]) as file:
                    text = file.read(largest + 1)
        except BROKEN_ZIP as error:
            raise WrongFormat(f"expected a KMZ, a .kml in a zip archive: {error}", place=path) from error
    if len(text) > largest:
        raise TooLarge(f"expected a .kml of at most {largest >> 20} MB in the archive", place=path)
    others = (
        Feature(f"{path}: {name}", EMPTY_SHAPE, {}, missing=Missing(f"{name}, a second KML", EMPTY_SHAPE, REMEDY))
        for name in names[1:]
    )
    return (*_read(text, path), *others)


def _read(text: bytes, path: Path) -> tuple[Feature, ...]:
    with reading_xml(path):
        root = _parse(text, path)
    if root.tag != "kml":
        raise WrongFormat(f"expected a kml document, not {root.tag}", place=path)
    placemarks = enumerate([*_placemarks(root, path)])
    return read_all(_feature, ((element, f"{path}: Placemark[{i}]") for i, element in placemarks))


def _parse(text: bytes, path: Path) -> ElementTree.Element:
    most = 500_000
    parser = cast(Any, ElementTree.iterparse(io.BytesIO(text)))
    for count, (_, element) in enumerate(parser):
        element.tag = element.tag.rpartition("}")[2]
        if count > most:
            raise TooLarge(f"expected a document of at most {most} elements", place=path)
    root: ElementTree.Element = parser.root
    return root


def _placemarks(root: ElementTree.Element, path: Path) -> Iterator[ElementTree.Element]:
    waiting = [(root, 0)]
    deepest = 64
    while waiting:
        element, depth = waiting.pop()
        if element.tag == "Placemark" and element.find(".//Placemark") is not None:
            raise BadInput("expected no Placemark inside another", place=path)
        if element.tag in ("Placemark", "NetworkLink", "GroundOverlay", "PhotoOverlay"):
            yield element
            continue
        if depth >= deepest:
            raise TooLarge(f"expected folders in no more than {deepest} others", place=path)
        waiting += [(child, depth + 1) for child in reversed(element)]


def _feature(placemark: ElementTree.Element, place: str) -> Feature:
    shapes = list(_shapes(placemark, place))
    heights, drawn = _drawn(placemark)
    tags = heights | dict(_tags(placemark))
    shape = shapes[0] if len(shapes) == 1 else shapely.GeometryCollection(shapes)
    return Feature(place, shape, tags, missing=_missing(placemark, place), drawn=drawn)


def _missing(placemark: ElementTree.Element, place: str) -> Missing | None:
    for element in placemark.iter():
        if element.tag in NOT_READ:
            sides = {each.tag: _text(each) for each in element.iter()}
            box = EMPTY_SHAPE
            with contextlib.suppress(KeyError, ValueError):
                box = shapely.box(*(float(sides[side]) for side in ("west", "south", "east", "north")))
                on_earth(shapely.get_coordinates(box), place)
            return Missing(f"{element.tag}, {NOT_READ[element.tag]}", box, REMEDY)
    return None


def _drawn(placemark: ElementTree.Element) -> tuple[dict[str, str], tuple[float, float]]:
    """Return the height of extruded shapes as a tag, and the altitudes of all."""
    modes = {"relativeToGround": "height", "absolute": "height:amsl"}
    extruded = dict[str, float]()
    highest = dict.fromkeys(modes.values(), -math.inf)
    for drawn in placemark.iter():
        key = modes.get(drawn.findtext("altitudeMode", "").strip())
        if key is not None and drawn.tag in {"Polygon", "LinearRing", "LineString", "Point", "Track"}:
            altitudes = [up for part in drawn.iter() if part.tag in ("coordinates", "coord") for up in _altitudes(part)]
            highest[key] = max([highest[key], *altitudes])
            if drawn.findtext("extrude", "").strip() in ("1", "true"):
                extruded[key] = max([extruded.get(key, 0.0), *altitudes])
    return {key: f"{top:.2f}" for key, top in extruded.items() if top > 0}, (highest["height"], highest["height:amsl"])


def _altitudes(element: ElementTree.Element) -> Iterator[float]:
    words = _words(_text(element)) if element.tag == "coordinates" else [",".join(_text(element).split())]
    for word in words:
        with contextlib.suppress(ValueError):
            yield from (float(number) for number in word.split(",")[2:3] if is_altitude(float(number)))


def _words(text: str) -> list[str]:
    return re.sub(r"\s*,\s*", ",", text).split()


def _tags(placemark: ElementTree.Element) -> Iterator[tuple[str, str]]:
    for element in placemark.iter():
        if element.tag in ("name", "description", "Data", "SimpleData"):
            key = element.get("name", element.tag)
            value = _text(element) or element.findtext("value", "").strip()
            if key and value:
                yield key, value


def _text(element: ElementTree.Element) -> str:
    return (element.text or "").strip()


def _shapes(parent: ElementTree.Element, place: str, depth: int = 0) -> Iterator[Any]:
    if depth > DEEPEST:
        raise TooLarge(f"expected collections in no more than {DEEPEST} others", place=place)
    for element in parent:
        element_place = f"{place}.{element.tag}"
        match element.tag:
            case "MultiGeometry" | "Document" | "Folder" | "MultiTrack":
                yield from _shapes(element, place, depth + 1)
            case "Point":
                yield shapely.Point(_corners(element, 1, element_place)[0])
            case "LineString":
                yield shapely.LineString(_corners(element, 2, element_place))
            case "LinearRing":
                yield shapely.Polygon(_corners(element, 3, element_place))
            case "Track":
                text = " ".join(",".join(_text(each).split()) for each in element.iterfind("coord"))
                yield shapely.LineString(_positions(text, 2, f"{element_place}.coord"))
            case "Polygon":
                yield _polygon(element, element_place)


def _polygon(element: ElementTree.Element, place: str) -> Any:
    outer = element.findall("outerBoundaryIs/*")
    inner = element.findall("innerBoundaryIs/*")
    if len(outer) != 1:
        raise BadInput(f"expected one LinearRing, not {len(outer)}", place=f"{place}.outerBoundaryIs")
    for ring in (*outer, *inner):
        if ring.tag != "LinearRing":
            raise BadInput(f"expected a LinearRing, not {ring.tag:.40}", place=place)
    shell, *holes = (_corners(ring, 3, place) for ring in (*outer, *inner))
    return shapely.Polygon(shell, holes)


def _corners(element: ElementTree.Element, least: int, place: str) -> Corners:
    texts = [_text(child) for child in element.iterfind("coordinates")]
    if len(texts) > 1:
        raise BadInput(f"expected one list of coordinates, not {len(texts)}", place=place)
    return _positions("".join(texts), least, f"{place}.coordinates")


def _positions(text: str, least: int, place: str) -> Corners:
    words = _words(text)
    try:
        corners = np.array([[float(number) for number in word.strip(",").split(",")][:2] for word in words], float)
    except ValueError:
        corners = np.zeros((0, 0))
    if any(word.count(",") > 2 for word in words):
        raise BadInput("expected blanks between positions, as in 8.54,47.39,0 8.55,47.39,0", place=place)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(np.unique(corners, axis=0)) < least:
        raise BadInput(f"expected {least} or more different positions as longitude,latitude", place=place)
    return on_earth(corners, place, "a KML has longitude,latitude in degrees, always on WGS 84")
