"""Malicious files: an error within 5 s and 500 MB."""

import io
import random
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from ipoa_mission.autopilot.learned import read_vehicle
from ipoa_mission.errors import MissionError
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.maps.elevation import ground_altitude
from ipoa_mission.maps.map_reader import READERS, read_features
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.mission.parameter_file import read_parameter_file
from ipoa_mission.scenario import read_scenario
from tests.cli.limited import run_limited

LOGS = (".tlog", ".bin", ".ulg")
MISSIONS = (".plan", ".waypoints")
KML = b"<kml><Placemark><Polygon>%s</Polygon></Placemark></kml>"


def zipped(content: bytes, repeats: int) -> bytes:
    file = io.BytesIO()
    with (
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("doc.kml", "w") as inner,
    ):
        for _ in range(repeats):
            inner.write(content)
    return file.getvalue()


@cache
def random_bytes() -> bytes:
    return random.Random(1).randbytes(3_000_000)


def noise(begins: bytes = b"") -> bytes:
    return begins + random_bytes()


def nested(opening: str, times: int, closing: str = "") -> bytes:
    return (opening * times + closing * times).encode()


def holes() -> bytes:
    """A GeoTIFF of 60,000 by 60,000 posts, none of them stored."""
    import rasterio

    with rasterio.io.MemoryFile() as memory:
        shape = {"driver": "GTiff", "width": 60_000, "height": 60_000, "count": 1, "dtype": "float32"}
        where = {"crs": "EPSG:4326", "transform": rasterio.Affine(1e-5, 0.0, 8.0, 0.0, -1e-5, 47.0)}
        with memory.open(**shape, **where, tiled=True, SPARSE_OK=True, nodata=-9999.0):
            pass
        return bytes(memory.read())


ENTITIES = "".join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(9))
BOMBS: dict[str, tuple[str, Callable[[], bytes]]] = {
    "a zip bomb": (".kmz", lambda: zipped(bytes(1 << 20), 200)),
    "a bomb of well-formed XML": (".kmz", lambda: zipped(b"<kml>" + b"<a/>" * 100_000, 180)),
    "a bomb of elements": (".kmz", lambda: zipped(b"<kml>" + b"<a/>" * 1_000_000, 10)),
    "a billion laughs": (".kml", lambda: f'<!DOCTYPE kml [<!ENTITY a0 "ha">{ENTITIES}]><kml>&a9;</kml>'.encode()),
    "deep folders": (".kml", lambda: b"<kml>" + nested("<Folder>", 60_000, "</Folder>") + b"</kml>"),
    "deep brackets": (".geojson", lambda: nested("[", 1_000_000)),
    "a deep collection": (".geojson", lambda: nested('{"type":"GeometryCollection","geometries":[', 400, "]}")),
    "6,000 digits in a map": (".geojson", lambda: b'{"type": "Point", "coordinates": [' + b"9" * 6000 + b", 1]}"),
    "6,000 digits in a KML": (".kml", lambda: KML % (b"<coordinates>" + b"9" * 6000 + b",1</coordinates>")),
    "6,000 digits in a plan": (".plan", lambda: b'{"fileType": "Plan", "version": ' + b"9" * 6000 + b"}"),
    "deep brackets in a plan": (".plan", lambda: b'{"fileType": ' + nested("[", 1_000_000)),
    **{f"3 MB of noise, {suffix}": (suffix, noise) for suffix in (*READERS, *LOGS, *MISSIONS)},
    "3 MB of noise in a Shapefile": (".shp", lambda: noise(b"\x00\x00\x27\x0a")),
    "3 MB of noise in a FlatGeobuf": (".fgb", lambda: noise(b"fgb\x03fgb\x00")),
    "3 MB of noise in a GeoPackage": (".gpkg", lambda: noise(b"SQLite format 3\x00")),
    "3 MB of noise in an extract": (".pbf", lambda: noise(b"\x00\x00\x00\x0d\x0a\x09OSMHeader\x18\x05")),
    "3 MB of noise in a PX4 log": (".ulg", lambda: noise(b"ULog\x01\x12\x35\x01" + bytes(8))),
    "3 MB of noise in an ArduPilot log": (".bin", lambda: noise(b"\xa3\x95\x80")),
    **{f"3 MB of noise, {suffix}": (suffix, noise) for suffix in (".toml", ".vehicle", ".params", ".tif", ".hgt")},
    "3 MB of noise in a GeoTIFF": (".tif", lambda: noise(b"II*\x00\x08\x00\x00\x00")),
    "an elevation model that is all holes": (".tif", holes),
    "6,000 digits in mission items": (".waypoints", lambda: b"QGC WPL 110\n0\t" + b"9" * 6000 + b"\t0" * 10 + b"\n"),
    "6,000 digits in a scenario": (".toml", lambda: b"safety_distance = " + b"9" * 6000),
    "6,000 digits in a vehicle": (".vehicle", lambda: b'autopilot = "px4"\n[drag]\nvalue = ' + b"9" * 6000),
    "6,000 digits in parameters": (".params", lambda: b"WPNAV_SPEED " + b"9" * 6000),
    "deep brackets in a scenario": (".toml", lambda: b"goal = " + nested("[", 1_000_000)),
    "deep brackets in a vehicle": (".vehicle", lambda: b"drag = " + nested("[", 1_000_000)),
    "100,000 keys": (".toml", lambda: b"".join(b"k%d = 1\n" % n for n in range(100_000))),
}


def reader(suffix: str) -> Callable[[Path], object]:
    if suffix in LOGS:
        return read_flights
    if suffix in (".tif", ".hgt"):
        return lambda path: ground_altitude(path, 46.7, 8.3)
    others: dict[str, Callable[[Path], object]] = {
        ".toml": read_scenario,
        ".vehicle": read_vehicle,
        ".params": read_parameter_file,
    }
    return others.get(suffix, read_features if suffix in READERS else read_mission)


@pytest.mark.skipif(sys.platform == "win32", reason="limits are of Unix")
@pytest.mark.parametrize("name", BOMBS)
def test_a_bomb_is_an_error_soon(name: str, tmp_path: Path) -> None:
    suffix, content = BOMBS[name]
    path = tmp_path / f"bomb{suffix}"
    path.write_bytes(content())
    read = reader(suffix)

    def act() -> None:
        try:
            read(path)
        except MissionError as error:
            print(f"refused: {error}"[:2000])
            return
        print("read")

    ended = run_limited(act, 5.0)
    assert (ended.code, ended.killed) == (0, ""), ended.err
    assert ended.out.startswith(f"refused: {path}"[:80]), ended.out  # a place of hundreds of levels is cut
    assert ended.megabytes < 400  # the program itself has about 100
    print(f"{name}: {ended.seconds:.2f} s, {ended.megabytes:.0f} MB")
