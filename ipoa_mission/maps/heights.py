"""How high a building is, by OpenStreetMap's tags: `height`, `min_height`, `building:levels` and their relatives.

A value is metres unless it says feet. Where a tag gives several values, or a range, the greatest counts: too high is
safe. What cannot be read is named, and taken as if it were not there.
"""

import math
import re
from collections.abc import Callable, Mapping
from functools import lru_cache

from ipoa_mission.errors import BadInput

FOOT = 0.3048
INCH = FOOT / 12
LONGEST = 40  # characters of a length
NUMBER = r"(\d+(?:[.,]\d{1,2}|\.\d+)?(?:e[-+]?\d)?|[.,]\d+)"  # 1,200 is no length: a comma there may mean thousands
ABOUT = re.compile(r"(?:~|≈|<|approx(?:imately|\.)?|about|around|circa|ca?\.?|est(?:imated|\.)?) *")
METRES = re.compile(rf"{NUMBER} ?(?:m|metres?|meters?)?")
FEET = re.compile(rf"{NUMBER} ?(?:ft|feet|foot|'|′|’)(?: ?{NUMBER} ?(?:in|inches|\"|″|”|''))?")
STOREYS = re.compile(rf"{NUMBER} ?(?:storey|story|storie|level|floor)s?")
RANGE = re.compile(r"(.*\d[^-–]*)[-–](.*\d.*)")
Odd = Callable[[str, str], None]  # told of the key and the value of a tag that cannot be read


def meters(text: str, place: str) -> float:
    """A length of OpenStreetMap ("23", "23 m", "75 ft", "7'6\\"", "12;15", "12-15", "approx 12") in metres.

    Raises:
        BadInput: it is none.
    """
    lengths = [_one_length(part.strip().lower()) for part in text.split(";")]
    if any(length is None for length in lengths):
        raise BadInput(f'{place}: expected metres or feet ("23", "23 m", "75 ft"), not {text!r}')
    return max(length for length in lengths if length is not None)


def levels(text: str, place: str) -> float:
    """A number of storeys ("5", "2.5", "3;4").

    Raises:
        BadInput: it is none.
    """
    numbers = [re.fullmatch(NUMBER, part.strip()) for part in text.split(";")]
    if not all(numbers):
        raise BadInput(f"{place}: expected a number of storeys, not {text!r}")
    return max(_number(number[1]) for number in numbers if number)


def height_of(tags: Mapping[str, str], height_key: str, storey_height: float, odd: Odd) -> float | None:
    """Height of the top above the ground [m]: `height_key`, or the storeys and those in the roof; None if untagged.

    `odd` is told of each tag that is no height, or one of nothing.
    """
    if height_key in tags:
        text = ABOUT.sub("", tags[height_key].strip().lower(), count=1)
        storeys = STOREYS.fullmatch(text)
        height = _number(storeys[1]) * storey_height if storeys else _read(meters, tags, height_key, odd)
        if height is not None and height > 0:
            return height
        if height is not None:
            odd(height_key, tags[height_key])
    if (storeys_told := _read(levels, tags, "building:levels", odd)) is None:
        return None
    roof = _read(meters, tags, "roof:height", odd)
    if roof is None:
        roof = (_read(levels, tags, "roof:levels", odd) or 0.0) * storey_height
    return storeys_told * storey_height + roof or None  # no storey at all is said of sheds and canopies


def foot_of(tags: Mapping[str, str], storey_height: float, odd: Odd) -> float:
    """Height of the lower side above the ground [m]: of what bridges a street or stands on other parts.

    What begins below the ground, or at a height that cannot be read, of which `odd` is told, stands on the ground.
    """
    if "min_height" in tags:
        return 0.0 if tags["min_height"].startswith("-") else _read(meters, tags, "min_height", odd) or 0.0
    return (_read(levels, tags, "building:min_level", odd) or 0.0) * storey_height


def width_of(tags: Mapping[str, str], odd: Odd) -> float | None:
    """Diameter of what is a point, or width of a line [m]; None if untagged."""
    widths = (_read(meters, tags, key, odd) for key in ("diameter", "diameter_crown", "width"))
    return next((width for width in widths if width), None)


def _read(read: Callable[[str, str], float], tags: Mapping[str, str], key: str, odd: Odd) -> float | None:
    if key not in tags:
        return None
    try:
        return read(tags[key], key)
    except BadInput:
        odd(key, tags[key])
        return None


@lru_cache(maxsize=4096)  # a map says the same few heights over and over
def _one_length(text: str) -> float | None:
    if len(text) > LONGEST:
        return None
    text = ABOUT.sub("", text, count=1) if ABOUT.match(text) else text
    if (match := RANGE.fullmatch(text)) and "e-" not in text:
        ends = [_one_length(end.strip()) for end in match.groups()]
        return None if None in ends else max(end for end in ends if end is not None)
    if match := METRES.fullmatch(text):
        return _number(match[1])
    if match := FEET.fullmatch(text):
        return _number(match[1]) * FOOT + (_number(match[2]) * INCH if match[2] else 0.0)
    return None


def _number(text: str) -> float:
    value = float(text.replace(",", "."))
    return value if math.isfinite(value) else 0.0
