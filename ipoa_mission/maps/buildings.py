"""Which features of a map stand in the way, and as which obstacles: buildings, masts, trees, walls with a height.

What has no height of its own gets a default one; how many did is told, as is all that was mended. What is passed over
is kept with its place and reason.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.feature import Feature, Mistakes
from ipoa_mission.maps.heights import foot_of, height_of, meters
from ipoa_mission.maps.kinds import TOP_AMSL, Reason, are_all_buildings, as_openstreetmap, why_passed_over
from ipoa_mission.maps.passed import FAR, PassedOver, passed_over
from ipoa_mission.maps.planar import polygons_of, to_plane
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.polygon import rings_of

LEAST_HEIGHT = 0.1  # what stands is at least so high [m]


@dataclass(frozen=True)
class BuildingRules:
    """How features become obstacles where their tags leave it open, all in metres.

    `height_key` is the property that holds the height. `take` is `all` for every feature whatever its tags, `tagged`
    for what tags call a thing that stands, the rest being nothing; None takes a file of nothing but buildings whole.
    """

    default_height: float = 8.0
    storey_height: float = 3.0
    point_height: float = 20.0
    point_radius: float = 2.0
    height_key: str = "height"
    take: Literal["tagged", "all"] | None = None


@dataclass(frozen=True)
class Standing:
    """Something that stands on the ground: `shape` is local, east, north [m]; `reach` widens a point or line.

    It fills the air from `foot` above the lowest ground under it to `height` above the highest, or above home where
    `over_home`.
    """

    name: str
    shape: Any
    reach: float
    foot: float
    height: float
    over_home: bool = False


@dataclass(frozen=True)
class Buildings:
    """What a map has: what stands in the way, what is passed over, and remarks on what was assumed or mended."""

    standing: tuple[Standing, ...]
    passed_over: tuple[PassedOver, ...]
    remarks: tuple[str, ...]


def find_buildings(features: Sequence[Feature], rules: BuildingRules, frame: LocalFrame, path: Path) -> Buildings:
    """The features of the map `path` in the local frame, each either standing or passed over.

    Raises:
        BadInput: naming file and place of each feature that makes no sense, or that all are far away.
    """
    features = [as_openstreetmap(feature) for feature in features]
    shapes, near = to_plane([f.shape for f in features], [f.place for f in features], frame)
    every = rules.take is None and are_all_buildings(features, rules.height_key)
    counts: Counter[str] = Counter()
    mistakes = Mistakes()
    standing: list[Standing] = []
    passed: list[PassedOver] = []
    for feature, shape, counted in zip(features, shapes, near, strict=True):
        why = _why_passed_over(feature, rules, every) if counted else FAR
        if why is None:
            standings = mistakes.attempt(_standings, feature, shape, rules, counts) or []
            standing += [_over_home(s, feature, frame) for s in standings]
        else:
            passed.append(passed_over(feature, shape, why, path))
    mistakes.tell()
    remarks = (f"{count} {words.replace('(s)', '' if count == 1 else 's')}" for words, count in counts.items())
    return Buildings(tuple(standing), tuple(passed), tuple(remarks))


def raise_buildings(standing: Sequence[Standing], ground: Ground) -> tuple[Obstacle, ...]:
    """The obstacles themselves, standing on the ground."""
    if not standing:
        return ()
    outlines = [_outline(s) for s in standing]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest, highest = np.minimum.reduceat(heights, first), np.maximum.reduceat(heights, first)
    return tuple(
        _obstacle(
            s, float(low) + s.foot, max(s.height if s.over_home else float(high) + s.height, float(low) + LEAST_HEIGHT)
        )
        for s, low, high in zip(standing, lowest, highest, strict=True)
    )


def _over_home(standing: Standing, feature: Feature, frame: LocalFrame) -> Standing:
    """The same, as high as the file says above mean sea level, if it does."""
    if TOP_AMSL not in feature.tags:
        return standing
    top = meters(feature.tags[TOP_AMSL], f"{feature.place}.properties.{TOP_AMSL}")
    return replace(standing, height=top - frame.home.altitude, over_home=True)


def _why_passed_over(feature: Feature, rules: BuildingRules, every: bool) -> Reason | None:
    why = why_passed_over(feature, rules.height_key, every)
    if why is None or (rules.take == "all" and not shapely.is_empty(feature.shape)):
        return None
    return Reason(why.words, why.may_stand and rules.take is None)


def _standings(feature: Feature, shape: Any, rules: BuildingRules, counts: Counter[str]) -> list[Standing]:
    """One obstacle for each part of the feature's shape."""
    place = f"{feature.place}.properties"
    height = height_of(feature.tags, place, rules.height_key, rules.storey_height)
    if TOP_AMSL in feature.tags:
        height = math.inf  # told by sea level
    foot = foot_of(feature.tags, place, rules.storey_height)
    if height is not None and foot >= height:
        counts["building(s) whose min_height is not below the height, taken to stand on the ground"] += 1
        foot = 0.0
    made = []
    building = bool(feature.tags.keys() & {"building", "building:part"})
    hollow = not building and feature.tags.keys() & {"barrier", "natural"}
    for part in _parts(shape, not hollow):
        thin = part.geom_type != "Polygon"
        if height is None:
            default = rules.point_height if thin else rules.default_height
            counts[f"{'point(s) or line(s)' if thin else 'building(s)'} without a height, given {default:g} m"] += 1
        top = height if height is not None else foot + default
        if thin:
            if building and rules.take != "all":
                raise BadInput(
                    f"{feature.place}.geometry: expected the outline of a building, not a {part.geom_type}",
                    hint="export whole outlines (`out geom` in Overpass turbo), not centers",
                )
            made.append(Standing(feature.name, part, _reach(feature, place, rules), foot, top))
            continue
        polygons, wrong = polygons_of(part, feature.place)
        if wrong is not None:
            counts[f"outline(s) mended ({wrong})"] += 1
        made += [Standing(feature.name, polygon, 0.0, foot, top) for polygon in polygons]
    return made


def _parts(shape: Any, filled: bool) -> Iterator[Any]:
    """Polygons, points and lines of a shape; where it is filled, a closed line is an outline."""
    for part in shapely.get_parts(shape):
        if hasattr(part, "geoms"):
            yield from _parts(part, filled)
        elif filled and part.geom_type == "LineString" and part.is_closed and len(part.coords) > 3:
            yield shapely.Polygon(part)
        else:
            yield part


def _reach(feature: Feature, place: str, rules: BuildingRules) -> float:
    """Radius of a point, or half the width of a line [m]."""
    for key in ("diameter", "diameter_crown", "width"):
        if key in feature.tags:
            return meters(feature.tags[key], f"{place}.{key}") / 2 or rules.point_radius
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
