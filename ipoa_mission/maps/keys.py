"""Keys of any source by what they measure.

A key is read by its words: `building:height`, `BLDG_HEIGHT` and `measuredHeight` are the same. Cut ones are completed
by OpenStreetMap's names.
"""

import re
from collections.abc import Iterable, Mapping
from enum import StrEnum
from functools import lru_cache

CUT = 10  # letters, by a Shapefile
CUT_BY_SHP_WRITE = 8  # before 0.4.2
AMBIGUITY_MARK = "perhaps"


def _set(*lines: str) -> frozenset[str]:
    return frozenset(" ".join(lines).split())


class Means(StrEnum):
    TOP = "top above the ground"
    FOOT = "lower side above the ground"
    LEVELS = "storeys above the ground"
    MAX_LEVEL = "number of the highest storey, from 0"
    MIN_LEVEL = "storeys below its lower side"
    ROOF = "height of the roof alone"
    ROOF_LEVELS = "storeys in the roof"
    HUB = "hub of a rotor above the ground"
    ROTOR = "diameter of a rotor"
    BLADE = "radius of a rotor"
    CROWN = "diameter of a crown"
    WIDTH = "width or diameter"
    RADIUS = "radius"
    LENGTH = "length"
    UNIT = "unit of other keys"
    AMBIGUOUS = "may be a height"
    NOTHING = "nothing of these"


_EXACT = {
    "min_height": Means.FOOT,
    "building_min_height": Means.FOOT,
    "building_min_level": Means.MIN_LEVEL,
    "min_level": Means.MIN_LEVEL,
    "min_floor": Means.MIN_LEVEL,
    "building_max_level": Means.MAX_LEVEL,
    "max_level": Means.MAX_LEVEL,
    "roof_height": Means.ROOF,
    "building_roof_height": Means.ROOF,
    "roof_levels": Means.ROOF_LEVELS,
    "building_roof_levels": Means.ROOF_LEVELS,
    "blade_length": Means.BLADE,
    "blades_length": Means.BLADE,
    "rotor_radius": Means.BLADE,
    "length": Means.LENGTH,
    "crane_length": Means.LENGTH,
    "maxheight": Means.NOTHING,  # of vehicles
    "height_amsl": Means.NOTHING,  # has its own rule
    "ele": Means.NOTHING,  # of the ground, AMSL
    "elevation": Means.NOTHING,
}
# About another key.
_ABOUT = _set(
    "source note notes date accuracy ref error type class code method check survey color quality status",
    "confidence material shape direction angle description name id start end name_en comment fixme",
)
_HEIGHT = re.compile(r"height|hoehe|höhe|hauteur|altura|altezza|hoogte|hgt|výška|vyska|wysokosc|agl$|^agl")
# Other heights than the top.
_LOWER = _set(
    "min base bottom foot ground clearance passage sill door entrance gate step kerb curb riser ceiling storey",
    "story level floor terrain restriction limit limits vehicle legal physical signed person seat table handrail",
    "maxheight platform tunnel lane parking under",
)
_EAVES = _set("eave eaves gutter traufe trauf gouttiere parapet wall")
_HUB = _set("hub nacelle axis")
_ROTOR = _set("rotor blade blades turbine")
_CROWN = _set("crown canopy spread")
_LEVELS = _set(
    "levels storeys stories floors etages étages geschosse geschosszahl vollgeschosse stockwerke plantas pisos",
    "piani bouwlagen numfloors nbetages",
)
_COUNTED = _set("storey story floor etage geschoss stockwerk")
_COUNT = _set("num number nb no count anzahl total of nombre cnt")
_BELOW = _set("underground basement below under skipped height start parking attic non_existent source")
_WIDTH = re.compile(r"diameter|durchmesser|diametre|width|breite|largeur|ancho")
_NARROW = _set(
    "trunk stem dbh hole pipe step door entrance lane lanes carriageway sidewalk max maxwidth min kerb road",
    "passage tread bore opening circumference",
)
_AMBIGUOUS_WORDS = _set("h ht alt altitude z zmax ztop hmax dach toit top tip amsl asl msl elev elevation")
_UNITS = _set("unit units uom einheit")


def plain(key: str) -> str:
    """Return words joined by `_`, in lower case."""
    words = re.sub(r"(?<=[a-zäöü0-9])(?=[A-ZÄÖÜ])", "_", key).lower()
    return re.sub(r"[\W_]+", "_", words).strip("_")


@lru_cache(maxsize=65536)
def meaning(key: str) -> Means:
    text = plain(key)
    if text in _EXACT:
        return _EXACT[text]
    words = frozenset(text.split("_"))
    if words & _ABOUT:
        return Means.NOTHING
    if AMBIGUITY_MARK in words:
        return Means.AMBIGUOUS
    if words & _UNITS:
        return Means.UNIT
    if _HEIGHT.search(text):
        return _height(text, words)
    if words & _LEVELS or (words & _COUNTED and words & _COUNT):
        if "roof" in words:
            return Means.ROOF_LEVELS
        return Means.NOTHING if words & _BELOW or "min" in words else Means.LEVELS
    if _WIDTH.search(text) or "radius" in words:
        return _width(words)
    return Means.AMBIGUOUS if words & _AMBIGUOUS_WORDS and not words & _LOWER else Means.NOTHING


def _height(text: str, words: frozenset[str]) -> Means:
    if words & _HUB:
        return Means.HUB
    if words & _LOWER or text.startswith(("maxheight", "minheight")):
        return Means.NOTHING
    if words & _EAVES:
        return Means.AMBIGUOUS
    return Means.ROOF if text.startswith("roof_") else Means.TOP


def _width(words: frozenset[str]) -> Means:
    if words & _NARROW:
        return Means.NOTHING
    is_radius = "radius" in words
    if words & _ROTOR:
        return Means.BLADE if is_radius else Means.ROTOR
    if words & _CROWN:
        return Means.RADIUS if is_radius else Means.CROWN
    return Means.RADIUS if is_radius else Means.WIDTH


class Names:
    def __init__(self, known: Iterable[str]) -> None:
        self._known = {plain(key): key for key in known}

    def of(self, key: str) -> str:
        """Ignore case and punctuation."""
        return self._known.get(plain(key), key)

    def starting_as(self, key: str) -> tuple[str, ...]:
        text = _squeezed(key)
        begins = (text, re.sub(r"\d{1,2}$", "", text))  # a second one ends in _1
        return tuple(
            known for known in self._known.values() if len(known) > CUT and _squeezed(known).startswith(begins)
        )


def completed(key: str) -> str:
    """Complete a cut last word that measures something."""
    for word in ("height", "diameter", "levels", "storeys", "floors", "radius"):
        for length in range(len(word) - 1, 2, -1):
            if key.lower().endswith(word[:length]):
                return key + word[length:]
    return key


def _squeezed(key: str) -> str:
    return re.sub(r"[\W_]+", "", key).lower()


def keys_of(tags: Mapping[str, str], *means: Means) -> list[str]:
    return [key for key in tags if meaning(key) in means]
