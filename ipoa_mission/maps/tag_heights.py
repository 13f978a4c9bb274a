"""Read heights from tags. The greatest counts, for safety; a partly understood value is reported."""

import re
from collections.abc import Callable, Mapping

from ipoa_mission.maps.keys import AMBIGUITY_MARK, Means, keys_of, normalize
from ipoa_mission.maps.lengths import NUMBER, UNIT_FACTORS, length_of, names_storeys, storeys_of

WIDEST_ROTOR = 170.0  # without a tag [m]
UNITS_IN_KEYS = ("ft", "feet", "km", "nm", "nmi", "mi", "miles")  # smaller ones are ignored, for safety
Odd = Callable[[str, str], None]  # of a key or subject, and the value not understood


def height_of(tags: Mapping[str, str], height_key: str, storey_height: float, odd: Odd) -> float | None:
    """Return the top above the ground [m].

    A `height_key` other than `height` counts alone. Without `height`, storeys plus those in the roof count too.
    """
    height_by_key = _top(tags, height_key, storey_height, odd) if height_key in tags else None
    if height_by_key is not None and height_key != "height":
        return height_by_key
    others = [_top(tags, key, storey_height, odd) for key in keys_of(tags, Means.TOP) if key != height_key]
    heights = [height for height in (height_by_key, *others) if height is not None]
    tip = _tip(tags, odd, bool(heights))
    by_storeys = _by_storeys(tags, storey_height, odd) if height_by_key is None else None
    return max((height for height in (*heights, tip, by_storeys) if height is not None), default=None)


def foot_of(tags: Mapping[str, str], storey_height: float, odd: Odd) -> float:
    """Return the lower side above the ground [m]; 0 if unreadable."""
    if any(UNIT_FACTORS.get(tags[key].lower()) != 1.0 for key in keys_of(tags, Means.UNIT)):
        return 0.0
    feet = keys_of(tags, Means.FOOT)
    keys, read, unit = (feet, length_of, 1.0) if feet else (keys_of(tags, Means.MIN_LEVEL), storeys_of, storey_height)
    heights = []
    for key in keys:
        value, sure = read(tags[key])
        sure = sure and len(re.findall(r"\d+(?:[.,]\d+)?", tags[key])) == 1  # of several the greatest is read
        if not tags[key].startswith("-") and (value is None or not sure):
            odd(key, tags[key])
        heights.append(0.0 if value is None or not sure else value * unit)
    return min(heights, default=0.0)


def width_of(tags: Mapping[str, str], odd: Odd, is_tree: bool = False) -> float | None:
    """Return a width or diameter [m]; of a tree, `diameter` is that of the trunk."""
    wide = (Means.CROWN,) if is_tree else (Means.ROTOR, Means.CROWN, Means.WIDTH)
    widths = [read_length(tags, key, odd) for key in keys_of(tags, *wide)]
    half = (Means.RADIUS,) if is_tree else (Means.BLADE, Means.RADIUS)
    widths += [2 * (read_length(tags, key, odd) or 0.0) for key in keys_of(tags, *half)]
    return max((width for width in widths if width), default=None)


def unread_heights(tags: Mapping[str, str], height: float, storey_height: float) -> list[str]:
    ambiguous = [
        key
        for key in keys_of(tags, Means.AMBIGUOUS)
        if (length_of(tags[key])[0] or 0.0) * (storey_height if AMBIGUITY_MARK in normalize(key) else 1.0) > height
    ]
    texts = [key for key in ("description", "note", "comment") if _height_in(tags.get(key, "")) > height]
    return [*ambiguous, *texts]


def _height_in(text: str) -> float:
    """Return the greatest length next to a word for height [m]; 0: none."""
    length = rf"({NUMBER}\s?(?:m|ft|feet|')?\b)"
    name = r"(?:height|höhe|hoehe|hauteur|altura|altezza|hoogte)"
    plain = re.sub(r"<[^>]*>", " ", text[:20_000]).lower()
    found = re.findall(rf"{name}\D{{0,20}}?{length}|{length}[a-zè]*\s(?:high|tall|hoch|haut)", plain)
    return max((length_of(before or after)[0] or 0.0 for before, after in found), default=0.0)


def unused_numbers(tags: Mapping[str, str], height: float) -> list[str]:
    """Return unknown keys whose number may be a greater height."""
    unknown = [key for key in keys_of(tags, Means.NOTHING) if not key.startswith(("addr:", "@")) and "id" not in key]
    lengths = {key: length_of(tags[key]) for key in unknown}
    return [key for key, (length, sure) in lengths.items() if sure and height < (length or 0.0) < 1000.0]


def is_by_storeys(tags: Mapping[str, str]) -> bool:
    if keys_of(tags, Means.TOP, Means.ROOF, Means.ROOF_LEVELS) or tags.get("roof:shape") == "flat":
        return False
    return bool(keys_of(tags, Means.LEVELS, Means.MAX_LEVEL))


def _top(tags: Mapping[str, str], key: str, storey_height: float, odd: Odd) -> float | None:
    storeys = _read(storeys_of, tags, key, odd) if names_storeys(tags[key]) else None
    height = read_length(tags, key, odd) if storeys is None else storeys * storey_height
    if height is not None and height <= 0:
        odd(key, tags[key])
        return None
    return height


def read_length(tags: Mapping[str, str], key: str, odd: Odd) -> float | None:
    length = _read(length_of, tags, key, odd)
    if length is not None and not re.search(r"[^\W\d_]|['’′\"”″]", tags[key]):  # without a unit
        length *= _unit_factor(tags, normalize(key).removesuffix("_value"))
    return length


def _unit_factor(tags: Mapping[str, str], plain_key: str) -> float:
    """Return the unit [m] that the key or its own unit key names; one of all keys counts if greater."""
    factors = [UNIT_FACTORS[word] for word in plain_key.split("_") if word in UNITS_IN_KEYS]
    for key in keys_of(tags, Means.UNIT):
        factor = UNIT_FACTORS.get(tags[key].lower(), 0.0)
        if factor > 1.0 or (factor and normalize(key).startswith(f"{plain_key}_")):
            factors.append(factor)
    return factors[0] if factors else 1.0


def _tip(tags: Mapping[str, str], odd: Odd, height_known: bool) -> float | None:
    hubs = [height for key in keys_of(tags, Means.HUB) if (height := read_length(tags, key, odd))]
    rotor = width_of(tags, odd) if keys_of(tags, Means.ROTOR, Means.BLADE) else None
    if not hubs or (rotor is None and height_known):
        return None
    return max(hubs) + (min(WIDEST_ROTOR / 2, max(hubs)) if rotor is None else rotor / 2)


def _by_storeys(tags: Mapping[str, str], storey_height: float, odd: Odd) -> float | None:
    counts = [_read(storeys_of, tags, key, odd) for key in keys_of(tags, Means.LEVELS)]
    highest = [_read(storeys_of, tags, key, odd) for key in keys_of(tags, Means.MAX_LEVEL)]
    known = [count for count in counts if count is not None] + [number + 1 for number in highest if number is not None]
    if not known:
        return None
    roofs = [read_length(tags, key, odd) for key in keys_of(tags, Means.ROOF)]
    if not any(roof is not None for roof in roofs):
        roofs = [(_read(storeys_of, tags, key, odd) or 0.0) * storey_height for key in keys_of(tags, Means.ROOF_LEVELS)]
    roof = max((roof for roof in roofs if roof is not None), default=0.0)
    return max(known) * storey_height + roof or None  # sheds and canopies have 0 storeys


def _read(
    read: Callable[[str], tuple[float | None, bool]], tags: Mapping[str, str], key: str, odd: Odd
) -> float | None:
    value, is_understood = read(tags[key])
    if not is_understood:
        odd(key, tags[key])
    return value
