import math
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from typing import Any

import numpy as np
from contourpy import FillType, LineType, contour_generator

from ipoa_mission.forecast.deviation.kept_limits import DeviationBound
from ipoa_mission.geometry import Points
from ipoa_mission.report.chart import Extent
from ipoa_mission.report.ground_mesh import ground_mesh_over, round_step
from ipoa_mission.report.seen import Seen, outline_round
from ipoa_mission.report.stops import FlownItem
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.obstacles import Obstacle

TINTS = 8  # of the ground
SHADES = 5  # of the roofs


TOOLS = (
    '<div class="tools"><button type="button" data-key="+" aria-label="nearer">+</button>'
    '<button type="button" data-key="-" aria-label="farther">−</button>'
    '<button type="button" data-key="Home" aria-label="all of it">⌂</button></div>'
)


def ground_plan(
    scenario: Scenario,
    extent: Extent,
    stops: Sequence[FlownItem],
    course: Seen,
    flown: Seen | None,
    deviation_bound: DeviationBound,
) -> str:
    """North is up; the deviation bound is that of straight flight."""
    airspace = scenario.airspace
    bodies = extent.obstacles(airspace)
    highest = max((float(body.bounds[1, 2]) for body in extent.buildings(airspace)), default=1.0)
    layers = [
        _relief(*ground_mesh_over(airspace, extent.lower, extent.upper, 120)),
        *(_footprint(body, highest) for body in sorted(bodies, key=lambda b: float(b.bounds[1, 2]))),
        _bound(course.points, deviation_bound.level),
        _line(np.vstack([np.zeros((0, 3)), *(stop.way for stop in stops if stop.place is not None)]), "legs"),
        _line(course.points, "planned"),
    ]
    if flown is not None:
        layers.append(_line(flown.points, "flown"))
    layers.append('<path class="way-home" d=""><title>RTL from there</title></path>')
    (west, south), (east, north) = extent.lower, extent.upper
    width, height = east - west, north - south
    spots = "".join(_button(n, stop, extent) for n, stop in enumerate(stops) if stop.place is not None)
    return (
        f'<div class="map" id="map" style="--ratio:{width / height:.4f}" data-west="{west:.3f}" '
        f'data-south="{south:.3f}" data-width="{width:.3f}" data-height="{height:.3f}" tabindex="0">'
        f'<svg viewBox="0 0 {width:.2f} {height:.2f}" role="img" aria-label="map of the flight, north up">'
        f"{_hatch(width)}"
        f'<g transform="translate({-west:.3f} {north:.3f}) scale(1 -1)">{"".join(layers)}</g></svg>'
        f'{spots}<i class="here"></i>{_scale(width)}{TOOLS}</div>'
    )


def legend(scenario: Scenario, extent: Extent, flown: bool, home: bool = False) -> str:
    airspace = scenario.airspace
    tops = [float(body.bounds[1, 2]) for body in extent.buildings(airspace)]
    keys = [
        '<span class="key planned">path as predicted</span>',
        '<span class="key legs">legs between waypoints</span>',
    ]
    if flown:
        keys.append('<span class="key flown">flown</span>')
    if home:
        keys.append('<span class="key home">RTL from where one points</span>')
    if tops:
        shades = "".join(f'<i class="roof{n}"></i>' for n in range(SHADES))
        keys.append(f'<span class="ramp">{shades} roofs up to {max(tops):.0f} m above home</span>')
    if len(extent.obstacles(airspace)) > len(tops):
        keys.append('<span class="key zone">no-fly zone</span>')
    return f'<p class="legend">{"".join(keys)}</p>'


def _hatch(width: float) -> str:
    size = width / 100
    return (
        f'<defs><pattern id="hatch" width="{size:.2f}" height="{size:.2f}" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)"><path d="M0 0V{size:.2f}" class="hatch" style="stroke-width:{size / 6:.2f}"/>'
        "</pattern></defs>"
    )


def _relief(east: Points, north: Points, up: Points) -> str:
    low, high = float(up.min()), float(up.max())
    if high - low < 1.0:
        return ""
    step = round_step((high - low) / TINTS)
    levels = np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step
    maker: Any = contour_generator(east, north, up, fill_type=FillType.OuterOffset, line_type=LineType.Separate)
    drawn = []
    for n, level in enumerate(levels):
        polygons, offsets = maker.filled(float(level), np.inf)
        rings = [p[a:b] for p, o in zip(polygons, offsets, strict=True) for a, b in pairwise(o)]
        tint = round((n + 1) / len(levels) * TINTS)
        drawn.append(f'<path class="ground{tint}" d="{"".join(_ring(ring) for ring in rings)}"/>')
    for level in levels:
        lines = "".join("M" + _pairs(line) for line in maker.lines(float(level)))
        drawn.append(f'<path class="contour" d="{lines}"><title>{level:g} m above home</title></path>')
    return "".join(drawn)


def _footprint(body: Obstacle, highest: float) -> str:
    if not body.solid:
        rings = "".join(_ring(ring) for ring in body.outline())
        return f'<path class="zone" d="{rings}"><title>{escape(body.name)}: no-fly zone</title></path>'
    base, top = body.bounds[:, 2]
    shade = min(SHADES - 1, int(SHADES * max(top, 0.0) / max(highest, 1e-9)))
    rings = "".join(_ring(ring) for ring in body.outline())
    words = f"{escape(body.name)}: {base:.0f} to {top:.0f} m above home"
    return f'<path class="roof{shade}" d="{rings}"><title>{words}</title></path>'


def _button(n: int, stop: FlownItem, extent: Extent) -> str:
    assert stop.place is not None
    (west, south), (east, north) = extent.lower, extent.upper
    left, top = (stop.place[0] - west) / (east - west), (north - stop.place[1]) / (north - south)
    return (
        f'<button type="button" class="stop" data-stop="{n}" style="left:{100 * left:.2f}%;top:{100 * top:.2f}%" '
        f'aria-label="item {stop.time.seq}, {escape(stop.name)}"></button>'
    )


def _scale(width: float) -> str:
    length = round_step(width / 5)
    return (
        f'<span class="scale" style="width:{100 * length / width:.2f}%">{length:g} m</span><span class="north">N</span>'
    )


def _line(points: Points, look: str) -> str:
    return f'<path class="{look}" d="M{_pairs(points)}"/>' if len(points) else ""


def _bound(points: Points, level: float) -> str:
    rings = "".join(_ring(ring[:-1]) for ring in outline_round(points, level))
    return f'<path class="tube" d="{rings}"><title>where flights are</title></path>' if rings else ""


def _ring(points: Points) -> str:
    return f"M{_pairs(points)}Z"


def _pairs(points: Points) -> str:
    return "L".join(f"{east:.1f} {north:.1f}" for east, north in points[:, :2])
