from collections.abc import Mapping

from ipoa_mission.maps.feature import Feature, printed

KINDS = ("man_made", "aerialway", "barrier", "power")
WORDS = {"tree": "tree", "tree_row": "row of trees", "tower": "power tower", "pole": "power pole"}


def called(feature: Feature) -> str:
    """Name a feature for a pilot: by name, else by kind and number.

    >>> called(Feature("town.geojson: features[3]", None, {"natural": "tree"}))
    'tree (features[3])'
    >>> called(Feature("", None, {"power": "minor_line", "voltage": "20000", "@id": "way/7000"}))
    '20 kV line (way/7000)'
    >>> called(Feature("", None, {"building": "house", "addr:street": "Dorfstrasse", "addr:housenumber": "8"}))
    'house, Dorfstrasse 8'
    """
    tags, kind = feature.tags, _kind(feature.tags)
    if kind is None or tags.get("name") or tags.get("addr:housename"):
        return feature.name
    street, number = tags.get("addr:street"), tags.get("addr:housenumber")
    if street and number:
        return printed(f"{kind}, {street} {number}")
    return printed(f"{kind} ({feature.name.rpartition(': ')[2]})")


def _kind(tags: Mapping[str, str]) -> str | None:
    if tags.get("power", "").endswith("line") or tags.get("power") == "cable":
        volts = [int(each) for each in tags.get("voltage", "").split(";") if each.isdecimal()]
        return f"{max(volts) / 1000:g} kV line" if volts else "power line"
    if tags.get("generator:source") == "wind":
        return "wind turbine"
    if word := WORDS.get(tags.get("natural", "")) or WORDS.get(tags.get("power", "")):
        return word
    if "building" in tags and tags.get("addr:street") and tags.get("addr:housenumber"):
        return _word(tags["building"]) or "building"
    return next((word for key in KINDS if (word := _word(tags.get(key, "")))), None)


def _word(value: str) -> str | None:
    return None if value in ("", "yes", "no") else value.replace("_", " ")
