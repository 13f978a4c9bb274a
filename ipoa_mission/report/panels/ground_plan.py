"""The map of the flight as SVG, north up."""

import math
from html import escape
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from contourpy import FillType, LineType, contour_generator

from ipoa_mission.geometry import Matrix, Plane
from ipoa_mission.report.chart import round_step
from ipoa_mission.report.drawn_flight import DrawnFlight, Extent, ground_mesh, outline_around
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.obstacles import Obstacle

SHADES = 5  # of the roofs, as in page.css


class MapLayers(NamedTuple):
    """SVG in meters east and north, below the paths; the map contains the places `around` (n, 2) [m]."""

    svg: str
    around: Plane


NO_LAYERS = MapLayers("", np.zeros((0, 2)))


def ground_plan(flight: DrawnFlight, extent: Extent, below: MapLayers) -> str:
    """Draw from above, with the deviation bound of straight flight."""
    airspace = flight.scenario.airspace
    bodies = sorted(extent.obstacles(airspace), key=lambda body: float(body.bounds[1, 2]))
    highest = max((float(body.bounds[1, 2]) for body in extent.buildings(airspace)), default=1.0)
    outline = outline_around(flight.predicted.points, flight.deviation_bound.lateral)
    bound = "".join(ring_path(ring[:-1]) for ring in outline)
    places = [(n, leg, leg.place) for n, leg in enumerate(flight.legs) if leg.place is not None]
    layers = [
        _relief(*ground_mesh(airspace, 120, extent)),
        *(_footprint(body, highest) for body in bodies),
        below.svg,
        f'<path class="deviation" d="{bound}"><title>where flights are</title></path>' if bound else "",
        _line(np.vstack([np.zeros((0, 3)), *(leg.path for _, leg, _ in places)]), "legs"),
        _line(flight.predicted.points, "planned"),
        "" if flight.flown is None else _line(flight.flown.points, "flown"),
        '<path class="way-home" d=""><title>RTL from there</title></path>',
    ]
    west, south = extent.lower
    east, north = extent.upper
    width = east - west
    height = north - south
    buttons = "".join(
        f'<button type="button" class="stop" data-stop="{n}" style="left:{100 * ((place[0] - west) / width):.2f}%;'
        f'top:{100 * ((north - place[1]) / height):.2f}%" '
        f'aria-label="item {leg.time.seq}, {escape(leg.name)}"></button>'
        for n, leg, place in places
    )
    scale = round_step(width / 5)
    return (
        f'<div class="map" id="map" style="--ratio:{width / height:.4f}" data-west="{west:.3f}" '
        f'data-south="{south:.3f}" data-width="{width:.3f}" data-height="{height:.3f}" tabindex="0">'
        f'<svg viewBox="0 0 {width:.2f} {height:.2f}" role="img" aria-label="map of the flight, north up">'
        f'<defs><pattern id="hatch" width="{width / 100:.2f}" height="{width / 100:.2f}" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)"><path d="M0 0V{width / 100:.2f}" class="hatch" '
        f'style="stroke-width:{width / 600:.2f}"/></pattern></defs>'
        f'<g transform="translate({-west:.3f} {north:.3f}) scale(1 -1)">{"".join(layers)}</g></svg>'
        f'{buttons}<i class="here"></i>'
        f'<span class="scale" style="width:{100 * scale / width:.2f}%">{scale:g} m</span><span class="north">N</span>'
        '<div class="tools"><button type="button" data-key="+" aria-label="nearer">+</button>'
        '<button type="button" data-key="-" aria-label="farther">−</button>'
        '<button type="button" data-key="Home" aria-label="all of it">⌂</button></div></div>'
    )


def legend(scenario: Scenario, extent: Extent, flown: bool, home: bool) -> str:
    tops = [float(body.bounds[1, 2]) for body in extent.buildings(scenario.airspace)]
    keys = '<span class="key planned">path as predicted</span><span class="key legs">legs between waypoints</span>'
    keys += '<span class="key flown">flown</span>' * flown
    keys += '<span class="key home">RTL from where one points</span>' * home
    if tops:
        shades = "".join(f'<i class="roof{n}"></i>' for n in range(SHADES))
        keys += f'<span class="ramp">{shades} roofs up to {max(tops):.0f} m above home</span>'
    keys += '<span class="key zone">no-fly zone</span>' * (len(extent.obstacles(scenario.airspace)) > len(tops))
    return f'<p class="legend">{keys}</p>'


def _relief(east: Matrix, north: Matrix, up: Matrix) -> str:
    """Draw the ground in tints with contour lines; empty if level within 1 m."""
    low = float(up.min())
    high = float(up.max())
    if high - low < 1.0:
        return ""
    step = round_step((high - low) / 8)
    levels = np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step
    maker: Any = contour_generator(east, north, up, fill_type=FillType.OuterOffset, line_type=LineType.Separate)
    drawn = []
    for n, level in enumerate(levels, start=1):
        polygons, offsets = maker.filled(float(level), np.inf)
        rings = [p[a:b] for p, o in zip(polygons, offsets, strict=True) for a, b in pairwise(o)]
        drawn.append(f'<path class="ground{round(n / len(levels) * 8)}" d="{"".join(map(ring_path, rings))}"/>')
    for level in levels:
        lines = "".join(line_path(line) for line in maker.lines(float(level)))
        drawn.append(f'<path class="contour" d="{lines}"><title>{level:g} m above home</title></path>')
    return "".join(drawn)


def _footprint(body: Obstacle, highest: float) -> str:
    rings = "".join(map(ring_path, body.outline()))
    name = escape(body.name)
    if not body.solid:
        return f'<path class="zone" d="{rings}"><title>{name}: no-fly zone</title></path>'
    base, top = body.bounds[:, 2]
    shade = min(SHADES - 1, int(SHADES * max(top, 0.0) / max(highest, 1e-9)))
    return f'<path class="roof{shade}" d="{rings}"><title>{name}: {base:.0f} to {top:.0f} m above home</title></path>'


def _line(points: Matrix, look: str) -> str:
    return f'<path class="{look}" d="{line_path(points)}"/>' if len(points) else ""


def ring_path(points: Matrix) -> str:
    return f"{line_path(points)}Z"


def line_path(points: Matrix) -> str:
    return "M" + "L".join(f"{east:.1f} {north:.1f}" for east, north in points[:, :2])
