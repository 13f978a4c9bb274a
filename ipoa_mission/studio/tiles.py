"""Serve map tiles of a server that the user names, or of a file; no other host is contacted."""

import html
import json
import re
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import quote, urlsplit

from ipoa_mission.errors import BadInput, NothingThere, WrongFormat
from ipoa_mission.studio import answers

Read: TypeAlias = Callable[[int, int, int], bytes | None]
VECTOR = ("pbf", "mvt")
DEEPEST = 22  # zoom


@dataclass(frozen=True)
class TileSource:
    """`shown` for the page; `origin` of a server, or `read` of a file."""

    shown: answers.Tiles
    origin: str | None = None
    read: Read | None = None


def open_tiles(source: str, attribution: str | None = None) -> TileSource:
    """Open an address with {z}, {x} and {y}, or an MBTiles file."""
    if "://" in source:
        return _of_server(source, attribution)
    path = Path(source)
    if path.suffix.lower() != ".mbtiles" or not path.is_file():
        words = "expected an address with {z}, {x} and {y}, or a file: .mbtiles"
        raise BadInput(words, place=f"--tiles: {source}")
    about = _metadata(path)
    kind = str(about.get("format", "")).lower()
    if kind not in ("png", "jpg", "jpeg", "webp", *VECTOR):
        words = f"expected pictures (png, jpg, webp, or vector tiles: pbf), not {kind or 'tiles of no stated format'}"
        raise WrongFormat(words, place=f"--tiles: {path}")
    least, most = _asked(path, "select min(zoom_level), max(zoom_level) from tiles")[0]
    if least is None:
        raise NothingThere("expected tiles, not an empty file", place=f"--tiles: {path}")
    layers = about.get("vector_layers") if kind in VECTOR else None
    names = [layer.get("id") for layer in layers if isinstance(layer, dict)] if isinstance(layers, list) else []
    shown = answers.Tiles(
        address="tiles/{z}/{x}/{y}",
        attribution=_plain(attribution or str(about.get("attribution") or path.name)),
        min_zoom=least,
        max_zoom=most,
        vector=kind in VECTOR,
        layers=tuple(name for name in names if isinstance(name, str)),
    )
    return TileSource(shown, read=partial(_tile, path))


def headers_of(tile: bytes, vector: bool) -> dict[str, str] | None:
    if vector:
        packed = {"Content-Encoding": "gzip"} if tile.startswith(b"\x1f\x8b") else {}
        return {"Content-Type": "application/vnd.mapbox-vector-tile"} | packed
    kinds = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp"}
    kind = next((kind for begin, kind in kinds.items() if tile.startswith(begin)), None)
    return None if kind is None else {"Content-Type": kind}


def _plain(attribution: str) -> str:
    return html.unescape(re.sub(r"<[^>]*>", "", attribution))


def _of_server(address: str, attribution: str | None) -> TileSource:
    for wmts, ours in (("{TileMatrix}", "{z}"), ("{TileCol}", "{x}"), ("{TileRow}", "{y}")):
        address = address.replace(wmts, ours)
    parts = urlsplit(address)
    origin = f"{parts.scheme}://{parts.netloc}"
    has_keys = all(key in address for key in ("{z}", "{x}", "{y}"))
    if not has_keys or not re.fullmatch(r"https?://[A-Za-z0-9.-]+(:\d+)?", origin):
        raise BadInput("expected http(s)://HOST/... with {z}, {x} and {y} in it", place=f"--tiles: {address}")
    is_vector = parts.path.rpartition(".")[2].lower() in VECTOR
    deepest = 14 if is_vector else DEEPEST  # the page enlarges vector tiles beyond
    words = _plain(attribution or parts.netloc)
    shown = answers.Tiles(address=address, attribution=words, min_zoom=0, max_zoom=deepest, vector=is_vector)
    return TileSource(shown, origin=origin)


def _metadata(path: Path) -> dict[str, Any]:
    rows = _asked(path, "select name, value from metadata")
    about: dict[str, Any] = {str(name): str(value) for name, value in rows}
    with suppress(ValueError, TypeError):
        about = json.loads(about.get("json", "{}")) | about
    return about


def _tile(path: Path, zoom: int, column: int, row: int) -> bytes | None:
    where = "zoom_level = ? and tile_column = ? and tile_row = ?"
    rows = _asked(path, f"select tile_data from tiles where {where}", zoom, column, 2**zoom - 1 - row)
    return bytes(rows[0][0]) if rows else None


def _asked(path: Path, question: str, *values: int) -> list[Any]:
    try:
        with closing(sqlite3.connect(f"file:{quote(str(path))}?mode=ro", uri=True)) as file:
            return file.execute(question, values).fetchall()
    except sqlite3.Error as error:
        raise WrongFormat(f"expected MBTiles: {error}", place=f"--tiles: {path}") from error
