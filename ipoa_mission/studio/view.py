"""Show a scenario on a map: longitude, latitude, and heights above home."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from contourpy import FillType, contour_generator
from numpy.typing import NDArray

from ipoa_mission import BadInput, Scenario
from ipoa_mission.geodesy import LocalFrame, radii_of_curvature
from ipoa_mission.geometry import Matrix, Points
from ipoa_mission.report.chart import round_step
from ipoa_mission.report.drawn_flight import ground_mesh
from ipoa_mission.scenario.place_sections import FenceSection
from ipoa_mission.studio.answers import Body, Fence, Heights, Spot, Terrace, World
from ipoa_mission.studio.edits import frame_of
from ipoa_mission.studio.vocabulary import LngLat, MapLine, as_on_map

CELLS = 96  # of the ground, along the longer side


def world_of(scenario: Scenario) -> World:
    frame = scenario.frame
    bounds = scenario.airspace.bounds
    corners = corners_of(frame, bounds.lower[:2], bounds.upper[:2])
    mesh = ground_mesh(scenario.airspace, CELLS)
    return World(
        box=(*corners[0], *corners[2]),
        around=corners,
        degree_m=degree_of(frame),
        floor=float(bounds.lower[2]),
        ceiling=float(bounds.upper[2]),
        bodies=tuple(_bodies(scenario)),
        spots=tuple(_spots(scenario)),
        fences=tuple(fence_of(n, fence, frame) for n, fence in enumerate(scenario.fence)),
        ground=tuple(_terraces(frame, *mesh)),
        heights=_heights(frame, *mesh),
        home_amsl=scenario.home.altitude_amsl,
        required=scenario.limits.obstacle_distance,
        remarks=scenario.remarks,
    )


def corners_of(frame: LocalFrame, lower: Sequence[float], upper: Sequence[float]) -> tuple[LngLat, ...]:
    (west, south), (east, north) = lower, upper
    return on_map(frame, np.array([(west, south), (east, south), (east, north), (west, north)]))


def on_map(frame: LocalFrame, points: NDArray[np.float64]) -> tuple[LngLat, ...]:
    """Return longitude and latitude [deg] of local points (n, 2 or 3)."""
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    latitude, longitude, _ = frame.to_geodetic(points)
    return tuple(zip(longitude.round(7).tolist(), latitude.round(7).tolist(), strict=True))


def rings_of(frame: LocalFrame, polygon: Any) -> tuple[tuple[LngLat, ...], ...]:
    return tuple(on_map(frame, shapely.get_coordinates(ring)) for ring in (polygon.exterior, *polygon.interiors))


def line_of(frame: LocalFrame, points: Points) -> MapLine:
    return MapLine(points=on_map(frame, points), up=tuple(points[:, 2].round(2).tolist()))


def without_folders(words: str, scenario: Scenario) -> str:
    for section in scenario.maps:
        words = words.replace(str(section.file), section.file.name)
    return as_on_map(words)


def degree_of(frame: LocalFrame) -> tuple[float, float]:
    meridian, across = radii_of_curvature(frame.home.latitude_deg)
    return math.radians(across * math.cos(math.radians(frame.home.latitude_deg))), math.radians(meridian)


def _bodies(scenario: Scenario) -> Iterator[Body]:
    frame = scenario.frame
    for n, body in enumerate(scenario.airspace.obstacles):
        base, top = body.bounds[:, 2].tolist()
        yield Body(
            name=without_folders(body.name, scenario),
            path=("obstacles", n) if n < len(scenario.obstacles) else None,
            solid=body.solid,
            base=round(base, 2),
            top=round(top, 2),
            rings=tuple(_closed(on_map(frame, np.asarray(ring, float))) for ring in body.outline()),
        )
    for thing in scenario.passed_over:
        if thing.may_be_obstacle and not shapely.is_empty(thing.shape):
            yield from _doubtful(thing.name, thing.shape, frame)


def _doubtful(name: str, shape: shapely.Geometry, frame: LocalFrame) -> Iterator[Body]:
    """Yield the outline of a thing of unknown height; lines and points become thin areas."""
    half_width = 0.75  # of a line [m]
    wide = shape if shapely.get_dimensions(shape) == 2 else shape.buffer(half_width, quad_segs=3)
    for part in shapely.get_parts(wide):
        yield Body(name=name, path=None, solid=False, doubt=True, base=0.0, top=0.0, rings=rings_of(frame, part))


def _spots(scenario: Scenario) -> Iterator[Spot]:
    places: list[tuple[str, tuple[str | int, ...], Any]] = [("home", ("home",), np.zeros(3))]
    places += [("start", ("start",), scenario.start_point), ("goal", ("goal",), scenario.goal_point)]
    places += [(f"via {n + 1}", ("via", n), point) for n, point in enumerate(scenario.via_points)]
    places += [(f"rally {n + 1}", ("rally", n), point) for n, point in enumerate(scenario.rally_points)]
    points = np.array([point for _, _, point in places])
    heights = points[:, 2] - scenario.airspace.ground(points)
    for (name, path, point), where, height in zip(places, on_map(scenario.frame, points), heights, strict=True):
        up = round(float(point[2]), 2)
        yield Spot(name=name, path=path, place=where, up=up, above_ground=round(float(height), 2))


def fence_of(n: int, fence: FenceSection, frame: LocalFrame) -> Fence:
    if fence.center is not None and fence.radius is not None:
        circle = shapely.Point(fence.center.east_north(frame)).buffer(fence.radius, quad_segs=16)
        ring = on_map(frame, shapely.get_coordinates(circle.exterior))
    elif fence.polygon is not None:
        ring = _closed(on_map(frame, np.array(fence.polygon, float)))
    else:
        ring = _closed(tuple((longitude, latitude) for latitude, longitude in fence.polygon_geodetic or ()))
    return Fence(path=("fence", n), inclusion=fence.inclusion, ring=ring)


def fences_drawn(table: Mapping[str, Any]) -> Iterator[Fence]:
    with suppress(KeyError, TypeError, ValueError, BadInput):
        frame = frame_of(dict(table))
        for n, fence in enumerate(table.get("fence", ())):
            yield fence_of(n, FenceSection.model_validate(fence), frame)


def _terraces(frame: LocalFrame, east: Matrix, north: Matrix, up: Matrix) -> Iterator[Terrace]:
    """Yield about 12 steps, each drawn where the ground is at least as high."""
    low, high = float(up.min()), float(up.max())
    step = round_step(max(high - low, 1.0) / 12)
    maker: Any = contour_generator(east, north, up, fill_type=FillType.OuterOffset)
    for level in np.arange(math.floor(low / step), math.floor(high / step) + 1) * step:
        polygons, offsets = maker.filled(float(level) - 1e-6, np.inf)
        drawn = [
            tuple(on_map(frame, points[a:b]) for a, b in pairwise(offset))
            for points, offset in zip(polygons, offsets, strict=True)
        ]
        if drawn:
            yield Terrace(up=round(float(level), 2), polygons=tuple(drawn))


def _heights(frame: LocalFrame, east: Matrix, north: Matrix, up: Matrix) -> Heights:
    ends = np.array([[east[0, 0], north[0, 0]], [east[-1, -1], north[-1, -1]]])
    (west, south), (far, top) = on_map(frame, ends)
    rows, columns = up.shape
    step = (far - west) / (columns - 1), (top - south) / (rows - 1)
    return Heights(corner=(west, south), step=step, columns=columns, up=tuple(up.ravel().round(1).tolist()))


def _closed(ring: tuple[LngLat, ...]) -> tuple[LngLat, ...]:
    return (*ring, ring[0])
