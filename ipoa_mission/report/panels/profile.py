from collections.abc import Iterator, Sequence
from html import escape
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.kept_limits import DeviationBound
from ipoa_mission.report.chart import Graph, GraphAxis, axis_over
from ipoa_mission.report.seen import Seen
from ipoa_mission.report.stops import FlownItem
from ipoa_mission.world.airspace import Airspace
from ipoa_mission.world.obstacles import Obstacle

Look: TypeAlias = Literal["below", "beside", "zone"]
LATERAL_DISTANCE = 15.0  # of obstacles near the path [m]
MIN_WIDTH = 0.004  # of the chart


def along_axis(course: Seen) -> GraphAxis:
    return axis_over("distance over ground [m]", course.along, room=0.015, floor=0.0)


def height_profile(
    course: Seen,
    airspace: Airspace,
    required: float,
    stops: Sequence[FlownItem],
    flown: Seen | None,
    deviation_bound: DeviationBound,
) -> str:
    """Show obstacles below the path and near it."""
    near = list(near_course(course, airspace, required))
    tops = np.array([min(float(body.bounds[1, 2]), float(course.points[:, 2].max()) * 1.6) for body, *_ in near])
    paths = [course.points[:, 2] + required, course.ground] + ([flown.points[:, 2]] if flown is not None else [])
    chart = Graph(along_axis(course), axis_over("height above home [m]", *paths, tops))
    floor = np.full(len(course.along), chart.y.low)
    up = course.points[:, 2]
    layers = [
        *(_block(chart, body, run, look) for body, run, look in near),
        chart.band(course.along, floor, course.ground, "soil"),
        chart.band(course.along, up - required, up + required, "band"),
        chart.band(course.along, up - deviation_bound.down, up + deviation_bound.up, "tube"),
        chart.curve(course.along, up, "planned"),
    ]
    if flown is not None:
        layers.append(chart.curve(_along_of(flown, course), flown.points[:, 2], "flown"))
    spots = [(n, course.nearest(stop.time.done_s)) for n, stop in enumerate(stops) if stop.place is not None]
    over = "".join(
        f'<button type="button" class="stop" data-stop="{n}" style="{chart.spot(course.along[i], up[i])}" '
        f'aria-label="item {stops[n].time.seq}"></button>'
        for n, i in spots
    )
    return chart.html("profile", layers, over, "tall", along="along")


def profile_legend(flown: bool, zones: bool) -> str:
    keys = '<span class="key planned">path as predicted</span>' + '<span class="key flown">flown</span>' * flown
    keys += '<span class="key tube">where flights are</span>'
    labels: tuple[tuple[Look, str], ...] = (("below", "obstacles below"), ("beside", "within 15 m to the side"))
    bodies = "".join(f'<span class="key {look}">{label}</span>' for look, label in labels)
    bodies += '<span class="key zone">no-fly zone</span>' * zones
    return f'<p class="legend">{keys}<span class="key band">must stay free</span>{bodies}</p>'


def distance_profile(course: Seen, required: float) -> str:
    """Cut large distances; empty if all are large."""
    most = max(6 * required, 20.0)
    if not (course.apart < most).any():
        return ""
    chart = Graph(
        along_axis(course),
        GraphAxis(0.0, most, "to obstacles [m]"),
    )
    apart = np.clip(course.apart, 0.0, most)
    layers = [
        chart.band(course.along, np.zeros(len(apart)), np.full(len(apart), required), "forbidden"),
        chart.curve(course.along, apart, "planned"),
        chart.level(required, "limit"),
    ]
    return chart.html("apart", layers, "", "low", along="along")


def speed_profile(course: Seen, stops: Sequence[FlownItem], flown: Seen | None) -> str:
    """Show a tick at each completed item, with what kept it slow."""
    speeds = [course.speeds] + ([flown.speeds] if flown is not None else [])
    times = [course.times] + ([flown.times] if flown is not None else [])
    chart = Graph(
        axis_over("time from arming [s]", *times, room=0.015, floor=0.0),
        axis_over("speed [m/s]", *speeds, room=0.12, floor=0.0),
    )
    layers = [
        chart.band(course.times, np.zeros(len(course.times)), course.speeds, "under"),
        chart.curve(course.times, course.speeds, "planned"),
    ]
    if flown is not None:
        layers.append(chart.curve(flown.times, flown.speeds, "flown"))
    over = "".join(_mark(n, stop, chart) for n, stop in enumerate(stops) if stop.time.duration_s > 0)
    return chart.html("speed", layers, over, "middle", along="times")


def _mark(n: int, stop: FlownItem, chart: Graph) -> str:
    time = stop.time
    words = f"item {time.seq}, {stop.name}" + (f": {time.reason}" if time.reason else "")
    left = 100 * float(chart.x.place(np.array([time.done_s]))[0])
    return (
        f'<button type="button" class="mark" data-stop="{n}" style="left:{left:.2f}%" '
        f'title="{escape(words)}" aria-label="{escape(words)}"></button>'
    )


def near_course(
    course: Seen, airspace: Airspace, required: float
) -> Iterator[tuple[Obstacle, tuple[float, float], Look]]:
    """Return each with its stretch along the path."""
    flat = course.points[:, :2]
    looks: tuple[tuple[Look, float], ...] = (("beside", max(LATERAL_DISTANCE, 2 * required)), ("below", required))
    for look, reach in looks:
        for body in airspace.obstacles:
            bounds = body.bounds
            close = np.asarray(((flat > bounds[0, :2] - reach) & (flat < bounds[1, :2] + reach)).all(axis=1))
            if not close.any():
                continue
            level = np.column_stack([flat[close], np.full(int(close.sum()), bounds[:, 2].mean())])
            close[close] = body.distance(level) < reach
            for first, last in _runs(close):
                yield body, (float(course.along[first]), float(course.along[last])), look if body.solid else "zone"


def _runs(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    yield from ((int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True))


def _block(chart: Graph, body: Obstacle, run: tuple[float, float], look: str) -> str:
    least = MIN_WIDTH * (chart.x.high - chart.x.low)
    middle, half = sum(run) / 2, max(run[1] - run[0], least) / 2
    base, top = (float(up) for up in body.bounds[:, 2])
    words = f"{body.name}: {base:.0f} to {top:.0f} m" if body.solid else f"{body.name}: no-fly zone"
    return chart.block((middle - half, middle + half), (max(base, chart.y.low), min(top, chart.y.high)), look, words)


def _along_of(flown: Seen, course: Seen) -> NDArray[np.float64]:
    """Scale to end with the predicted path."""
    return np.asarray(flown.along * (course.along[-1] / max(float(flown.along[-1]), 1e-9)))
