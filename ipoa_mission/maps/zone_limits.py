"""Vertical limits of zones: ED-269, ED-318 and national files.

A limit that is not understood is dropped and reported: the zone grows.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

FOOT = 0.3048
UNITS = {"M": 1.0, "METRE": 1.0, "METRES": 1.0, "METER": 1.0, "METERS": 1.0}
UNITS |= {"FT": FOOT, "F": FOOT, "FEET": FOOT, "FOOT": FOOT}
REFERENCES = {"AGL": "AGL", "GND": "AGL", "SFC": "AGL", "AMSL": "AMSL", "MSL": "AMSL", "WGS84": "WGS84"}
GROUND = {"SFC", "GND", "SURFACE", "GROUND"}
# EANS, AIP: "120m AGL", "6000 FT AMSL".
IN_WORDS = re.compile(r"(?P<height>[-+]?\d+(?:\.\d+)?) ?(?P<unit>[A-Z]+)[ ,]*(?P<reference>[A-Z]+)")
# ED-318, ED-269, its shapefiles.
KEYS = {
    "uom": ("uom", "uomDimensions", "uomDimensi"),
    **{side: (side, f"{side}Limit") for side in ("lower", "upper")},
    **{
        f"{side}Reference": (f"{side}Reference", f"{side}VerticalReference", f"{side}Verti", f"{side}Refer")
        for side in ("lower", "upper")
    },
    **{f"{side}Meters": (f"{side}Meters",) for side in ("lower", "upper")},
}
READ = {key.lower() for keys in KEYS.values() for key in keys}
# May hold a limit.
MAY_LIMIT = re.compile(
    r"(lower|upper|floor|ceiling|bottom|base|top|min|max)([-_: ]?(limit|alt|hei|lev|agl|a?msl|ft|m)\w*)?"
)
SIDES: tuple[Literal["lower", "upper"], ...] = ("lower", "upper")


@dataclass(frozen=True)
class VerticalLimit:
    """A limit [m] above ground (`AGL`), mean sea level (`AMSL`) or ellipsoid (`WGS84`)."""

    height: float
    reference: str


class Odd(NamedTuple):
    what: str
    value: str


@dataclass(frozen=True)
class ZoneLimits:
    """None: no limit, or the ground; `odd`: not understood."""

    lower: VerticalLimit | None = None
    upper: VerticalLimit | None = None
    odd: tuple[Odd, ...] = ()


def limits_of(tags: Mapping[str, str]) -> ZoneLimits:
    given = {name: next((tags[key].strip() for key in keys if key in tags), "") for name, keys in KEYS.items()}
    odd = [Odd(f'tag "{key}", which may be a limit', value) for key, value in tags.items() if _may_limit(key)]
    lower, upper = (_limit(given, side, odd) for side in SIDES)
    numbers = [given[side] for side in SIDES if _is_number(given[side]) and given[f"{side}Reference"]]
    if numbers and not given["uom"]:
        odd.append(Odd("unit of the limits, taken as M", numbers[-1]))
    if lower is not None and lower.reference == "AGL" and lower.height <= 0:
        lower = None
    if lower is not None and upper is not None and lower.reference == upper.reference and upper.height <= lower.height:
        odd.append(Odd("limits, of which the upper is not above the lower", f"{lower.height:g} m, {upper.height:g} m"))
        lower = upper = None
    return ZoneLimits(lower, upper, tuple(odd))


def _may_limit(key: str) -> bool:
    return MAY_LIMIT.fullmatch(key.lower()) is not None and key.lower() not in READ


def _limit(given: Mapping[str, str], side: str, odd: list[Odd]) -> VerticalLimit | None:
    text, reference = given[side].upper(), given[f"{side}Reference"].upper()
    if text in {"UNL", "UNLTD", "UNLIMITED"}:
        return None
    if text in GROUND:
        return VerticalLimit(0.0, "AGL")
    if (found := _in_words(text) or _by_keys(text, given["uom"].upper(), reference)) is not None:
        return found
    if _is_number(meters := given[f"{side}Meters"]) and not reference:  # Estonia's, rounded
        odd.append(Odd(f"reference of {side}Meters, taken as AGL", meters))
        return VerticalLimit(float(meters), "AGL")
    if text or meters:
        stated = " ".join(filter(None, (text or meters, given["uom"], reference)))
        odd.append(Odd(f"{side} limit, so that the zone has none", stated))
    return None


def _in_words(text: str) -> VerticalLimit | None:
    match = IN_WORDS.fullmatch(text)
    if match is None or match["unit"] not in UNITS or match["reference"] not in REFERENCES:
        return None
    return VerticalLimit(float(match["height"]) * UNITS[match["unit"]], REFERENCES[match["reference"]])


def _by_keys(text: str, unit: str, reference: str) -> VerticalLimit | None:
    factor, counted = UNITS.get(unit or "M"), REFERENCES.get(reference)
    return VerticalLimit(float(text) * factor, counted) if factor and counted and _is_number(text) else None


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
