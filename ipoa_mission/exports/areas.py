"""Fence parts as closed rings, for formats that know no circles."""

from itertools import pairwise

import numpy as np

from ipoa_mission.items import FenceCircle, FencePolygon
from ipoa_mission.world.frame import Geodetic, LocalFrame

CORNERS = 72  # of the polygon that stands for a circle; it lies inside, by a thousandth of the radius at most


def ring(part: FencePolygon | FenceCircle) -> list[tuple[float, float]]:
    """The closed ring of a fence part as (longitude, latitude), counterclockwise as GeoJSON and KML want it."""
    if isinstance(part, FenceCircle):
        angles = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
        circle = part.radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(CORNERS)])
        latitude, longitude, _ = LocalFrame(Geodetic(*part.center)).to_geodetic(circle)
        corners = [(round(float(lon), 9), round(float(lat), 9)) for lat, lon in zip(latitude, longitude, strict=True)]
    else:
        corners = [(lon, lat) for lat, lon in part.vertices]
    closed = [*corners, corners[0]]
    doubled_area = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(closed))
    return closed if doubled_area >= 0 else closed[::-1]
