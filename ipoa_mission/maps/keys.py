"""Classify the keys of tags by what they measure.

`building:height`, `BLDG_HEIGHT` and `measuredHeight` are the same: their words count.
"""

import re
import unicodedata
from collections.abc import Mapping
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
    **dict.fromkeys(("min_height", "building_min_height"), Means.FOOT),
    **dict.fromkeys(("building_min_level", "min_level", "min_floor"), Means.MIN_LEVEL),
    **dict.fromkeys(("building_max_level", "max_level"), Means.MAX_LEVEL),
    **dict.fromkeys(("roof_height", "building_roof_height"), Means.ROOF),
    **dict.fromkeys(("roof_levels", "building_roof_levels"), Means.ROOF_LEVELS),
    **dict.fromkeys(("blade_length", "blades_length", "rotor_radius"), Means.BLADE),
    **dict.fromkeys(("length", "crane_length"), Means.LENGTH),
    # Of vehicles; with its own rule; of the ground (AMSL).
    **dict.fromkeys(("maxheight", "height_amsl", "ele", "elevation"), Means.NOTHING),
}


class _Words:
    ABOUT_ANOTHER_KEY = _set(
        "source note notes date accuracy ref error type class code method check survey color quality status",
        "confidence material shape direction angle description name id start end name_en comment fixme",
    )
    HEIGHT = re.compile(  # without accents
        r"height|hoehe|hohe|hauteur|altura|altezza|hoogte|hgt|vyska|wysokosc|hojd|hoejde|høyde|hoyde|korkeus|magassag"
        r"|yukseklik|visina|korgus|inaltime|alcada|aukstis|augstums|υψος|высота|高さ|heigth|hight|bldght|agl$|^agl"
    )
    OTHER_HEIGHTS = _set(  # than the top
        "min base bottom foot ground clearance passage sill door entrance gate step kerb curb riser ceiling storey",
        "story level floor terrain restriction limit limits vehicle legal physical signed person seat table handrail",
        "maxheight platform tunnel lane parking under",
    )
    EAVES = _set("eave eaves gutter traufe trauf gouttiere parapet wall")
    HUB = _set("hub nacelle axis")
    ROTOR = _set("rotor blade blades turbine")
    CROWN = _set("crown canopy spread")
    LEVELS = _set(
        "levels lvls storeys stories floors flrs etages geschosse geschosszahl vollgeschosse stockwerke plantas pisos",
        "piani bouwlagen numfloors nfloors floorcount nbetages aog gastw etager vaningar etasjer kerrosluku",
        "kondygnacje kondygnacji podlazi emeletek szintek etaje etaj этажность 階数",
    )
    LEVEL = _set("storey story floor etage geschoss stockwerk")
    COUNT = _set("num number nb no count anzahl total of nombre cnt")
    OTHER_LEVELS = _set(
        "underground basement below under skipped height start parking attic non_existent source min podziemne",
        "podziemnych podzemni",
    )
    WIDTH = re.compile(r"diameter|durchmesser|diametre|width|breite|largeur|ancho")
    OTHER_WIDTHS = _set(
        "trunk stem dbh hole pipe step door entrance lane lanes carriageway sidewalk max maxwidth min kerb road",
        "passage tread bore opening circumference",
    )
    RADIUS = _set("radius rayon raggio straal halbmesser promien polomer")
    AMBIGUOUS = _set("h ht alt altitude z zmax ztop hmax dach toit top tip amsl asl msl elev elevation topelev")
    UNITS = _set("unit units uom einheit")


def normalize(key: str) -> str:
    """Return words joined by `_`, in lower case and without accents."""
    plain = "".join(letter for letter in unicodedata.normalize("NFD", key) if not unicodedata.combining(letter))
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", plain).lower()
    return re.sub(r"[\W_]+", "_", words).strip("_")


@lru_cache(maxsize=65536)
def meaning(key: str) -> Means:
    text = normalize(key)
    if text in _EXACT:
        return _EXACT[text]
    words = frozenset(text.split("_"))
    if words & _Words.ABOUT_ANOTHER_KEY:
        return Means.NOTHING
    if AMBIGUITY_MARK in words:
        return Means.AMBIGUOUS
    if words & _Words.UNITS:
        return Means.UNIT
    if _Words.HEIGHT.search(text):
        return _height(text, words)
    if words & _Words.LEVELS or (words & _Words.LEVEL and words & _Words.COUNT):
        if "roof" in words:
            return Means.ROOF_LEVELS
        return Means.NOTHING if words & _Words.OTHER_LEVELS else Means.LEVELS
    if _Words.WIDTH.search(text) or words & _Words.RADIUS:
        return _width(words)
    return Means.AMBIGUOUS if words & _Words.AMBIGUOUS and not words & _Words.OTHER_HEIGHTS else Means.NOTHING


def _height(text: str, words: frozenset[str]) -> Means:
    if words & _Words.HUB:
        return Means.HUB
    if words & _Words.OTHER_HEIGHTS or text.startswith(("maxheight", "minheight")):
        return Means.NOTHING
    if words & _Words.EAVES:
        return Means.AMBIGUOUS
    return Means.ROOF if text.startswith("roof_") else Means.TOP


def _width(words: frozenset[str]) -> Means:
    if words & _Words.OTHER_WIDTHS:
        return Means.NOTHING
    if words & _Words.RADIUS:
        return Means.BLADE if words & _Words.ROTOR else Means.RADIUS
    if words & _Words.ROTOR:
        return Means.ROTOR
    return Means.CROWN if words & _Words.CROWN else Means.WIDTH


def complete(key: str) -> str:
    """Complete a cut last word that measures something."""
    for word in ("height", "diameter", "levels", "storeys", "floors", "radius"):
        for length in range(len(word) - 1, 2, -1):
            if key.lower().endswith(word[:length]):
                return key + word[length:]
    return key


def keys_of(tags: Mapping[str, str], *means: Means) -> list[str]:
    return [key for key in tags if meaning(key) in means]
