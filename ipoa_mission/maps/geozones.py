"""Read UAS geographical zones, ED-269 (JSON) and ED-318 (GeoJSON): shapes, vertical limits and times.

A limit that is not understood is dropped and reported: the zone grows. Times are seconds since 1970 (UTC).
"""

import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeAlias

from pydantic import AwareDatetime, BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature, read_all
from ipoa_mission.maps.json_shapes import circle, shape_of
from ipoa_mission.maps.lengths import FOOT, UNIT_FACTORS
from ipoa_mission.maps.tag_heights import Odd

RADIUS_UNIT = "radius in other units than M"  # internal tag
DAY_S = 86_400.0

LENGTH_UNITS = {**UNIT_FACTORS, "f": FOOT}
REFERENCES = {"AGL": "AGL", "GND": "AGL", "SFC": "AGL", "AMSL": "AMSL", "MSL": "AMSL", "WGS84": "WGS84"}
# Of ED-318, ED-269, its shapefiles, and Estonia.
LIMIT_KEYS = {
    "uom": ("uom", "uomDimensions", "uomDimensi"),
    "lower": ("lower", "lowerLimit"),
    "upper": ("upper", "upperLimit"),
    "lowerReference": ("lowerReference", "lowerVerticalReference", "lowerVerti", "lowerRefer"),
    "upperReference": ("upperReference", "upperVerticalReference", "upperVerti", "upperRefer"),
    "lowerMeters": ("lowerMeters",),
    "upperMeters": ("upperMeters",),
}
_LIMIT_OF_KEY = {key: limit for limit, keys in LIMIT_KEYS.items() for key in keys}
_MAY_LIMIT = re.compile(
    r"(lower|upper|floor|ceiling|bottom|base|top|min|max)([-_: ]?(limit|alt|hei|lev|agl|a?msl|ft|m)\w*)?|[lu]\w*limit"
)


def is_ed269(document: Any) -> bool:
    features = document.get("features") if isinstance(document, dict) and "type" not in document else None
    return isinstance(features, list) and all(
        isinstance(zone, dict) and isinstance(zone.get("geometry"), list) for zone in features
    )


def ed269_features(document: Mapping[str, Any], path: Path) -> tuple[Feature, ...]:
    volumes = (
        (zone, volume, f"{path}: features[{i}].geometry[{j}]")
        for i, zone in enumerate(document["features"])
        for j, volume in enumerate(zone["geometry"])
    )
    return read_all(_volume, volumes)


def _volume(zone: Mapping[str, Any], volume: Any, place: str) -> Feature:
    projection = volume.get("horizontalProjection") if isinstance(volume, dict) else None
    projection = projection if isinstance(projection, dict) else {}
    kind = projection.get("type")
    place_of_shape = f"{place}.horizontalProjection"
    if kind == "Circle":
        shape = circle(projection.get("center"), projection.get("radius"), place_of_shape)
    elif kind == "Polygon":
        shape = shape_of(projection, place_of_shape)
    else:
        raise BadInput(f"expected a Polygon or a Circle, not {kind!r}", place=place_of_shape)
    tags = {key: zone[key] for key in ("identifier", "name", "type", "restriction") if isinstance(zone.get(key), str)}
    tags |= dict(limit_tags(volume)) | dict(_time_tags(zone.get("applicability")))
    unit = tags.get("uom", "M")
    if kind == "Circle" and unit.upper() != "M":
        tags[RADIUS_UNIT] = f"{projection['radius']} {unit}"
    return Feature(place, shape, tags)


def layers_apart(feature: Any) -> list[Any]:
    """Divide a collection whose members have vertical limits of their own (ED-318)."""
    geometry = feature.get("geometry") if isinstance(feature, dict) else None
    geometry = geometry if isinstance(geometry, dict) else {}
    members = geometry["geometries"] if isinstance(geometry.get("geometries"), list) else []
    if not any(isinstance(member, dict) and "layer" in member for member in members):
        return [feature]
    shared = {"layer": geometry["layer"]} if "layer" in geometry else {}
    apart = [feature | {"geometry": shared | member if isinstance(member, dict) else member} for member in members]
    return [layer for part in apart for layer in layers_apart(part)]


def zone_tags(properties: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    names = properties.get("name")
    if isinstance(names, list):  # ED-318: by language
        texts = [name for name in names if isinstance(name, dict) and isinstance(name.get("text"), str)]
        english = [name for name in texts if str(name.get("lang", "")).startswith("en")]
        for name in (english or texts)[:1]:
            yield "name", name["text"]
    yield from _time_tags(properties.get("applicability"))
    for side in ("lower", "upper"):
        limit = properties.get(f"{side}Limit")
        if isinstance(limit, dict):  # openAIP: numbers for units and references
            words = [str(limit.get(key)) for key in ("value", "unit", "referenceDatum")]
            unit = {"0": "M", "1": "FT", "6": "FL"}.get(words[1], words[1])
            reference = {"0": "GND", "1": "MSL", "2": "STD"}.get(words[2], words[2])
            yield side, f"{words[0]} {unit} {reference}"
    volume = properties.get("geometry")
    if isinstance(volume, dict):  # Estonia: an ED-269 volume
        yield from limit_tags(volume)


def limit_tags(volume: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, value in volume.items():
        if value is not None and (key in _LIMIT_OF_KEY or _MAY_LIMIT.fullmatch(key.lower())):
            yield _LIMIT_OF_KEY.get(key, key), str(value)


def _time_tags(times: Any) -> Iterator[tuple[str, str]]:
    if isinstance(times, list) and not any(isinstance(each, dict) and each.get("permanent") == "YES" for each in times):
        yield "limitedApplicability", json.dumps(times)


class VerticalLimit(NamedTuple):
    """A limit [m] above ground (`AGL`), mean sea level (`AMSL`) or ellipsoid (`WGS84`)."""

    height: float
    reference: str


def limits_of(tags: Mapping[str, str], odd: Odd) -> dict[str, VerticalLimit | None]:
    """Return the `lower` and `upper` end of a zone; None: no limit, or the ground."""
    values = {name: next((tags[key].strip() for key in keys if key in tags), "") for name, keys in LIMIT_KEYS.items()}
    for key, value in tags.items():
        if _MAY_LIMIT.fullmatch(key.lower()) and key not in _LIMIT_OF_KEY:
            odd(f'tag "{key}", which may be a limit', value)
    lower, upper = (_limit(values, side, odd) for side in ("lower", "upper"))
    numbers = [values[side] for side in ("lower", "upper") if _is_number(values[side]) and values[f"{side}Reference"]]
    if numbers and not values["uom"]:
        odd("unit of the limits, taken as M", numbers[-1])
    if lower is not None and lower.reference == "AGL" and lower.height <= 0:
        lower = None
    if lower is not None and upper is not None and lower.reference == upper.reference and upper.height <= lower.height:
        odd("an upper limit that is not above the lower one", f"{lower.height:g} m, {upper.height:g} m")
        lower = upper = None
    return {"lower": lower, "upper": upper}


def _limit(values: Mapping[str, str], side: str, odd: Odd) -> VerticalLimit | None:
    text, unit, reference = (values[key].upper() for key in (side, "uom", f"{side}Reference"))
    if text in {"UNL", "UNLTD", "UNLIMITED"}:
        return None
    if text in {"SFC", "GND", "SURFACE", "GROUND"}:
        return VerticalLimit(0.0, "AGL")
    in_words = re.fullmatch(r"([-+]?\d+(?:\.\d+)?) ?([A-Z]+)[ ,]*([A-Z]+)", text)  # EANS, AIP: "120m AGL"
    number, name, datum = in_words.groups() if in_words else (text, unit or "M", reference)
    if name.lower() in LENGTH_UNITS and datum in REFERENCES and _is_number(number):
        return VerticalLimit(float(number) * LENGTH_UNITS[name.lower()], REFERENCES[datum])
    meters = values[f"{side}Meters"]
    if _is_number(meters) and not reference:  # Estonia's, rounded
        odd(f"reference of {side}Meters, taken as AGL", meters)
        return VerticalLimit(float(meters), "AGL")
    if text or meters:
        stated = " ".join(filter(None, (text or meters, values["uom"], reference)))
        odd(f"{side} limit, so that the zone has none", stated)
    return None


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _dated(text: Any) -> str:
    if not re.match(r"\d{4}-\d\d-\d\d[T ]", str(text), re.IGNORECASE):
        raise ValueError(f"expected a time with its offset, such as 2026-11-22T10:00:00Z, not {str(text)!r}")
    return str(text)


Instant: TypeAlias = Annotated[AwareDatetime, BeforeValidator(_dated)]
Clock: TypeAlias = Annotated[AwareDatetime, BeforeValidator(lambda clock: f"1970-01-01T{clock}")]


class Slot(BaseModel):
    """Hours (UTC), maybe into the next day."""

    model_config = ConfigDict(defer_build=True)

    day: tuple[str, ...] | None = None
    begin: Clock | None = Field(None, alias="startTime")
    end: Clock | None = Field(None, alias="endTime")

    def meets(self, begin: float, end: float) -> bool:
        weekdays = ("THU", "FRI", "SAT", "SUN", "MON", "TUE", "WED")  # 1970 began on a Thursday
        names = self.day or ("ANY",)
        is_any = not set(names) <= {*weekdays}  # "ANY", or a holiday of unknown date
        first = -DAY_S / 2
        last = 1.5 * DAY_S
        if self.begin is not None and self.end is not None:  # else from dawn or to dusk
            first = self.begin.timestamp()
            last = self.end.timestamp()
            last += 0.0 if last > first else DAY_S
        days = range(math.floor(begin / DAY_S) - 2, math.floor(end / DAY_S) + 3)
        return any(
            (is_any or weekdays[day % 7] in names) and day * DAY_S + first <= end and day * DAY_S + last >= begin
            for day in days
        )


class Period(BaseModel):
    model_config = ConfigDict(defer_build=True)

    begin: Instant | None = Field(None, alias="startDateTime")
    end: Instant | None = Field(None, alias="endDateTime")
    schedule: tuple[Slot, ...] | None = None

    def meets(self, begin: float, end: float) -> bool:
        begin = begin if self.begin is None else max(begin, self.begin.timestamp())
        end = end if self.end is None else min(end, self.end.timestamp())
        return begin <= end and (not self.schedule or any(slot.meets(begin, end) for slot in self.schedule))


def periods_of(tags: Mapping[str, str]) -> tuple[Period, ...] | None:
    """None: always active or unreadable."""
    try:
        return TypeAdapter(tuple[Period, ...]).validate_json(tags.get("limitedApplicability", "null")) or None
    except ValidationError:
        return None


def may_be_active(tags: Mapping[str, str], time: float) -> bool:
    periods = periods_of(tags)
    longest_flight_s = 3_600.0
    return periods is None or any(period.meets(time, time + longest_flight_s) for period in periods)
