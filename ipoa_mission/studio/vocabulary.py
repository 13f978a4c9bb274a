"""Positions are [longitude, latitude] in degrees, as in GeoJSON."""

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, WithJsonSchema

LngLat: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[str | int, ...]
Number: TypeAlias = float | None
InFlight: TypeAlias = Literal["hold", "go_on", "rtl", "land"]
Json: TypeAlias = Annotated[Any, WithJsonSchema({})]


def as_on_map(words: str) -> str:
    """Replace paths by the map's labels.

    >>> as_on_map("via[0]: expected a place outside fence[1]")
    'via 1: expected a place outside fence 2'
    """
    for key in ("via", "fence", "rally", "obstacles", "maps"):
        words = renamed(words, key, partial(_counted, key))
    return words


def _counted(key: str, numbers: list[int]) -> str:
    return f"{key.removesuffix('s')} {numbers[0] + 1}" if numbers else key


def renamed(words: str, key: str, called: Callable[[list[int]], str]) -> str:
    """Replace a key and its indices: `key[1][2]` by `called([1, 2])`."""
    text, *rest = words.split(key)
    for part in rest:
        numbers = list[int]()
        while (number := part.removeprefix("[").partition("]")[0]).isdigit() and part[0] == "[":
            numbers.append(int(number))
            part = part.partition("]")[2]
        text += called(numbers) + part
    return text


class PageMessage(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


def as_json(message: PageMessage | dict[str, Any]) -> dict[str, Any]:
    return message if isinstance(message, dict) else message.model_dump(mode="json")


class Window:
    """An open page; a task of its own sends messages in order from the `queue`."""

    def __init__(self) -> None:
        self.queue: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def send(self, message: PageMessage | dict[str, Any]) -> None:
        self.queue.put_nowait(as_json(message))


class MapLine(PageMessage):
    """Points on the map, and the height of each above home [m]."""

    points: tuple[LngLat, ...]
    up: tuple[float, ...]
