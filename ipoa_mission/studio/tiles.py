"""Serve map tiles of a server that the user names, or of a file; no other host is contacted."""

import html
import json
import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import quote, urlsplit

from ipoa_mission.errors import BadInput, NothingThere, WrongFormat, imported
from ipoa_mission.studio import answers, memory

Read: TypeAlias = Callable[[int, int, int], bytes | None]
ORIGIN = re.compile(r"https?://[A-Za-z0-9.-]+(:\d+)?")
WMTS = {"{TileMatrix}": "{z}", "{TileCol}": "{x}", "{TileRow}": "{y}"}
VECTOR = ("pbf", "mvt")
GZIP = b"\x1f\x8b"
PICTURES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp"}
NONE = "none"
DEEPEST, DEEPEST_VECTOR = 22, 14  # the page enlarges vector tiles beyond
MBTILES, PMTILES = ".mbtiles", ".pmtiles"


@dataclass(frozen=True)
class TileSource:
    """`shown` for the page; `origin` of a server, or `read` of a file."""

    shown: answers.Tiles
    origin: str | None = None
    read: Read | None = None


def chosen_tiles(asked: str | None, attribution: str | None) -> TileSource | None:
    """Return the requested tiles and remember them; else the remembered ones."""
    if asked == NONE:
        memory.keep_tiles(None)
        return None
    if asked is not None:
        source = asked if "://" in asked else str(Path(asked).resolve())
        found = open_tiles(source, attribution)
        memory.keep_tiles((source, found.shown.attribution))
        return found
    if (known := memory.kept_tiles()) is None:
        return None
    try:
        return open_tiles(*known)
    except BadInput:
        return None


def open_tiles(source: str, attribution: str | None = None) -> TileSource:
    """Open an address with {z}, {x} and {y}, or an MBTiles or PMTiles file."""
    if "://" in source:
        return _of_server(source, attribution)
    path = Path(source)
    if path.suffix.lower() not in (MBTILES, PMTILES) or not path.is_file():
        words = f"expected an address with {{z}}, {{x}} and {{y}}, or a file: {MBTILES} or {PMTILES}"
        raise BadInput(words, place=f"--tiles: {source}")
    return _of_mbtiles(path, attribution) if path.suffix.lower() == MBTILES else _of_pmtiles(path, attribution)


def headers_of(tile: bytes, vector: bool) -> dict[str, str] | None:
    if vector:
        compressed = {"Content-Encoding": "gzip"} if tile.startswith(GZIP) else {}
        return {"Content-Type": "application/vnd.mapbox-vector-tile"} | compressed
    kind = next((kind for begin, kind in PICTURES.items() if tile.startswith(begin)), None)
    return None if kind is None else {"Content-Type": kind}


def _of_server(address: str, attribution: str | None) -> TileSource:
    for theirs, ours in WMTS.items():
        address = address.replace(theirs, ours)
    parts = urlsplit(address)
    origin = f"{parts.scheme}://{parts.netloc}"
    if not ORIGIN.fullmatch(origin) or not all(key in address for key in ("{z}", "{x}", "{y}")):
        raise BadInput("expected http(s)://HOST/... with {z}, {x} and {y} in it", place=f"--tiles: {address}")
    is_vector = parts.path.rpartition(".")[2].lower() in VECTOR
    deepest = DEEPEST_VECTOR if is_vector else DEEPEST
    return TileSource(_shown(address, attribution or parts.netloc, (0, deepest), is_vector), origin=origin)


def _of_mbtiles(path: Path, attribution: str | None) -> TileSource:
    def ask(question: str, *values: int) -> list[Any]:
        try:
            with closing(sqlite3.connect(f"file:{quote(str(path))}?mode=ro", uri=True)) as file:
                return file.execute(question, values).fetchall()
        except sqlite3.Error as error:
            raise WrongFormat(f"expected MBTiles: {error}", place=f"--tiles: {path}") from error

    def read(zoom: int, column: int, row: int) -> bytes | None:
        where = "zoom_level = ? and tile_column = ? and tile_row = ?"
        found = ask(f"select tile_data from tiles where {where}", zoom, column, 2**zoom - 1 - row)
        return bytes(found[0][0]) if found else None

    about = {str(name): str(value) for name, value in ask("select name, value from metadata")}
    least, most = ask("select min(zoom_level), max(zoom_level) from tiles")[0]
    if least is None:
        raise NothingThere("expected tiles, not an empty file", place=f"--tiles: {path}")
    is_vector = _is_vector(path, about.get("format", ""))
    try:
        layers = _layers(json.loads(about.get("json", "{}"))) if is_vector else ()
    except ValueError:
        layers = ()
    told = attribution or about.get("attribution") or path.name
    return TileSource(_shown("", told, (least, most), is_vector, layers), read=read)


def _of_pmtiles(path: Path, attribution: str | None) -> TileSource:
    library = imported("pmtiles.reader", f"{path}: PMTiles need the package pmtiles", "studio", BadInput)
    kinds = imported("pmtiles.tile", f"{path}: PMTiles need the package pmtiles", "studio", BadInput)

    def ask(question: Callable[[Any], Any]) -> Any:
        with path.open("rb") as file:
            try:
                return question(library.Reader(library.MmapSource(file)))
            except (ValueError, KeyError, IndexError, OSError, kinds.MagicNumberNotFound) as error:
                raise WrongFormat(f"expected PMTiles: {error}", place=f"--tiles: {path}") from error

    def read(zoom: int, column: int, row: int) -> bytes | None:
        tile = ask(lambda reader: reader.get(zoom, column, row))
        return None if tile is None else bytes(tile)

    header, about = ask(lambda reader: (reader.header(), reader.metadata()))
    is_vector = _is_vector(path, header["tile_type"].name.lower())
    packed = header["tile_compression"].name.lower()
    if is_vector and packed not in ("none", "gzip"):
        words = f"expected vector tiles compressed by gzip or not at all, not by {packed}"
        raise WrongFormat(words, place=f"--tiles: {path}")
    told = attribution or str(about.get("attribution") or path.name)
    zooms = header["min_zoom"], header["max_zoom"]
    return TileSource(_shown("", told, zooms, is_vector, _layers(about) if is_vector else ()), read=read)


def _is_vector(path: Path, kind: str) -> bool:
    """Return whether a format is one of vector tiles. Raises BadInput for one of neither."""
    if kind.lower() not in ("png", "jpg", "jpeg", "webp", *VECTOR):
        known = "png, jpg, webp, or vector tiles: pbf"
        words = f"expected pictures ({known}), not {kind or 'tiles of no stated format'}"
        raise WrongFormat(words, place=f"--tiles: {path}")
    return kind.lower() in VECTOR


def _layers(about: Any) -> tuple[str, ...]:
    told = about.get("vector_layers") if isinstance(about, dict) else None
    named = [one.get("id") for one in told if isinstance(one, dict)] if isinstance(told, list) else []
    return tuple(name for name in named if isinstance(name, str))


def _shown(
    address: str, attribution: str, zooms: tuple[int, int], vector: bool = False, layers: tuple[str, ...] = ()
) -> answers.Tiles:
    words = html.unescape(re.sub(r"<[^>]*>", "", attribution))
    return answers.Tiles(
        address=address or "tiles/{z}/{x}/{y}",
        attribution=words,
        min_zoom=zooms[0],
        max_zoom=zooms[1],
        vector=vector,
        layers=layers,
    )
