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
from ipoa_mission.maps.heights import Odd, foot_of, height_of, meters, width_of
from ipoa_mission.maps.kinds import (
    CABLE,
    FLAT,
    TOP_AMSL,
    WOOD,
    WOODS,
    Extent,
    Reason,
    are_all_buildings,
    as_openstreetmap,
    extents_of,
    tagged,
    why_passed_over,
)
from ipoa_mission.maps.passed import FAR, MOST_NAMED, PassedOver, passed_over
from ipoa_mission.maps.planar import clean_polygons, polygons_of, to_plane
from ipoa_mission.maps.wires import Wire, raise_span, spans, wire_of
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.polygon import rings_of

LEAST_HEIGHT = 0.1  # what stands is at least so high [m]


@dataclass(frozen=True)
class BuildingRules:
    """How features become obstacles where their tags leave it open, all in metres.

    `height_key` is the property that holds the height. `take` is `all` for every feature that its tags do not call
    flat, `tagged` for what tags call a thing that stands, the rest being nothing; None takes a file of nothing but
    buildings whole. A height of 0 says that such things are nothing; a `line_height` of None is by the voltage, and
    without a `wood_height` a wood may stand.
    """

    default_height: float = 8.0
    storey_height: float = 3.0
    point_height: float = 20.0
    point_radius: float = 2.0
    line_height: float | None = None
    aerialway_height: float = 40.0
    wood_height: float | None = None
    height_key: str = "height"
    take: Literal["tagged", "all"] | None = None


@dataclass(frozen=True, slots=True)
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
    hangs: bool = False  # `shape` is a span of a wire between two supports


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
    drawn = [f.shape for f in features]
    shapes, near = to_plane(drawn, [f.place for f in features], frame)
    every = rules.take is None and are_all_buildings(features, rules.height_key)
    counts: Counter[str] = Counter()
    odd: list[str] = []
    mistakes = Mistakes()
    standing: list[Standing] = []
    passed: list[PassedOver] = []
    each = zip(features, extents_of(drawn), *clean_polygons(shapes), near.tolist(), strict=True)
    for feature, extent, shape, sound, counted in each:
        why = _why_passed_over(feature, extent, rules, every) if counted else FAR
        if why is None:
            standings = mistakes.attempt(_standings, feature, shape, sound, rules, counts, odd) or []
            standing += [_over_home(s, feature, frame) for s in standings]
        else:
            passed.append(passed_over(feature, shape, why, path))
    mistakes.tell()
    remarks = [f"{count} {words.replace('(s)', '' if count == 1 else 's')}" for words, count in counts.items()]
    if odd:
        of = f"{len(odd)} tag{'s' if len(odd) > 1 else ''} that cannot be read, taken as left out"
        remarks.append(f"{of}: {', '.join(odd[:MOST_NAMED])}{', ...' if len(odd) > MOST_NAMED else ''}")
    return Buildings(tuple(standing), tuple(passed), tuple(remarks))


def raise_buildings(standing: Sequence[Standing], ground: Ground) -> tuple[Obstacle, ...]:
    """The obstacles themselves, standing on the ground."""
    hanging = [prism for s in standing if s.hangs for prism in raise_span(s.name, s.shape, s.reach, s.height, ground)]
    standing = [s for s in standing if not s.hangs]
    if not standing:
        return tuple(hanging)
    outlines = [_outline(s) for s in standing]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest, highest = np.minimum.reduceat(heights, first), np.maximum.reduceat(heights, first)
    raised = (
        _obstacle(
            s, float(low) + s.foot, max(s.height if s.over_home else float(high) + s.height, float(low) + LEAST_HEIGHT)
        )
        for s, low, high in zip(standing, lowest, highest, strict=True)
    )
    return (*raised, *hanging)


def _over_home(standing: Standing, feature: Feature, frame: LocalFrame) -> Standing:
    """The same, as high as the file says above mean sea level, if it does."""
    if TOP_AMSL not in feature.tags:
        return standing
    top = meters(feature.tags[TOP_AMSL], f"{feature.place}.properties.{TOP_AMSL}")
    return replace(standing, height=top - frame.home.altitude, over_home=True)


def _why_passed_over(feature: Feature, extent: Extent, rules: BuildingRules, every: bool) -> Reason | None:
    why = why_passed_over(feature, extent, rules.height_key, every)
    if why is None:
        wire = None if rules.height_key in feature.tags else _wire(feature, rules)
        return (
            Reason(f"{wire.key} = 0 says that it is nothing", False) if wire is not None and not wire.height else None
        )
    if why is CABLE and rules.line_height is not None:
        return None if rules.line_height else Reason("line_height = 0 says that it is nothing", False)
    if why is WOOD and rules.wood_height is not None:
        return None if rules.wood_height else Reason("wood_height = 0 says that it is nothing", False)
    if rules.take == "all" and why not in (FLAT, WOOD, CABLE) and extent != "none":
        return None
    settled = rules.take == "tagged" or (rules.take == "all" and why not in (WOOD, CABLE))
    return replace(why, may_stand=why.may_stand and not settled)


def _wire(feature: Feature, rules: BuildingRules) -> Wire | None:
    return wire_of(feature.tags, rules.line_height, rules.aerialway_height)


def _standings(
    feature: Feature, shape: Any, sound: bool, rules: BuildingRules, counts: Counter[str], unread: list[str]
) -> list[Standing]:
    """One obstacle for each part of the feature's shape; tags that cannot be read are named in `unread`.

    A `sound` shape is one polygon that needs no mending.
    """

    def odd(key: str, value: str) -> None:
        unread.append(f"{feature.name} ({key} {value[:20]!r})")

    height = height_of(feature.tags, rules.height_key, rules.storey_height, odd)
    if TOP_AMSL in feature.tags:
        height = math.inf  # told by sea level
    foot = foot_of(feature.tags, rules.storey_height, odd)
    if height is not None and foot >= height:
        counts["building(s) whose min_height is not below the height, taken to stand on the ground"] += 1
        foot = 0.0
    wire = None if TOP_AMSL in feature.tags else _wire(feature, rules)
    if wire is not None and (hanging := list(spans(shape))):
        if height is None:
            counts[f"{wire.words} without a height, given {wire.height:g} m ({wire.key})"] += 1
        top, reach = wire.height if height is None else height, _reach(feature, wire.reach, odd)
        return [Standing(feature.name, span, reach, 0.0, top, hangs=True) for span in hanging]
    made = []
    building = bool(feature.tags.keys() & {"building", "building:part"})
    hollow = not building and feature.tags.keys() & {"barrier", "natural"}
    for part in [shape] if sound else _parts(shape, not hollow):
        thin = part.geom_type != "Polygon"
        if height is None:
            kind, default = ("point(s) or line(s)", rules.point_height) if thin else _area(feature, rules)
            counts[f"{kind} without a height, given {default:g} m"] += 1
        top = height if height is not None else foot + default
        if thin:
            if building and rules.take != "all":
                raise BadInput(
                    f"{feature.place}.geometry: expected the outline of a building, not a {part.geom_type}",
                    hint="export whole outlines (`out geom` in Overpass turbo), not centers",
                )
            made.append(Standing(feature.name, part, _reach(feature, rules.point_radius, odd), foot, top))
            continue
        polygons, wrong = ([part], None) if sound else polygons_of(part, feature.place)
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


def _area(feature: Feature, rules: BuildingRules) -> tuple[str, float]:
    """What an area of no height is called, and how high it is taken to be [m]."""
    is_wood = rules.wood_height is not None and tagged(feature.tags, WOODS) and "building" not in feature.tags
    return ("wood(s)", float(rules.wood_height or 0.0)) if is_wood else ("building(s)", rules.default_height)


def _reach(feature: Feature, usual: float, odd: Odd) -> float:
    """Radius of a point, or half the width of a line [m]."""
    width = width_of(feature.tags, odd)
    return usual if width is None else width / 2


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
