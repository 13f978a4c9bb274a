"""Which features of a map stand in the way, and as which obstacles: buildings, masts, trees, walls with a height.

What has no height of its own gets a default one; how many did is told, as is all that was mended or passed over.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Vector
from ipoa_mission.maps.feature import Feature, Mistakes
from ipoa_mission.maps.heights import foot_of, height_of, metres
from ipoa_mission.maps.planar import polygons_of, rings_of, to_plane
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism

Ground: TypeAlias = Callable[[NDArray[np.float64]], Vector]  # height under points (n, 2), (n,) [m]

#: Values of `building` and `building:part` that say that there is none.
NO_BUILDING = {"no", "entrance", "demolished", "razed", "proposed", "construction_site"}
#: What is tall by nature, whether or not its height is known.
TALL = {
    "man_made": {
        "antenna", "chimney", "communications_tower", "cooling_tower", "crane", "flagpole", "gasometer", "lighthouse",
        "mast", "monitoring_station", "obelisk", "silo", "storage_tank", "telescope", "tower", "utility_pole",
        "water_tower", "windmill",
    },
    "natural": {"tree", "tree_row"},
    "power": {"tower", "pole", "portal", "terminal"},
    "generator:source": {"wind"},
    "aerialway": {"pylon"},
    "highway": {"street_lamp"},
    "advertising": {"column", "totem"},
}  # fmt: skip
#: Lines in the air: no obstacle unless their height is known, but worth a warning.
WIRES = {"power": {"line", "minor_line", "cable"}, "aerialway": {"cable_car", "gondola", "chair_lift", "zip_line"}}


@dataclass(frozen=True)
class BuildingRules:
    """How features become obstacles where their tags leave it open, all in metres.

    `height_key` is the property that holds the height. `everything` takes every feature, whatever its tags.
    """

    default_height: float = 8.0
    storey_height: float = 3.0
    point_height: float = 20.0
    point_radius: float = 2.0
    height_key: str = "height"
    everything: bool = False


@dataclass(frozen=True)
class Standing:
    """Something that stands on the ground: `shape` is local, east, north [m]; `reach` widens a point or line.

    It fills the air from `foot` above the lowest ground under it to `height` above the highest.
    """

    name: str
    shape: Any
    reach: float
    foot: float
    height: float


def find_buildings(
    features: Sequence[Feature], rules: BuildingRules, frame: LocalFrame
) -> tuple[tuple[Standing, ...], tuple[str, ...]]:
    """What stands in the way, in the local frame, and remarks on what was assumed, mended or passed over.

    Raises:
        BadInput: naming file and place of each feature that makes no sense.
    """
    taken = [feature for feature in features if rules.everything or _stands(feature, rules)]
    wires = [feature for feature in features if _tagged(feature, WIRES) and not _stands(feature, rules)]
    shapes = to_plane([f.shape for f in taken], [f.place for f in taken], frame)
    counts: Counter[str] = Counter()
    mistakes = Mistakes()
    found = [
        mistakes.attempt(_standings, feature, shape, rules, counts)
        for feature, shape in zip(taken, shapes, strict=True)
    ]
    mistakes.tell()
    return tuple(s for several in found if several for s in several), tuple(
        _remarks(counts, [] if rules.everything else wires)
    )


def raise_buildings(standing: Sequence[Standing], ground: Ground) -> tuple[Obstacle, ...]:
    """The obstacles themselves, standing on the ground."""
    if not standing:
        return ()
    outlines = [_outline(s) for s in standing]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest, highest = np.minimum.reduceat(heights, first), np.maximum.reduceat(heights, first)
    return tuple(
        _obstacle(s, float(low) + s.foot, float(high) + s.height)
        for s, low, high in zip(standing, lowest, highest, strict=True)
    )


def _stands(feature: Feature, rules: BuildingRules) -> bool:
    tags = feature.tags
    if tags.get("location") == "underground" or tags.get("tunnel", "no") != "no":
        return False
    said = [tags[key] for key in ("building", "building:part") if key in tags]
    if said:
        return any(value not in NO_BUILDING for value in said)
    return rules.height_key in tags or "building:levels" in tags or _tagged(feature, TALL)


def _tagged(feature: Feature, kinds: dict[str, set[str]]) -> bool:
    return any(feature.tags.get(key) in values for key, values in kinds.items())


def _standings(feature: Feature, shape: Any, rules: BuildingRules, counts: Counter[str]) -> list[Standing]:
    """One obstacle for each part of the feature's shape."""
    place = f"{feature.place}.properties"
    height = height_of(feature.tags, place, rules.height_key, rules.storey_height)
    foot = foot_of(feature.tags, place, rules.storey_height)
    if height is not None and foot >= height:
        counts["building(s) whose min_height is not below the height, taken to stand on the ground"] += 1
        foot = 0.0
    made = []
    building = bool(feature.tags.keys() & {"building", "building:part"})
    for part in _parts(shape, building):
        thin = part.geom_type != "Polygon"
        if height is None:
            default = rules.point_height if thin else rules.default_height
            counts[f"{'point(s) or line(s)' if thin else 'building(s)'} without a height, given {default:g} m"] += 1
        top = height if height is not None else foot + default
        if thin:
            if building and not rules.everything:
                raise BadInput(
                    f"{feature.place}.geometry: expected the outline of a building, not a {part.geom_type}",
                    hint="export whole outlines (`out geom` in Overpass turbo), not centres",
                )
            made.append(Standing(feature.name, part, _reach(feature, place, rules), foot, top))
            continue
        polygons, wrong = polygons_of(part, feature.place)
        if wrong is not None:
            counts[f"outline(s) mended ({wrong})"] += 1
        made += [Standing(feature.name, polygon, 0.0, foot, top) for polygon in polygons]
    return made


def _parts(shape: Any, building: bool) -> Iterator[Any]:
    """Polygons, points and lines of a shape; the closed line of a building is its outline."""
    for part in shapely.get_parts(shape):
        if hasattr(part, "geoms"):
            yield from _parts(part, building)
        elif building and part.geom_type == "LineString" and part.is_closed and len(part.coords) > 3:
            yield shapely.Polygon(part)
        else:
            yield part


def _reach(feature: Feature, place: str, rules: BuildingRules) -> float:
    """Radius of a point, or half the width of a line [m]."""
    for key in ("diameter", "diameter_crown", "width"):
        if key in feature.tags:
            return metres(feature.tags[key], f"{place}.{key}") / 2 or rules.point_radius
    return rules.point_radius


def _outline(s: Standing) -> NDArray[np.float64]:
    """Places under it at which the ground is asked, (n, 2)."""
    corners = shapely.get_coordinates(s.shape)
    if s.reach > 0:
        around = s.reach * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        return np.asarray((corners[:, None, :] + around).reshape(-1, 2))
    return np.vstack([corners, shapely.get_coordinates(s.shape.centroid)])


def _obstacle(s: Standing, base: float, top: float) -> Obstacle:
    if s.shape.geom_type == "Point":
        return Cylinder(s.name, float(s.shape.x), float(s.shape.y), s.reach, base, top)
    shape = s.shape.buffer(s.reach, cap_style="square", join_style="mitre") if s.reach > 0 else s.shape
    return Prism(s.name, *rings_of(shape), base, top)


def _remarks(counts: Counter[str], wires: Sequence[Feature]) -> Iterator[str]:
    for words, count in counts.items():
        yield f"{count} {words.replace('(s)', '' if count == 1 else 's')}"
    if wires:
        named = ", ".join(feature.name for feature in wires[:3]) + (", ..." if len(wires) > 3 else "")
        which = "1 overhead line has" if len(wires) == 1 else f"{len(wires)} overhead lines have"
        yield f"{which} no height and cannot be avoided: {named}"
