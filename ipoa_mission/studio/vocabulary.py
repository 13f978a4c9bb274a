"""What all messages are made of. Positions on the map are [longitude, latitude] in degrees, as in GeoJSON."""

import re
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, WithJsonSchema

LngLat: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[str | int, ...]
Number: TypeAlias = float | None
#: What a vehicle in flight can be told.
InFlight: TypeAlias = Literal["hold", "go_on", "rtl", "land"]
Json: TypeAlias = Annotated[Any, WithJsonSchema({})]


_NUMBERED = re.compile(r"\b(via|fence|rally|obstacles|maps)\[(\d+)\]")


def as_on_map(words: str) -> str:
    """Words in which the scenario's things are called as on the map.

    >>> as_on_map("via[0]: expected a place outside fence[1]")
    'via 1: expected a place outside fence 2'
    """
    return _NUMBERED.sub(lambda found: f"{found[1].removesuffix('s')} {int(found[2]) + 1}", words)


class PageMessage(BaseModel):
    """Says no more than it is meant to."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class MapLine(PageMessage):
    """A path: points on the map, and each one's height above home [m]."""

    points: tuple[LngLat, ...]
    up: tuple[float, ...]
