import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.units import unit_factor
from ipoa_mission.maps.wind_levels import Datum

STANDARD = {
    "height": Datum.GROUND,
    "altitude": Datum.SEA,
    "height_above_mean_sea_level": Datum.SEA,
    "height_above_geopotential_datum": Datum.SEA,
    "geopotential_height": Datum.SEA,
    "height_above_reference_ellipsoid": Datum.ELLIPSOID,
}
# Without a standard name.
WORDS = (
    (Datum.ELLIPSOID, re.compile(r"ellipsoid|wgs ?84|\bhae\b")),
    (Datum.SEA, re.compile(r"above[ _]?(the )?(mean[ _]?)?sea|\b(a?msl|asl)\b|altitude|geoid|geopotential")),
    (Datum.GROUND, re.compile(r"above[ _]?(the )?(ground|surface|terrain)|\bagl\b")),
)
AXES = re.compile(r"z|lev|levels?|heights?(_?\d+)?|alt|z?agl|msl|h(gt)?|zlev|height_levels?|elevation")
DATUM_IN_UNIT = re.compile(r"\s*\b(agl|amsl|asl|msl|above .*)$", re.IGNORECASE)
NO_UNIT = re.compile(r"1|-|level|levels|layer|count|none|", re.IGNORECASE)
BARE = re.compile(r"\D*(\d+)_?(mabove\w*|m(?![a-z]))?\D*")
PRESSURE = re.compile(r"\d ?(hpa|mb|mbar|millibars?|pa)\b", re.IGNORECASE)
HIGHEST_NAMED = 200  # u250 to u1000 are hPa


@dataclass(frozen=True)
class Vertical:
    """`values` [m]; None: pressure or others."""

    coordinate: Any
    values: Any
    datum: Datum
    has_no_unit: bool = False


def vertical_of(path: Path, coordinate: Any) -> Vertical | None:
    """Return heights; refuse unknown units, and heights that count downwards."""
    name, attributes = str(coordinate.name), coordinate.attrs
    if {"grid_mapping_name", "crs_wkt"} & attributes.keys():
        return None
    standard = attributes.get("standard_name")
    standard = None if standard in ("", "unknown") else standard
    unit = attributes.get("units")
    text = " ".join(str(each) for each in (name, attributes.get("long_name", ""), unit or "")).lower()
    by_words = [datum for datum, words in WORDS if words.search(text)]
    is_axis = AXES.fullmatch(name.lower()) or attributes.get("axis") == "Z" or "positive" in attributes
    if not (standard in STANDARD or (standard is None and (by_words or is_axis)) or attributes.get("axis") == "Z"):
        return Vertical(coordinate, None, Datum.UNKNOWN) if _is_pressure(name, unit, standard) else None
    if standard is not None and standard not in STANDARD:
        return Vertical(coordinate, None, Datum.UNKNOWN)
    datum = _datum(name, standard, by_words)
    factor = 1.0
    if unit is None and datum is Datum.UNKNOWN:
        return Vertical(coordinate, None, datum)  # probably level numbers
    if unit is not None:
        bare = DATUM_IN_UNIT.sub("", str(unit)).strip()
        if NO_UNIT.fullmatch(bare) or _is_pressure(name, bare, standard):
            return Vertical(coordinate, None, Datum.UNKNOWN)
        factor = unit_factor(bare, "m", f"{path}: {name}.units")
    if attributes.get("positive") == "down":
        raise BadInput("expected heights that grow upwards, not positive = 'down'", place=f"{path}: {name}")
    if coordinate.ndim > 1:
        return Vertical(coordinate, None, datum)
    return Vertical(coordinate, np.asarray(coordinate, float) * factor, datum, unit is None)


def height_in_name(name: str, long_name: str, is_usual: bool) -> tuple[float, Datum] | None:
    """Read u10 and the like; an unusual name must have the unit m."""
    match = BARE.fullmatch(name.lower())
    if match is None or PRESSURE.search(long_name) or PRESSURE.search(name):
        return None
    height, unit = float(match[1]), match[2]
    if unit is None and (height > HIGHEST_NAMED or not is_usual):
        return None
    return height, Datum.SEA if unit and "sea" in unit else Datum.GROUND


def _datum(name: str, standard: str | None, by_words: list[Datum]) -> Datum:
    if standard is not None:
        stated = STANDARD[standard]
        return stated if not by_words or stated in by_words else Datum.UNKNOWN  # contradictory
    if len(by_words) > 1:
        return Datum.UNKNOWN
    if by_words:
        return by_words[0]
    return Datum.GROUND if re.fullmatch(r"heights?(_?\d+)?|z?agl", name.lower()) else Datum.UNKNOWN


def _is_pressure(name: str, unit: Any, standard: str | None) -> bool:
    if standard == "air_pressure" or re.search(r"isobaric|plev|pressure", name.lower()):
        return True
    return bool(re.fullmatch(r"(h|k|d)?pa|mb|millibars?|mbar|pascals?|hectopascals?", str(unit or "").lower()))
