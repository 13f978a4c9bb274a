"""What the keys of a map mean for height and width, whoever wrote it: `height`, `est_height`, `rotor:diameter`, `AGL`.

A key is taken by its words, so that `building:height`, `BLDG_HEIGHT` and `measuredHeight` are one. Names that a
Shapefile has cut to ten letters, or that GDAL wrote with `_` in place of `:`, are found by OpenStreetMap's own.
"""

import re
from collections.abc import Iterable, Mapping
from enum import StrEnum
from functools import lru_cache

CUT = 10  # letters of a name in a Shapefile
CUT_BY_SHP_WRITE = 8  # in those of shp-write before 0.4.2
PERHAPS = "perhaps"  # a word in the names of keys that may be another's


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


class Means(StrEnum):
    """What a key measures."""

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
    PERHAPS = "may be a height"
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
    "maxheight": Means.NOTHING,  # of vehicles below it
    "height_amsl": Means.NOTHING,  # has a rule of its own
    "ele": Means.NOTHING,  # of the ground, above sea level
    "elevation": Means.NOTHING,
}
#: Words of a key that tells of another one, not of the thing.
_ABOUT = _set(
    "source note notes date accuracy ref error type class code method check survey color quality status "
    "confidence material shape direction angle description name id start end name_en comment fixme"
)
_HEIGHT = re.compile(r"height|hoehe|höhe|hauteur|altura|altezza|hoogte|hgt|výška|vyska|wysokosc|agl$|^agl")
#: Heights of something else than the top.
_LOWER = _set(
    "min base bottom foot ground clearance passage sill door entrance gate step kerb curb riser ceiling storey "
    "story level floor terrain restriction limit limits vehicle legal physical signed person seat table handrail "
    "maxheight platform tunnel lane parking under"
)
_EAVES = _set("eave eaves gutter traufe trauf gouttiere parapet wall")
_HUB = _set("hub nacelle axis")
_ROTOR = _set("rotor blade blades turbine")
_CROWN = _set("crown canopy spread")
_LEVELS = _set(
    "levels storeys stories floors etages étages geschosse geschosszahl vollgeschosse stockwerke plantas pisos "
    "piani bouwlagen numfloors nbetages"
)
_COUNTED = _set("storey story floor etage geschoss stockwerk")
_COUNT = _set("num number nb no count anzahl total of nombre cnt")
_BELOW = _set("underground basement below under skipped height start parking attic non_existent source")
_WIDTH = re.compile(r"diameter|durchmesser|diametre|width|breite|largeur|ancho")
_NARROW = _set(
    "trunk stem dbh hole pipe step door entrance lane lanes carriageway sidewalk max maxwidth min kerb road "
    "passage tread bore opening circumference"
)
_PERHAPS = _set("h ht alt altitude z zmax ztop hmax dach toit top tip amsl asl msl elev elevation")
_MEASURED = ("height", "diameter", "levels", "storeys", "floors", "radius")
_UNITS = _set("unit units uom einheit")


def plain(key: str) -> str:
    """A key in small letters, its words parted by `_`."""
    words = re.sub(r"(?<=[a-zäöü0-9])(?=[A-ZÄÖÜ])", "_", key).lower()
    return re.sub(r"[\W_]+", "_", words).strip("_")


@lru_cache(maxsize=65536)
def meaning(key: str) -> Means:
    """What a key measures."""
    text = plain(key)
    if text in _EXACT:
        return _EXACT[text]
    words = frozenset(text.split("_"))
    if words & _ABOUT:
        return Means.NOTHING
    if PERHAPS in words:
        return Means.PERHAPS
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
    return Means.PERHAPS if words & _PERHAPS and not words & _LOWER else Means.NOTHING


def _height(text: str, words: frozenset[str]) -> Means:
    if words & _HUB:
        return Means.HUB
    if words & _LOWER or text.startswith(("maxheight", "minheight")):
        return Means.NOTHING
    if words & _EAVES:
        return Means.PERHAPS
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
    """Keys as a program knows them, found under the names that they have in files."""

    def __init__(self, known: Iterable[str]) -> None:
        self._known = {plain(key): key for key in known}

    def of(self, key: str) -> str:
        """The known key that is written so but for capitals and marks; else the key itself."""
        return self._known.get(plain(key), key)

    def starting_as(self, key: str) -> tuple[str, ...]:
        """The known keys of which a Shapefile keeps these ten letters, the last of them a number it may be."""
        text = _squeezed(key)
        begins = (text, re.sub(r"\d{1,2}$", "", text))  # a second one ends in _1
        return tuple(
            known for known in self._known.values() if len(known) > CUT and _squeezed(known).startswith(begins)
        )


def completed(key: str) -> str:
    """A key whose last word measures something and was cut, with all of that word."""
    for word in _MEASURED:
        for length in range(len(word) - 1, 2, -1):
            if key.lower().endswith(word[:length]):
                return key + word[length:]
    return key


def _squeezed(key: str) -> str:
    return re.sub(r"[\W_]+", "", key).lower()


def those(tags: Mapping[str, str], *means: Means) -> list[str]:
    """The keys that mean one of these."""
    return [key for key in tags if meaning(key) in means]
