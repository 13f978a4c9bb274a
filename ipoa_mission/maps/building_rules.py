"""What a scenario says of how the features of a map become obstacles, and how high and wide those are without tags."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ipoa_mission.maps.defaults import OTHER, TREES, building_height, is_turbine, size_of
from ipoa_mission.maps.keys import Means, those
from ipoa_mission.maps.kinds import TALL, WOODS, is_bridge, tagged
from ipoa_mission.maps.lengths import length_of
from ipoa_mission.maps.tag_heights import Odd, width_of

WIDE, WIDEST = 0.2, 10.0  # a point of unknown kind has a fifth of its height as radius, up to so much [m]


@dataclass(frozen=True)
class BuildingRules:
    """How features become obstacles where their tags leave it open, all in metres.

    `height_key` is the property that holds the height. `take` is `all` for every feature that its tags do not call
    flat, `tagged` for what tags call a thing that stands, the rest being nothing; None takes a file of nothing but
    buildings whole. Heights and radii of None are by the kind of the thing. A height of 0 says that such things are
    nothing; a `line_height` of None is by the voltage, and without a `wood_height` a wood may stand.
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
    """What an area of no height is called, and how high it is taken to be [m]."""
    if rules.wood_height is not None and tagged(tags, WOODS) and "building" not in tags:
        return "wood", rules.wood_height
    if "building" not in tags and "building:part" not in tags and (tagged(tags, TALL) or is_bridge(tags)):
        return thin_height(tags, rules)
    kind, height = building_height(tags)
    return kind, height if rules.default_height is None else rules.default_height


def thin_height(tags: Mapping[str, str], rules: BuildingRules) -> tuple[str, float]:
    """What a point or line of no height is called, and how high it is taken to be [m]."""
    size = size_of(tags)
    return size.kind, size.height if rules.point_height is None else rules.point_height


def reach_of(
    tags: Mapping[str, str], rules: BuildingRules, part: Any, top: float, odd: Odd
) -> tuple[float, str | None]:
    """Radius of a point, or half the width of a line [m], and words about it where no tag says it.

    The blades of a wind turbine end above the ground; a high thing of unknown kind is wider than a low one.
    """
    size, is_point = size_of(tags), part.geom_type == "Point"
    usual = size.radius if rules.point_radius is None else rules.point_radius
    if size is OTHER and is_point and rules.point_radius is None and math.isfinite(top):
        usual = min(max(usual, top * WIDE), WIDEST)
    if is_turbine(tags) and rules.point_radius is None:
        hubs = [hub for key in those(tags, Means.HUB) if (hub := length_of(tags[key])[0])]
        usual = min(usual, top / 2, *(max(top - hub, 0.0) or usual for hub in hubs))
    width = width_of(tags, odd, is_tree=tags.get("natural") in TREES)
    lengths = [length for key in those(tags, Means.LENGTH) if (length := length_of(tags[key])[0])]
    if is_point and width is not None and lengths:
        width = math.hypot(width, *lengths)
    if width is not None:
        return width / 2, None
    what = "a radius" if is_point else "half a width"
    return usual, f"{size.kind}(s) without a width, given {what} of {usual:.2g} m"
