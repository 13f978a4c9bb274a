"""Overpass JSON (`[out:json]`)."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.osm import BOUNDS, META_TAGS, Extract, OsmWay, Relation, features_of, is_area, plain_tags

SORTS = ("node", "way", "relation")


def is_overpass(document: Any) -> bool:
    return isinstance(document, dict) and isinstance(document.get("elements"), list)


def overpass_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    extract = Extract(remarks=[str(document["remark"])] if document.get("remark") else [])
    for n, element in enumerate(document["elements"]):
        place = f"{path}: elements[{n}]"
        if not isinstance(element, dict) or not isinstance(element.get("type"), str) or "id" not in element:
            raise BadInput("expected an element with a type and an id", place=place)
        if element["type"] in SORTS:
            try:
                _take(element, extract)
            except (TypeError, ValueError, KeyError, AttributeError) as error:
                raise BadInput("expected a node, way or relation as Overpass writes it", place=place) from error
    return features_of(extract, path)


def _take(element: Mapping[str, Any], extract: Extract) -> None:
    number, sort = str(element["id"]), element["type"]
    tags = plain_tags((str(key), str(value)) for key, value in (element.get("tags") or {}).items())
    if sort == "node":
        if "lat" in element:
            extract.places[number] = float(element["lon"]), float(element["lat"])
            if tags.keys() - META_TAGS:
                extract.tagged[number] = tags
        return
    if bounds := element.get("bounds"):
        extract.boxes[f"{sort} {number}"] = shapely.box(*(float(bounds[side]) for side in BOUNDS))
    if sort == "way":
        extract.ways[number] = OsmWay(extract.corners(_nodes(element)), tags)
    elif is_area(tags):
        members = element.get("members") or []
        for member in members:
            if member["type"] == "way" and member.get("geometry"):
                extract.ways.setdefault(str(member["ref"]), OsmWay(extract.corners(_nodes(member)), {}))
        listed = tuple((member["type"], str(member["ref"]), member.get("role") or "") for member in members)
        extract.relations[number] = Relation(listed, tags)


def _nodes(way: Mapping[str, Any]) -> Iterator[tuple[str, float | None, float | None]]:
    numbers, places = way.get("nodes"), way.get("geometry")
    numbers = [""] * len(places or ()) if numbers is None else numbers
    for number, place in zip(numbers, [None] * len(numbers) if places is None else places, strict=True):
        if place is None:
            yield str(number) or "?", None, None
        else:
            yield str(number), float(place["lon"]), float(place["lat"])
