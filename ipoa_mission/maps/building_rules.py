import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from ipoa_mission.maps.keys import Means, keys_of
from ipoa_mission.maps.kinds import DRAG_LIFTS, TALL, WIRES, WOODS, is_bridge, is_tagged, values_of
from ipoa_mission.maps.lengths import length_of, storeys_of
from ipoa_mission.maps.tag_heights import WIDEST_ROTOR, Odd, read_length, width_of


class Size(NamedTuple):
    """Height above ground, and radius or half width [m]."""

    kind: str
    height: float
    radius: float


OTHER = Size("point or line", 20.0, 2.0)
# Height and radius [m].
_POINTS: Mapping[str, tuple[float, float]] = {
    "antenna": (60, 5), "chimney": (150, 8), "column": (40, 5), "communications_tower": (250, 15),
    "cooling_tower": (180, 70), "crane": (100, 60), "flagpole": (40, 3), "gasometer": (100, 40),
    "lighthouse": (70, 8), "mast": (120, 10), "monitoring_station": (20, 5), "obelisk": (60, 5),
    "observation_tower": (100, 15), "portal": (40, 12), "pylon": (80, 8), "silo": (60, 15), "storage_tank": (30, 40),
    "telescope": (60, 50), "terminal": (20, 5), "tower": (150, 15), "utility_pole": (20, 3), "pole": (30, 3),
    "water_tower": (70, 20), "windmill": (40, 20), "street_lamp": (15, 3), "gantry": (15, 10), "windsock": (15, 3),
    "minaret": (90, 5), "statue": (60, 10), "flare": (150, 8),
}  # fmt: skip
_LOW_BUILDINGS = {
    "annexe", "barn", "boathouse", "bungalow", "bunker", "cabin", "carport", "conservatory", "cowshed",
    "detached", "farm", "farm_auxiliary", "garage", "garages", "ger", "greenhouse", "guardhouse", "house",
    "houseboat", "hut", "kiosk", "outbuilding", "pavilion", "roof", "semidetached_house", "service", "shed",
    "slurry_tank", "stable", "static_caravan", "sty", "summer_cottage", "tent", "toilets", "tree_house", "trullo",
}  # fmt: skip
_BUILDINGS: Mapping[str, float] = {
    "apartments": 40, "bridge": 40, "castle": 40, "cathedral": 120, "chapel": 30, "chimney": 150, "church": 80,
    "commercial": 40, "cooling_tower": 180, "dormitory": 40, "fort": 40, "government": 40, "grandstand": 40,
    "hangar": 40, "hospital": 60, "hotel": 60, "industrial": 40, "lighthouse": 70, "mosque": 90, "office": 80,
    "public": 40, "religious": 80, "residential": 40, "silo": 60, "skyscraper": 300, "stadium": 60, "storage_tank": 30,
    "synagogue": 40, "temple": 60, "tower": 150, "train_station": 40, "university": 40, "warehouse": 30,
    "water_tower": 70, "windmill": 40,
}  # fmt: skip


def size_of(tags: Mapping[str, str]) -> Size:
    if is_turbine(tags):
        return Size("wind turbine", 250.0, WIDEST_ROTOR / 2)
    if is_bridge(tags):
        layer, _ = storeys_of(tags.get("layer", "1"))
        return Size("bridge", 10.0 * max(layer or 1.0, 1.0), 8.0)  # above the higher end, per layer
    if tags.get("natural") in TALL["natural"]:
        return Size("tree", 30.0, 5.0)
    if tags.get("power") == "tower":
        return Size("power tower", 80.0, 16.0)
    kinds = [kind for value in tags.values() for kind in values_of(value) if kind in _POINTS]
    if not kinds:
        return OTHER
    kind = max(kinds, key=lambda kind: _POINTS[kind])
    return Size(kind.replace("_", " "), *map(float, _POINTS[kind]))


def building_height(tags: Mapping[str, str]) -> tuple[str, float]:
    kinds = [tags[key] for key in ("building", "building:part") if key in tags]
    heights = [(_BUILDINGS[kind], kind) for kind in kinds if kind in _BUILDINGS]
    if heights:
        height, kind = max(heights)
        return kind.replace("_", " "), float(height)
    if kinds and all(kind in _LOW_BUILDINGS for kind in kinds):
        return "small building", 12.0
    return "building", 20.0


def is_turbine(tags: Mapping[str, str]) -> bool:
    if keys_of(tags, Means.HUB, Means.ROTOR, Means.BLADE):
        return True
    return tags.get("generator:source") == "wind" or "wind_turbine" in (
        tags.get("generator:method"), tags.get("man_made"), tags.get("power")
    )  # fmt: skip


Length = Annotated[float, Field(gt=0, strict=True)]
Height = Annotated[float, Field(ge=0, strict=True)]


class BuildingRules(BaseModel):
    """Rules for features whose tags give no size. A height of 0 means no obstacle."""

    model_config = ConfigDict(frozen=True, defer_build=True)

    take: Literal["tagged", "all"] | None = None
    """`all`: every feature is an obstacle, except roads, land use and the like without a height. `tagged`: only
    features tagged as building, mast, tree or power line, or with a height. Default: as `tagged`, but a file of
    buildings only is taken whole."""
    height_key: str = "height"
    """Property with the height of the top above the ground [m, or feet if stated]."""
    default_height: Length | None = None
    """Height of a building without height and storeys [m]. Default: by its kind."""
    storey_height: Length = 3.0
    """Height of a storey if only the number of storeys is known [m]."""
    point_height: Length | None = None
    """Height of a mast, tree or other point without one [m]. Default: by its kind."""
    point_radius: Length | None = None
    """Radius of a mast, tree or other point, and half width of a wall [m]. Default: by its kind."""
    line_height: Height | None = None
    """Height of a power or telephone line without one [m]; 0 excludes lines. Default: by its voltage."""
    aerialway_height: Height = 40.0
    """Height of a cable car, lift or zip line without one [m], at most 15 m for drag lifts; 0 excludes them."""
    wood_height: Height | None = None
    """Height of a wood or orchard without one [m]; 0 excludes them. Default: no flight may be near one."""


def area_height(tags: Mapping[str, str], rules: BuildingRules) -> tuple[str, float]:
    if rules.wood_height is not None and is_tagged(tags, WOODS) and "building" not in tags:
        return "wood", rules.wood_height
    if "building" not in tags and "building:part" not in tags and (is_tagged(tags, TALL) or is_bridge(tags)):
        return thin_height(tags, rules)
    kind, height = building_height(tags)
    return kind, height if rules.default_height is None else rules.default_height


def thin_height(tags: Mapping[str, str], rules: BuildingRules) -> tuple[str, float]:
    size = size_of(tags)
    return size.kind, size.height if rules.point_height is None else rules.point_height


def reach_of(
    tags: Mapping[str, str], rules: BuildingRules, part: Any, top: float, odd: Odd
) -> tuple[float, str | None]:
    """Rotor blades end above the ground."""
    size = size_of(tags)
    is_point = part.geom_type == "Point"
    usual = size.radius if rules.point_radius is None else rules.point_radius
    if size is OTHER and is_point and rules.point_radius is None and math.isfinite(top):
        usual = min(max(usual, 0.2 * top), 10.0)
    if is_turbine(tags) and rules.point_radius is None:
        hubs = [hub for key in keys_of(tags, Means.HUB) if (hub := length_of(tags[key])[0])]
        usual = min(usual, top / 2, *(max(top - hub, 0.0) or usual for hub in hubs))
    width = width_of(tags, odd, is_tree=tags.get("natural") in TALL["natural"])
    lengths = [length for key in keys_of(tags, Means.LENGTH) if (length := read_length(tags, key, odd))]
    if is_point and width is not None and lengths:
        width = math.hypot(width, *lengths)
    if width is not None:
        return width / 2, None
    dimension = "a radius" if is_point else "a half width"
    return usual, f"{size.kind}(s) without a width, given {dimension} of {usual:.2g} m"


@dataclass(frozen=True)
class Wire:
    """Height and half width [m], and the key that changes the height."""

    words: str
    height: float
    reach: float
    key: str


def wire_of(tags: Mapping[str, str], rules: BuildingRules) -> Wire | None:
    """Return a power line or aerialway: its obstacle is a wall, since nothing flies under a rope."""
    if WIRES.keys().isdisjoint(tags):
        return None
    lift = tags.get("aerialway")
    kind = tags.get("power")
    if lift in DRAG_LIFTS:
        return Wire("drag lift(s)", min(rules.aerialway_height, 15.0), 5.0, "aerialway_height")
    if lift in WIRES["aerialway"]:
        return Wire("aerialway(s)", rules.aerialway_height, 5.0, "aerialway_height")  # half width with cabins
    if kind in WIRES["power"]:
        volts = volts_of(tags.get("voltage", ""))
        words = f"power line(s) of {'unknown voltage' if volts is None else f'{volts / 1000:g} kV'}"
        most = (math.inf if kind == "line" else 60e3) if volts is None else volts
    elif "line" in (tags.get("communication"), tags.get("telecom")):
        words = "telephone line(s)"
        most = 1e3
    else:
        return None
    # up to [V], height and half width [m]
    sizes = ((1e3, 10.0, 2.0), (60e3, 15.0, 3.0), (150e3, 40.0, 8.0), (300e3, 50.0, 12.0), (math.inf, 60.0, 16.0))
    height, reach = next((height, reach) for volts, height, reach in sizes if most <= volts)
    return Wire(words, height if rules.line_height is None else rules.line_height, reach, "line_height")


def volts_of(text: str) -> float | None:
    """Return the highest voltage ("110000", "380000;110000", "20 kV") [V]; None if any is unknown."""
    texts = [part for part in text.lower().replace(" ", "").split(";") if part]
    parts = [re.fullmatch(r"(\d{1,7}(?:\.\d{1,3})?)(k?)v?", text) for text in texts]
    volts = [float(part[1]) * (1000.0 if part[2] else 1.0) for part in parts if part]
    return max(volts, default=None) if all(parts) else None
