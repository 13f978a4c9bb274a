"""Find the obstacles of a map, and raise them on the ground."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.errors import InvalidRing
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Vector, places_under
from ipoa_mission.ground import Ground
from ipoa_mission.maps import kinds
from ipoa_mission.maps.building_rules import BuildingRules, area_height, reach_of, thin_height, volts_of, wire_of
from ipoa_mission.maps.feature import Feature, Mistakes, make_printable
from ipoa_mission.maps.keys import Means, meaning
from ipoa_mission.maps.lengths import length_of, meters
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.map_window import Box, MapWindow
from ipoa_mission.maps.passed import FAR_FROM_HOME, MOST_NAMED, NOT_READ, MapNotes, PassedOver
from ipoa_mission.maps.planar import close_as_polygon, polygons_of, simple_parts, spans, to_plane
from ipoa_mission.maps.tag_heights import foot_of, height_of, is_by_storeys, unread_heights, unused_numbers, width_of
from ipoa_mission.unread import Unread
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism
from ipoa_mission.world.polygon import rings_of

# Unreadable values may hide a greater height.
HEIGHTENING = (Means.TOP, Means.LEVELS, Means.MAX_LEVEL, Means.HUB, Means.ROOF, Means.ROOF_LEVELS, Means.ROTOR)
FAR_BELOW_HOME = 30.0  # [m]


def name_for_pilot(feature: Feature, shape: Any) -> str:
    """Name a feature for a pilot: by name or address, else by kind, position and number; `shape` is east, north [m].

    >>> name_for_pilot(Feature("town.geojson: features[3]", None, {"natural": "tree"}), shapely.Point(30.0, 30.0))
    'tree 42 m NE of home (features[3])'
    """
    tags = feature.tags
    if tags.get("name") or tags.get("addr:housename"):
        return feature.name
    street = tags.get("addr:street")
    number = tags.get("addr:housenumber")
    if "building" in tags and street and number:
        return make_printable(f"{_kind(tags)}, {street} {number}")
    return make_printable(f"{_kind(tags)}{_from_home(shape)} ({feature.name.rpartition(': ')[2]})")


def _from_home(shape: Any) -> str:
    if shapely.is_empty(shape) or shapely.get_dimensions(shape) == 1:
        return ""
    east, north = shape.centroid.coords[0]
    side = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")[round(math.atan2(east, north) / (math.pi / 4)) % 8]
    return f" {math.hypot(east, north):.0f} m {side} of home"


def _kind(tags: Mapping[str, str]) -> str:
    if tags.get("power", "").endswith("line") or tags.get("power") == "cable":
        volts = volts_of(tags.get("voltage", ""))
        return f"{volts / 1000:g} kV line" if volts else "power line"
    if tags.get("generator:source") == "wind":
        return "wind turbine"
    for key in ("building", "man_made", "aerialway", "barrier", "power", "natural", "landuse"):
        value = tags.get(key, "no")
        if key == "power" and value in ("tower", "pole"):
            return f"power {value}"
        if value not in ("", "yes", "no"):
            return "row of trees" if value == "tree_row" else value.replace("_", " ")
    return "building"


class MapObstacle(NamedTuple):
    """`shape` is east, north [m]; `reach` widens a point or line.

    It reaches from `foot` above the lowest ground under it to `height` above the highest, at least to `least_top` above
    home.
    """

    name: str
    shape: Any
    reach: float
    foot: float
    height: float
    least_top: float = -math.inf
    hangs: bool = False  # a span between supports
    called: str = ""  # for messages


class Buildings(NamedTuple):
    """Obstacles and passed-over features of a map; `features` were examined, `elsewhere` not."""

    obstacles: tuple[MapObstacle, ...]
    passed_over: tuple[PassedOver, ...]
    remarks: tuple[str, ...]
    features: int
    elsewhere: int
    unread: tuple[Unread, ...]


def search_buildings(path: Path, rules: BuildingRules, frame: LocalFrame, within: Box | None = None) -> Buildings:
    """Return the obstacles of a map, `within` a box [m]."""
    around = MapWindow.of(frame, within)
    features = [kinds.as_openstreetmap(feature) for feature in read_features(path, around)]
    has_heights = any(kinds.has_place_for_height(feature, rules.height_key) for feature in features)
    all_buildings = rules.take is None and has_heights and not any(kinds.has_kind(feature) for feature in features)
    return _Finder(rules, frame, path, all_buildings).find(features, around)


class _Finder:
    def __init__(self, rules: BuildingRules, frame: LocalFrame, path: Path, all_buildings: bool) -> None:
        self._rules = rules
        self._all_buildings = all_buildings
        self._notes = MapNotes(frame, path)
        self._mistakes = Mistakes()
        self._counts = Counter[str]()  # by remark
        self._odd_tags = list[str]()
        self._obstacles = list[MapObstacle]()
        self._supports = dict[tuple[float, ...], float]()  # by place
        self._unused_keys = dict[str, None]()
        self._standing: shapely.STRtree | None = None  # what may have others on its roof

    def find(self, features: Sequence[Feature], around: MapWindow) -> Buildings:
        shapes, near = to_plane([feature.shape for feature in features], self._notes.frame, around)
        rows = zip(features, shapes, near.tolist(), strict=True)
        for feature, shape, is_near in sorted(rows, key=lambda row: kinds.is_on_roof(row[0].tags)):  # these last
            extent = kinds.extent_of(feature.shape)
            why = _why_passed_over(feature, extent, self._rules, self._all_buildings) if is_near else FAR_FROM_HOME
            if self._misses(feature, extent) and extent == "none":
                continue
            if why is not None:
                self._notes.pass_over(feature, shape, why)
                continue
            parts = self._mistakes.attempt(self._stand, feature, shape) or ()
            self._note_low_drawing(feature, parts)
            self._obstacles += [self._as_drawn(part, feature, name_for_pilot(feature, shape)) for part in parts]
        around.expect_near(self._notes.path)
        self._mistakes.raise_all()
        obstacles = tuple(self._between_supports(part) if part.hangs else part for part in self._obstacles)
        elsewhere = around.elsewhere
        remarks = [f"{n} {words.replace('(s)', '' if n == 1 else 's')}" for words, n in self._counts.items()]
        if self._odd_tags:
            count = len(self._odd_tags)
            tags = f"{count} tag{'s' if count > 1 else ''} that cannot be read, ignored"
            remarks.append(f"{tags}: {', '.join(self._odd_tags[:MOST_NAMED])}{', ...' if count > MOST_NAMED else ''}")
        if self._unused_keys:
            keys = ", ".join([*self._unused_keys][:10])
            remarks.append(f"numbers of things without a height, not read: {keys}")
        if elsewhere:
            remarks.append(f"{elsewhere} thing{'s' if elsewhere > 1 else ''} far from the flight, not examined")
        passed_over = tuple(self._notes.passed_over)
        return Buildings(obstacles, passed_over, tuple(remarks), len(features), elsewhere, tuple(self._notes.unread))

    def _note_low_drawing(self, feature: Feature, parts: Sequence[MapObstacle]) -> None:
        _, altitude = feature.drawn
        is_low = altitude < self._notes.frame.home.altitude - FAR_BELOW_HOME
        if is_low and any(altitude > part.height for part in parts):
            subject = f"altitude of a shape over {FAR_BELOW_HOME:g} m below home, maybe its height above ground"
            self._notes.note(feature, subject, f"{altitude:g} m")

    def _as_drawn(self, part: MapObstacle, feature: Feature, called: str) -> MapObstacle:
        above_ground, altitude = feature.drawn
        above_home = altitude - self._notes.frame.home.altitude
        if max(above_ground, above_home) > max(part.height, part.least_top):
            self._counts["shape(s) drawn above the height of the tags, taken up to there"] += 1
        height = max(part.height, above_ground)
        return part._replace(called=called, height=height, least_top=max(part.least_top, above_home))

    def _between_supports(self, span: MapObstacle) -> MapObstacle:
        ends = shapely.get_coordinates(span.shape).round(1).tolist()
        highest = max(self._supports.get(tuple(end), 0.0) for end in ends)
        if highest <= span.height:
            return span
        self._counts["span(s) between higher supports, taken up to these"] += 1
        return span._replace(height=highest)

    def _misses(self, feature: Feature, extent: kinds.Extent) -> bool:
        if feature.missing is None and extent != "none":
            return False
        why = _why_passed_over(feature, "area", self._rules, self._all_buildings)
        return (why is None or why.may_be_obstacle) and self._notes.add_missing(feature)

    def _stand(self, feature: Feature, shape: Any) -> list[MapObstacle]:
        rules = self._rules
        counts = self._counts
        doubts = list[str]()

        def odd(key: str, value: str) -> None:
            self._odd_tags.append(f"{feature.name} ({key} {value[:20]!r})")
            if meaning(key) in HEIGHTENING and length_of(value)[0]:
                doubts.append(key)

        over_home = kinds.TOP_AMSL in feature.tags
        height = height_of(feature.tags, rules.height_key, rules.storey_height, odd)
        if over_home:
            height = math.inf  # given above sea level
        foot = foot_of(feature.tags, rules.storey_height, odd)
        if height is not None and foot >= height:
            counts["building(s) whose min_height is not below the height, taken to begin at the ground"] += 1
            foot = 0.0
        if is_by_storeys(feature.tags):
            counts[f"building(s) of known storeys and unknown roof, {rules.storey_height:g} m a storey"] += 1
        wire = None if over_home else wire_of(feature.tags, rules)
        if wire is not None and (hanging := list(spans(shape))):
            if height is None:
                counts[f"{wire.words} without a height, given {wire.height:g} m ({wire.key})"] += 1
            top = wire.height if height is None else height
            width = width_of(feature.tags, odd)
            self._doubt(feature, shape, doubts, top)
            reach = wire.reach if width is None else width / 2
            return [MapObstacle(feature.name, span, reach, 0.0, top, hangs=True) for span in hanging]
        obstacles: list[MapObstacle] = []
        building = any(feature.tags.get(key, "no") not in kinds.NO_BUILDING for key in ("building", "building:part"))
        hollow = not building and feature.tags.keys() & {"barrier", "natural"}
        is_on_roof = kinds.is_on_roof(feature.tags) and not (building or over_home or foot)
        for part in [part if hollow else close_as_polygon(part) for part in simple_parts(shape)]:
            thin = part.geom_type != "Polygon"
            kind, default = thin_height(feature.tags, rules) if thin else area_height(feature.tags, rules)
            if height is None:
                counts[f"{kind}(s) without a height, given {default:g} m"] += 1
                self._unused_keys |= dict.fromkeys(unused_numbers(feature.tags, default))
            top = foot + default if height is None else max(height, default if doubts else 0.0)
            low = self._roof_under(part) if is_on_roof else foot
            if low > foot:
                counts["thing(s) on a roof, with the height counted from there"] += 1
                top += low
            elif is_on_roof:
                doubts.append("location")
            if thin:
                if building and rules.take != "all":
                    words = f"expected the outline of a building, not a {part.geom_type}"
                    hint = "export whole outlines (`out geom` in Overpass turbo), not centers"
                    raise InvalidRing(words, hint=hint, place=f"{feature.place}.geometry")
                reach, width_unknown = reach_of(feature.tags, rules, part, top, odd)
                if width_unknown is not None:
                    counts[width_unknown] += 1
                obstacles.append(MapObstacle(feature.name, part, reach, low, top))
                if part.geom_type == "Point" and height is not None:
                    self._supports[tuple(shapely.get_coordinates(part).round(1)[0].tolist())] = top
                continue
            polygons, wrong = polygons_of(part, feature.place)
            if wrong is not None:
                counts[f"outline(s) mended ({wrong})"] += 1
            obstacles += [MapObstacle(feature.name, polygon, 0.0, low, top) for polygon in polygons]
        if over_home:
            altitude = meters(feature.tags[kinds.TOP_AMSL], f"{feature.place}.properties.{kinds.TOP_AMSL}")
            above = altitude - self._notes.frame.home.altitude
            return [part._replace(height=-math.inf, least_top=above) for part in obstacles]
        self._doubt(feature, shape, doubts, max((part.height for part in obstacles), default=0.0))
        return obstacles

    def _roof_under(self, part: Any) -> float:
        """Return the highest top under it [m above ground]; 0: unknown."""
        if self._standing is None:
            self._standing = shapely.STRtree([each.shape for each in self._obstacles])
        tops = [self._obstacles[n].height for n in self._standing.query(part, "intersects").tolist()]
        return max((top for top in tops if top > 0.0), default=0.0)

    def _doubt(self, feature: Feature, shape: Any, keys: Sequence[str], top: float) -> None:
        for key in dict.fromkeys((*keys, *unread_heights(feature.tags, top, self._rules.storey_height))):
            words = f"a height that was not understood ({key} {feature.tags[key][:20]!r}), {top:g} m was taken"
            remedy = "write the height in meters, or name the property that holds it under [[maps]]: height_key"
            self._notes.pass_over(feature, shape, kinds.Reason(words, True, remedy), NOT_READ)


def _why_passed_over(feature: Feature, extent: kinds.Extent, rules: BuildingRules, every: bool) -> kinds.Reason | None:
    why = kinds.why_passed_over(feature, extent, rules.height_key, every)
    if why is None:
        wire = None if rules.height_key in feature.tags else wire_of(feature.tags, rules)
        return kinds.Reason(f"{wire.key} = 0 excludes it", False) if wire is not None and not wire.height else None
    if why is kinds.CABLE and rules.line_height is not None:
        return None if rules.line_height else kinds.Reason("line_height = 0 excludes it", False)
    if why is kinds.WOOD and rules.wood_height is not None:
        return None if rules.wood_height else kinds.Reason("wood_height = 0 excludes it", False)
    if rules.take == "all" and why not in (kinds.FLAT, kinds.WOOD, kinds.CABLE) and extent != "none":
        return None
    is_decided = rules.take == "tagged" or (rules.take == "all" and why not in (kinds.WOOD, kinds.CABLE))
    return replace(why, may_be_obstacle=why.may_be_obstacle and not is_decided)


def raise_obstacles(obstacles: Sequence[MapObstacle], ground: Ground) -> tuple[Obstacle, ...]:
    hanging = [wall for each in obstacles if each.hangs for wall in raise_span(each, ground)]
    upright = [each for each in obstacles if not each.hangs]
    if not upright:
        return tuple(hanging)
    outlines = [_outline(each) for each in upright]
    heights = ground(np.vstack(outlines))
    first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
    lowest = np.minimum.reduceat(heights, first).tolist()
    highest = np.maximum.reduceat(heights, first).tolist()
    raised = list[Obstacle]()
    for each, low, high in zip(upright, lowest, highest, strict=True):
        top = max(high + each.height, each.least_top, low + 0.1)  # at least 0.1 m high
        raised.append(_upright(each, low + each.foot, top))
    return (*raised, *hanging)


def _outline(obstacle: MapObstacle) -> NDArray[np.float64]:
    corners = np.vstack([shapely.get_coordinates(obstacle.shape), places_under(obstacle.shape)])
    if obstacle.reach > 0:
        around = obstacle.reach * np.array([(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)])
        return np.asarray((corners[:, None, :] + around).reshape(-1, 2))
    return np.vstack([corners, shapely.get_coordinates(obstacle.shape.centroid)])


def _upright(obstacle: MapObstacle, base: float, top: float) -> Obstacle:
    name = obstacle.called or obstacle.name
    shape = obstacle.shape
    reach = obstacle.reach
    if shape.geom_type == "Point":
        return Cylinder(name, float(shape.x), float(shape.y), reach, base, top)
    if reach > 0:
        shape = shape.buffer(reach, cap_style="square", join_style="mitre")
    return Prism(name, *rings_of(shape), base, top)


def raise_span(obstacle: MapObstacle, ground: Callable[[NDArray[np.float64]], Vector]) -> Iterator[Prism]:
    """Yield walls under a span: several if its top rises or falls."""
    name = obstacle.called or obstacle.name
    span = obstacle.shape
    reach = obstacle.reach
    begin, end = shapely.get_coordinates(span)
    count = max(math.ceil(span.length / 8.0), 2)  # the ground is sampled every 8 m
    share = np.linspace(0.0, 1.0, count + 1)
    along = begin + share[:, None] * (end - begin)
    aside = reach * np.array([end[1] - begin[1], begin[0] - end[0]]) / span.length
    heights = ground(np.vstack([along - aside, along, along + aside])).reshape(3, -1)
    low = heights.min(axis=0)
    high = heights.max(axis=0)
    sagging = np.maximum(high, high[0] + share * (high[-1] - high[0])) + obstacle.height
    top = np.maximum(sagging, obstacle.least_top)
    # A piece's top rises or falls by at most 5 m, if that leaves pieces of 20 m or more.
    pieces = int(np.clip(math.ceil(float(np.ptp(top)) / 5.0), 1, max(span.length // 20.0, 1)))
    cuts = np.unique(np.round(np.linspace(0, count, min(pieces, count) + 1)).astype(int))
    for first, last in pairwise(cuts.tolist()):
        piece = slice(first, last + 1)
        outline = shapely.LineString(along[[first, last]]).buffer(reach, cap_style="square")
        yield Prism(name, *rings_of(outline), float(low[piece].min()), float(top[piece].max()))
