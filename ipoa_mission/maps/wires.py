"""Size power lines and aerialways by their tags. Their obstacle is a wall, since nothing flies under a rope."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from ipoa_mission.maps.planar import simple_parts

# Up to [V], height and half width [m].
POWER_LINES = ((1e3, 10.0, 2.0), (60e3, 15.0, 3.0), (150e3, 40.0, 8.0), (300e3, 50.0, 12.0), (np.inf, 60.0, 16.0))
DRAG_LIFTS = {"drag_lift", "t-bar", "j-bar", "platter", "rope_tow"}
# A power cable is underground by default.
WIRES = {
    "power": {"line", "minor_line", "cable"},
    "aerialway": {"cable_car", "gondola", "mixed_lift", "chair_lift", "goods", "zip_line"} | DRAG_LIFTS,
    "communication": {"line"},
    "telecom": {"line"},
}


@dataclass(frozen=True)
class Wire:
    """Height and half width [m], and the key that changes the height."""

    words: str
    height: float
    reach: float
    key: str


def wire_of(tags: Mapping[str, str], line_height: float | None, aerialway_height: float) -> Wire | None:
    if WIRES.keys().isdisjoint(tags):
        return None
    lift = tags.get("aerialway")
    kind = tags.get("power")
    if lift in DRAG_LIFTS:
        return Wire("drag lift(s)", min(aerialway_height, 15.0), 5.0, "aerialway_height")
    if lift in WIRES["aerialway"]:
        return Wire("aerialway(s)", aerialway_height, 5.0, "aerialway_height")  # half width with cabins
    if kind in WIRES["power"]:
        volts = volts_of(tags.get("voltage", ""))
        words = f"power line(s) of {'unknown voltage' if volts is None else f'{volts / 1000:g} kV'}"
        most = (np.inf if kind == "line" else 60e3) if volts is None else volts
    elif "line" in (tags.get("communication"), tags.get("telecom")):
        words = "telephone line(s)"
        most = 1e3
    else:
        return None
    height, reach = next((height, reach) for volts, height, reach in POWER_LINES if most <= volts)
    return Wire(words, height if line_height is None else line_height, reach, "line_height")


def volts_of(text: str) -> float | None:
    """Return the highest voltage ("110000", "380000;110000", "20 kV") [V]."""
    parts = [re.fullmatch(r"(\d{1,7}(?:\.\d{1,3})?) ?(k?)v?", part.strip().lower()) for part in text.split(";")]
    return max((float(part[1]) * (1000.0 if part[2] else 1.0) for part in parts if part), default=None)


def spans(shape: Any) -> Iterator[Any]:
    """Yield the straight segments of lines, except those of length 0."""
    outlines = (part.boundary if part.geom_type == "Polygon" else part for part in simple_parts(shape))
    for line in (line for outline in outlines for line in simple_parts(outline) if line.geom_type == "LineString"):
        corners = shapely.get_coordinates(line)
        legs = np.stack([corners[:-1], corners[1:]], axis=1)
        yield from shapely.linestrings(legs[(legs[:, 0] != legs[:, 1]).any(axis=1)]).tolist()
