"""Read lengths and storeys as mappers spell them: `23 m`, `7'4"`, `22+`, `60 m (AGL)`, `1,200`, `G+4`."""

import math
import re
from functools import lru_cache

from ipoa_mission.errors import BadInput

INCH = 0.0254  # [m]
FOOT = 0.3048  # [m]
_UNITS = {
    1.0: "m metre metres meter meters mtr mtrs mt mts м metri metros mètre mètres",
    0.01: "cm centimetre centimetres centimeter centimeters",
    0.001: "mm millimetre millimetres millimeter millimeters",
    1000.0: "km kilometre kilometres kilometer kilometers",
    FOOT: "ft feet foot ' ′ ’ ` ´",
    INCH: "in inch inches \" ″ ” “ ''",
    3 * FOOT: "yd yds yard yards",
    1852.0: "nm nmi",
    1609.344: "mi mile miles",
}
UNIT_FACTORS = {name: factor for factor, names in _UNITS.items() for name in names.split()}
# Commas, apostrophes, dots or blanks separate thousands. No sign: `12-15` is a range.
NUMBER = (
    r"(?:\d{1,3}(?:[,'’]\d{3})+(?:\.\d+)?(?!\d)|\d{1,3}(?:\.\d{3})+,\d+|\d{1,3}(?: \d{3})+(?!\d)"
    r"|\d+(?:[.,]\d+)?(?:e[-+]?\d(?!\d))?|[.,]\d+)"
)
_QUANTITY = re.compile(rf"({NUMBER})\.? ?([a-zм′’″”“`´'\"è]*)")
_ASIDE = re.compile(
    r"approx(?:imate(?:ly)?)?|about|around|circa|ca?|est(?:imate[d]?)?|roughly|agl|above|over|ground|level|lvl|from|the|"
    r"high|tall|height|total|overall|roof|ridge|top|tip|spire|antenna|mast|tower|building|parapet|with(?:out)?|"
    r"max(?:imum)?|min(?:imum)?|at least|up|to|and|plus|incl(?:uding)?|of|[~≈<>≤≥=+±()\[\];/&,.?–—-]|\s"
)
_STOREY = (
    r"storeys?|story|stories|storie|levels?|floors?|lvls?|fl|étages?|etages?|stockwerke?|geschosse?|pisos?|plantas?"
    r"|piani"
)
_TERM = r"(?:\d+(?:[.,]5)?[a-zäöü]{0,3}|[a-zäöü]{1,8}|(?:b|ub|ug|sb|ss)\d+)"
_SUM = re.compile(rf"{_TERM}(?:\+{_TERM})+")
# Full-width as ASCII.
_WIDE = {code: code - 0xFEE0 for code in range(0xFF01, 0xFF5F)} | {0x3000: 0x20}


def meters(text: str, place: str) -> float:
    length, sure = length_of(text)
    if length is None or not sure:
        raise BadInput(f'expected meters or feet ("23", "23 m", "75 ft"), not {text!r}', place=place)
    return length


@lru_cache(maxsize=4096)  # a map repeats few heights
def length_of(text: str) -> tuple[float | None, bool]:
    """Return the greatest length [m], and whether all was understood. A bare number or an unknown unit is in meters."""
    text = re.sub(r"\.{2,}|…", "-", _plain(text))
    lengths = list[float]()
    end = 0
    last = 0.0
    rest = list[str]()
    for match in _QUANTITY.finditer(text):
        between = text[end : match.start()]
        end = match.end()
        rest.append(between)
        unit = match[2]
        factor = UNIT_FACTORS.get(unit)
        if factor is None:  # 22approx, 60agl
            factor = 1.0
            rest.append(unit)
        if last == FOOT and not unit and not between.strip():  # 6'2
            factor = INCH
        length = _number(match[1]) * factor
        joint = between.strip(" ,")
        is_part = factor < last and joint in ("", "and")  # 7 ft 4 in, 5 m 30 cm
        if lengths and ((not between.strip() and not (is_part and length < last)) or (joint == "/" and not last)):
            rest.append(match[0])  # 12.5.3, 5 m 30, 1/2
        if lengths and (is_part or joint in ("+", "plus", "with")):  # 12 m + 8 m antenna
            lengths[-1] += length
        else:
            lengths.append(length)
        last = factor if unit else 0.0
    rest.append(text[end:])
    sure = not any(_ASIDE.sub("", part) for part in rest) and all(re.search(r"\d", part) for part in text.split(";"))
    greatest = sum(lengths) if "±" in text or "+/-" in text else max(lengths, default=None)
    return (None, False) if greatest is None or not math.isfinite(greatest) else (greatest, sure)


@lru_cache(maxsize=4096)
def storeys_of(text: str) -> tuple[float | None, bool]:
    """Return the greatest number above the ground, and whether all was understood.

    In `G+4` and `2+1` each part counts, a letter as one storey, basements as none.
    """
    numbers = list[float]()
    sure = not re.search(r"\d[ -]\d+/\d", text)  # 10-1/2
    for part in re.split(r"[;/]|(?<=\d)[-–](?=\d)", _without_blanks_at_plus(text)):
        part = re.sub(rf"\b(?:{_STOREY})\b", "", part).strip(" ~≈<>.()")
        if _SUM.fullmatch(part):
            below = r"(?:b|ub|ug|kg|sb|ss|bg|basement)s?\d*|\d+ ?(?:ug|kg|ss|sb)"
            terms = [term for term in part.split("+") if not re.fullmatch(below, term)]
            numbers.append(sum(_number(re.sub("[a-zäöü]+$", "", term)) if term[0].isdigit() else 1.0 for term in terms))
        else:
            counts = [_number(number) for number in re.findall(NUMBER, part)]
            numbers += counts
            sure = sure and len(counts) == 1 and not _ASIDE.sub("", re.sub(NUMBER, "", part, count=1))
    return (max(numbers), sure) if numbers and math.isfinite(max(numbers)) else (None, False)


def names_storeys(text: str) -> bool:
    """Tell `6 floors` and `G+4` from lengths."""
    plain = _without_blanks_at_plus(text)
    is_sum = _SUM.fullmatch(plain) and plain[0] in "abcdefghijklmnopqrstuvwxyz"
    return bool(is_sum or re.search(rf"{NUMBER} ?(?:{_STOREY})\b", plain))


def _plain(text: str) -> str:
    text = " ".join(text.translate(_WIDE).lower().split())
    return "" if len(text) > 60 or text.startswith(("-", "−")) else text


def _without_blanks_at_plus(text: str) -> str:
    return re.sub(r"\s*\+\s*", "+", _plain(text))


def _number(text: str) -> float:
    text = text.replace(" ", "")
    if re.fullmatch(r"\d{1,3}(\.\d{3})+,\d+", text):
        text = text.replace(".", "")
    if re.fullmatch(r"\d{1,3}([,'’]\d{3})+(\.\d+)?", text):
        text = re.sub("[,'’]", "", text)
    return float(text.replace(",", "."))
