"""Positions are [longitude, latitude] in degrees, as in GeoJSON."""

import asyncio
import re
from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, WithJsonSchema

from ipoa_mission.errors import BadInput

LngLat: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[str | int, ...]
Number: TypeAlias = float | None
InFlight: TypeAlias = Literal["hold", "go_on", "rtl", "land"]
Json: TypeAlias = Annotated[Any, WithJsonSchema({})]
Window: TypeAlias = "asyncio.Queue[dict[str, Any]]"  # messages to an open page, in order


def place_of(words: str) -> tuple[float, float]:
    """Parse latitude and longitude [deg].

    >>> place_of("47.397742, 8.545594"), place_of("47.4 S 8.5 W")
    ((47.397742, 8.545594), (-47.4, -8.5))
    """
    number = r"([-+]?\d+(?:\.\d*)?)\s*°?\s*"
    degrees = re.fullmatch(rf"{number}([NS]?)[\s,;]+{number}([EW]?)", words.strip(), re.IGNORECASE)
    if degrees is None:
        raise BadInput(f"expected degrees (47.3977, 8.5456), not {words.strip()[:60]!r}", place="place")
    latitude = -float(degrees[1]) if degrees[2].upper() == "S" else float(degrees[1])
    longitude = -float(degrees[3]) if degrees[4].upper() == "W" else float(degrees[3])
    if not (abs(latitude) <= 85 and abs(longitude) <= 180):
        message = f"expected a latitude from -85 to 85 and a longitude from -180 to 180 degrees, not {words.strip()}"
        raise BadInput(message, place="place")
    return latitude, longitude


def as_on_map(words: str) -> str:
    """Replace paths by the map's labels.

    >>> as_on_map("via[0]: expected a place outside fence[1]")
    'via 1: expected a place outside fence 2'
    """
    indexed = r"(via|fence|rally|obstacle|map)s?\[(\d+)\](?:\[\d+\])*"
    return re.sub(indexed, lambda found: f"{found[1]} {int(found[2]) + 1}", words)


def renamed(words: str, key: str, called: Callable[[list[int]], str]) -> str:
    """Replace a key and its indices: `key[1][2]` by `called([1, 2])`."""

    def name(found: re.Match[str]) -> str:
        return called([int(number) for number in re.findall(r"\d+", found[1])])

    return re.sub(rf"{re.escape(key)}((?:\[\d+\])*)", name, words)


class PageMessage(BaseModel):
    """A class argument identifies the message in a union: `class Put(PageMessage, op="put")` has a constant `op`."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    def __init_subclass__(cls, **constants: str) -> None:
        for key, value in constants.items():
            cls.__annotations__[key] = Literal[value]
            setattr(cls, key, value)


class OfRevision(PageMessage):
    """About a revision of the document; a worker process sets that of its order."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True)
    revision: int = 0


def as_json(message: PageMessage | dict[str, Any]) -> dict[str, Any]:
    return message if isinstance(message, dict) else message.model_dump(mode="json")


class MapLine(PageMessage):
    """Points on the map, and the height of each above home [m]."""

    points: tuple[LngLat, ...]
    up: tuple[float, ...]
