"""Read a feature's properties as tags."""

import json
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

from ipoa_mission.maps.feature import Feature, Missing
from ipoa_mission.maps.keys import Means, meaning

# Of osmtogeojson, osm2pgsql and GDAL's OSM driver.
PACKED = ("tags", "other_tags", "all_tags")
HSTORE = re.compile(r'"((?:[^"\\]|\\.)*)"=>(?:"((?:[^"\\]|\\.)*)"|NULL)\s*(?:,\s*|$)')


def tags_of(properties: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield packed ones too; of nested values only measures."""
    for key, value in properties.items():
        if isinstance(value, str) and key in PACKED:
            tags, _ = _unpacked(value)
            yield from _plain(key, value) if tags is None else tags.items()
        elif key in PACKED and isinstance(value, dict):
            yield from tags_of(value)
        elif key == "names" and isinstance(value, dict) and isinstance(value.get("primary"), str):
            yield "name", value["primary"]  # Overture's
        elif key == "limitedApplicability" and isinstance(value, list) and value:
            yield key, json.dumps(value)
        elif isinstance(value, dict | list):
            yield from _measures(key, value)
        else:
            yield from _plain(key, value)


def blank_keys(properties: Mapping[str, Any]) -> Iterator[str]:
    for key, value in properties.items():
        if isinstance(value, str):
            if not value.strip():
                yield key
        elif key in PACKED and isinstance(value, dict):
            yield from blank_keys(value)
        elif value is None or value != value:  # pandas' null
            yield key


def feature_of_properties(
    place: str, shape: Any, properties: Mapping[str, Any], tags: Mapping[str, str], altitude: float
) -> Feature:
    """Return a feature; `altitude` is the greatest of its shape above the sea [m]."""
    blank = frozenset(blank_keys(properties))
    return Feature(place, shape, tags, blank, find_truncated(properties, shape), (-math.inf, altitude))


def find_truncated(properties: Mapping[str, Any], shape: Any) -> Missing | None:
    """Find packed tags that a Shapefile truncates to 254 bytes."""
    for key in PACKED:
        text = properties.get(key)
        _, rest = _unpacked(text) if isinstance(text, str) else (None, "")
        if rest:
            words = f"of which {key} is not whole (... {rest[-20:]!r})"
            return Missing(words, shape, "write the map as a GeoPackage, which keeps long texts")
    return None


def _unpacked(text: str) -> tuple[dict[str, str] | None, str]:
    """Return the tags of JSON or hstore (None: there are none), and the rest that is not whole."""
    with suppress(ValueError, RecursionError):
        value = json.loads(text)
        return (dict(tags_of(value)) if isinstance(value, dict) else None), ""
    if text.lstrip().startswith('{"'):
        return None, text
    pairs = HSTORE.findall(text)
    rest = HSTORE.sub("", text).strip(" ,") if '"=>' in text else ""
    tags = {_unescaped(name): _unescaped(value) for name, value in pairs if value.strip()}
    return (tags if pairs else None), rest


def _measures(key: str, value: Any, depth: int = 3) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict) and depth:
        for name, inner in value.items():
            yield from _measures(f"{key}:{name}", inner, depth - 1)
    elif isinstance(value, list) and depth and all(isinstance(item, dict) for item in value):
        for inner in value:
            yield from _measures(key, inner, depth - 1)
    elif meaning(key) is not Means.NOTHING:
        items = value if isinstance(value, list) else [value]
        texts = [text for item in items for _, text in _plain(key, item)]
        if texts:
            yield key, ";".join(texts)


def _plain(key: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, bool):
        yield key, "yes" if value else "no"
    elif isinstance(value, str) and value.strip():
        yield key, value.strip()
    elif isinstance(value, int | float) and value == value:
        yield key, str(value)


def _unescaped(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)
