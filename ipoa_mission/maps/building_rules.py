"""Rules that make map features obstacles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ipoa_mission.maps.defaults import OTHER, TREES, building_height, is_turbine, size_of
from ipoa_mission.maps.keys import Means, keys_of
from ipoa_mission.maps.kinds import TALL, WOODS, is_bridge, tagged
from ipoa_mission.maps.lengths import length_of
from ipoa_mission.maps.tag_heights import Odd, width_of

RADIUS_RATIO, LARGEST_RADIUS = 0.2, 10.0  # of a point of unknown kind [m]


@dataclass(frozen=True)
class BuildingRules:
    """Rules for features whose tags give no size [m].

    `take`: `all` features not tagged as flat, or `tagged` ones; None: `all` in a file with buildings only. Sizes of
    None depend on the kind. Without `wood_height`, woods are possible obstacles. A height of 0 means no obstacle.
    """

    default_height: float | None = None
    storey_height: float = 3.0
    point_height: float | None = None
    point_radius: float | None = None
    line_height: float | None = None
    aerialway_height: float = 40.0
    wood_height: float | None = None
    height_key: str = "height"
    take: Literal["tagged", "all"] | None = None


def area_height(tags: Mapping[str, str], rules: BuildingRules) -> tuple[str, float]:
    if rules.wood_height is not None and tagged(tags, WOODS) and "building" not in tags:
        return "wood", rules.wood_height
    if "building" not in tags and "building:part" not in tags and (tagged(tags, TALL) or is_bridge(tags)):
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
    size, is_point = size_of(tags), part.geom_type == "Point"
    usual = size.radius if rules.point_radius is None else rules.point_radius
    if size is OTHER and is_point and rules.point_radius is None and math.isfinite(top):
        usual = min(max(usual, top * RADIUS_RATIO), LARGEST_RADIUS)
    if is_turbine(tags) and rules.point_radius is None:
        hubs = [hub for key in keys_of(tags, Means.HUB) if (hub := length_of(tags[key])[0])]
        usual = min(usual, top / 2, *(max(top - hub, 0.0) or usual for hub in hubs))
    width = width_of(tags, odd, is_tree=tags.get("natural") in TREES)
    lengths = [length for key in keys_of(tags, Means.LENGTH) if (length := length_of(tags[key])[0])]
    if is_point and width is not None and lengths:
        width = math.hypot(width, *lengths)
    if width is not None:
        return width / 2, None
    what = "a radius" if is_point else "a half width"
    return usual, f"{size.kind}(s) without a width, given {what} of {usual:.2g} m"
