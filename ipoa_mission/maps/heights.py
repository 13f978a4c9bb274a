"""How high a building is, by OpenStreetMap's tags: `height`, `min_height`, `building:levels` and their relatives.

A value is metres unless it says feet. Where a tag gives several values the greatest counts: too high is safe.
"""

import re
from collections.abc import Mapping

from ipoa_mission.errors import BadInput

FOOT = 0.3048
INCH = FOOT / 12
NUMBER = r"(\d+(?:[.,]\d{1,2}|\.\d+)?|[.,]\d+)"  # 1,200 is no length: a comma before three digits may mean thousands
METRES = re.compile(rf"~?{NUMBER} ?(?:m|metres?|meters?)?")
FEET = re.compile(rf"~?{NUMBER} ?(?:ft|feet|foot|'|′|’)(?: ?{NUMBER} ?(?:in|inches|\"|″|”|''))?")


def meters(text: str, place: str) -> float:
    """A length of OpenStreetMap ("23", "23 m", "75 ft", "7'6\\"", "12;15") in metres.

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


def height_of(tags: Mapping[str, str], place: str, height_key: str, storey_height: float) -> float | None:
    """Height of the top above the ground [m]: `height_key`, or the storeys and those in the roof; None if untagged.

    Raises:
        BadInput: a tag that is no height, or a height of nothing.
    """
    if height_key in tags:
        height = meters(tags[height_key], f"{place}.{height_key}")
        if height <= 0:
            raise BadInput(f"{place}.{height_key}: expected a height of more than nothing, not {tags[height_key]!r}")
        return height
    if "building:levels" not in tags:
        return None
    storeys = levels(tags["building:levels"], f"{place}.building:levels")
    if "roof:height" in tags:
        height = storeys * storey_height + meters(tags["roof:height"], f"{place}.roof:height")
    else:
        in_roof = levels(tags["roof:levels"], f"{place}.roof:levels") if "roof:levels" in tags else 0.0
        height = (storeys + in_roof) * storey_height
    return height or None  # no storey at all is said of sheds and canopies


def foot_of(tags: Mapping[str, str], place: str, storey_height: float) -> float:
    """Height of the lower side above the ground [m]: of what bridges a street or stands on other parts.

    Raises:
        BadInput: a tag that is no height.
    """
    if "min_height" in tags:
        if tags["min_height"].startswith("-"):
            return 0.0  # it begins below the ground
        return meters(tags["min_height"], f"{place}.min_height")
    if "building:min_level" in tags:
        return levels(tags["building:min_level"], f"{place}.building:min_level") * storey_height
    return 0.0


def _one_length(text: str) -> float | None:
    if match := METRES.fullmatch(text):
        return _number(match[1])
    if match := FEET.fullmatch(text):
        return _number(match[1]) * FOOT + (_number(match[2]) * INCH if match[2] else 0.0)
    return None


def _number(text: str) -> float:
    return float(text.replace(",", "."))
