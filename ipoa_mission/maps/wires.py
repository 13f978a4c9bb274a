"""Power lines and aerialways: their obstacle is a wall, since nothing flies under a rope."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector
from ipoa_mission.world.obstacles import Prism
from ipoa_mission.world.polygon import rings_of

# Up to [V], height and half width [m].
POWER = ((1e3, 10.0, 2.0), (60e3, 15.0, 3.0), (150e3, 40.0, 8.0), (300e3, 50.0, 12.0), (math.inf, 60.0, 16.0))
# Without a voltage [V].
VOLTAGES = {"line": math.inf, "minor_line": 60e3, "cable": 60e3}
AERIALWAYS = {"cable_car", "gondola", "mixed_lift", "chair_lift", "goods", "zip_line"}
DRAG_LIFTS = {"drag_lift", "t-bar", "j-bar", "platter", "rope_tow"}
DRAG_LIFT = 15.0  # greatest height [m]
AERIALWAY_REACH = 5.0  # half width with cabins [m]
# A power cable is underground by default.
WIRES = {
    "power": {"line", "minor_line", "cable"},
    "aerialway": AERIALWAYS | DRAG_LIFTS,
    "communication": {"line"},
    "telecom": {"line"},
}
OVERGROUND = {"overground", "overhead", "kiosk", "roof"}
STEP = 8.0  # of ground samples [m]
RELIEF = 5.0  # of a span's top, undivided [m]
LEAST_PIECE = 20.0  # [m]


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
    if tags.get("aerialway") in WIRES["aerialway"]:
        is_drag = tags["aerialway"] in DRAG_LIFTS
        height = min(aerialway_height, DRAG_LIFT) if is_drag else aerialway_height
        return Wire("drag lift(s)" if is_drag else "aerialway(s)", height, AERIALWAY_REACH, "aerialway_height")
    kind = tags.get("power")
    if kind in WIRES["power"]:
        volts = volts_of(tags.get("voltage", ""))
        words = f"power line(s) of {'unknown voltage' if volts is None else f'{volts / 1000:g} kV'}"
        most = VOLTAGES[kind] if volts is None else volts
    elif "line" in (tags.get("communication"), tags.get("telecom")):
        words, most = "telephone line(s)", 1e3
    else:
        return None
    height, reach = next((height, reach) for volts, height, reach in POWER if most <= volts)
    return Wire(words, height if line_height is None else line_height, reach, "line_height")


def volts_of(text: str) -> float | None:
    """Return the highest voltage ("110000", "380000;110000", "20 kV") [V]."""
    found = [re.fullmatch(r"(\d{1,7}(?:\.\d{1,3})?) ?(k?)v?", part.strip().lower()) for part in text.split(";")]
    return max((float(one[1]) * (1000.0 if one[2] else 1.0) for one in found if one), default=None)


def spans(shape: Any) -> Iterator[Any]:
    """Yield the straight segments of lines, except those of length 0."""
    for part in shapely.get_parts(shape):
        if hasattr(part, "geoms"):
            yield from spans(part)
        elif part.geom_type == "Polygon":
            yield from spans(part.boundary)
        elif part.geom_type == "LineString":
            corners = shapely.get_coordinates(part)
            legs = np.stack([corners[:-1], corners[1:]], axis=1)
            yield from shapely.linestrings(legs[(legs[:, 0] != legs[:, 1]).any(axis=1)]).tolist()


def raise_span(
    name: str, span: Any, reach: float, height: float, ground: Callable[[NDArray[np.float64]], Vector]
) -> Iterator[Prism]:
    """Yield walls under a span: several if its top rises or falls."""
    begin, end = shapely.get_coordinates(span)
    count = max(math.ceil(span.length / STEP), 2)
    share = np.linspace(0.0, 1.0, count + 1)
    along = begin + share[:, None] * (end - begin)
    aside = reach * np.array([end[1] - begin[1], begin[0] - end[0]]) / span.length
    heights = ground(np.vstack([along - aside, along, along + aside])).reshape(3, -1)
    low, high = heights.min(axis=0), heights.max(axis=0)
    top = np.maximum(high, high[0] + share * (high[-1] - high[0])) + height
    pieces = int(np.clip(math.ceil(float(np.ptp(top)) / RELIEF), 1, max(span.length // LEAST_PIECE, 1)))
    cuts = np.unique(np.round(np.linspace(0, count, min(pieces, count) + 1)).astype(int))
    for first, last in pairwise(cuts.tolist()):
        here = slice(first, last + 1)
        outline = shapely.LineString(along[[first, last]]).buffer(reach, cap_style="square")
        yield Prism(name, *rings_of(outline), float(low[here].min()), float(top[here].max()))
