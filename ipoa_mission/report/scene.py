import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.kept_limits import DeviationBound
from ipoa_mission.geometry import Points, arc_lengths
from ipoa_mission.report.extent import Extent
from ipoa_mission.report.ground_mesh import ground_mesh_over
from ipoa_mission.report.seen import Seen
from ipoa_mission.report.stops import FlownItem
from ipoa_mission.scenario import Scenario
from ipoa_mission.world.obstacles.obstacle import Part
from ipoa_mission.world.terrain import Flat


@dataclass(frozen=True)
class SceneDetail:
    most_hoops: int = 120  # of the deviation bound
    hoop_corners: int = 12
    cells: int = 64  # along the longer side
    flat_cells: int = 12  # of level ground
    tallest: float = 0.55  # height over width
    flattest: float = 0.10  # height over width


DETAIL = SceneDetail()


def page_data(
    scenario: Scenario,
    extent: Extent,
    course: Seen,
    stops: Sequence[FlownItem],
    flown: Seen | None,
    deviation_bound: DeviationBound,
    home: Sequence[Mapping[str, Any]] = (),
) -> str:
    """Return JSON that is safe inside an HTML script element."""
    data = {
        "course": {
            "times": _rounded(course.times, 2),
            "along": _rounded(course.along, 1),
            "points": _rounded(course.points, 2),
            "speeds": _rounded(course.speeds, 2),
            "ground": _rounded(course.ground, 2),
            "apart": _rounded(course.apart, 2),
        },
        "stops": [_stop(stop, course, scenario) for stop in stops],
        "tube": _hoops(course.points, deviation_bound),
        "flown": None if flown is None else _rounded(flown.points, 2),
        "world": _world(scenario, extent, course),
        "home": [*home],
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _hoops(points: Points, deviation_bound: DeviationBound) -> list[Any]:
    if deviation_bound.level <= 0.0:
        return []
    along = arc_lengths(points)
    apart = max(4.0 * deviation_bound.level, float(along[-1]) / DETAIL.most_hoops)
    hoops = []
    for at in np.arange(apart, along[-1], apart):
        n = min(int(np.searchsorted(along, at)), len(points) - 1)
        ahead = points[n, :2] - points[n - 1, :2]
        if not (length := float(np.hypot(*ahead))):
            continue
        turn = np.linspace(0.0, 2 * np.pi, DETAIL.hoop_corners + 1)
        aside = deviation_bound.level * np.cos(turn)[:, None] * np.array([-ahead[1], ahead[0]]) / length
        height = np.where(np.sin(turn) > 0, deviation_bound.up, deviation_bound.down) * np.sin(turn)
        hoops.append(_rounded(points[n] + np.column_stack([aside, height]), 2))
    return hoops


def _stop(stop: FlownItem, course: Seen, scenario: Scenario) -> dict[str, Any]:
    spot = None
    if stop.place is not None:
        spot = _rounded(np.append(stop.place, scenario.airspace.ground(stop.place[None, :])), 2)
    index = course.nearest(stop.time.done_s)
    return {"seq": stop.time.seq, "name": stop.name, "reason": stop.time.reason, "index": index, "spot": spot}


def _world(scenario: Scenario, extent: Extent, course: Seen) -> dict[str, Any]:
    flat = isinstance(scenario.airspace.terrain, Flat)
    east, north, up = ground_mesh_over(
        scenario.airspace, extent.lower, extent.upper, DETAIL.flat_cells if flat else DETAIL.cells
    )
    bodies = extent.obstacles(scenario.airspace)
    floor = float(up.min())
    highest = max(
        [
            float(up.max()),
            float(course.points[:, 2].max()),
            *(float(b.bounds[1, 2]) for b in extent.buildings(scenario.airspace)),
        ]
    )
    width = float(np.subtract(extent.upper, extent.lower).max())
    steepness = max(highest - floor, 1.0) / width
    return {
        "lower": extent.lower,
        "upper": extent.upper,
        "floor": floor,
        "highest": highest,
        "lift": round(min(max(steepness, DETAIL.flattest), DETAIL.tallest) / steepness, 3),
        "ground": {
            "east": float(east[0, 0]),
            "north": float(north[0, 0]),
            "step_east": float(east[0, 1] - east[0, 0]),
            "step_north": float(north[1, 0] - north[0, 0]),
            "rows": up.shape[0],
            "columns": up.shape[1],
            "heights": _rounded(up.ravel(), 1),
        },
        "bodies": [_body(part) for body in bodies if body.solid for part in body.parts],
        "zones": [_body(part) for body in bodies if not body.solid for part in body.parts],
    }


def _body(part: Part) -> dict[str, Any]:
    return {name: _plain(value) for name, value in part.page_shape().items()}


def _plain(value: Any) -> Any:
    """Round to the centimeter; keep a bool."""
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if isinstance(value, np.ndarray):
        return _rounded(value, 2)
    return value if isinstance(value, bool) else round(float(value), 2)


def _rounded(values: NDArray[np.float64], digits: int) -> list[Any]:
    """Values that are not finite become null."""
    if values.ndim > 1:
        return [_rounded(row, digits) for row in values]
    return [round(float(v), digits) if math.isfinite(v) else None for v in values]
