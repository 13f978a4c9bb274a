from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np

from ipoa_mission.report.chart import Graph, GraphAxis, axis_over
from ipoa_mission.report.drawn_flight import DrawnFlight, SampledTrack
from ipoa_mission.world.airspace import Airspace

Look: TypeAlias = Literal["below", "beside", "zone"]
MIN_WIDTH = 0.004  # of what a chart shows


@dataclass(frozen=True)
class NearbyObstacle:
    """An obstacle or zone near the path, its heights and distances along [m]."""

    name: str
    look: Look
    begins: float
    ends: float
    base: float
    top: float


def along_axis(predicted: SampledTrack) -> GraphAxis:
    return axis_over("distance over ground [m]", predicted.along, room=0.015, floor=0.0)


def height_profile(flight: DrawnFlight) -> str:
    predicted = flight.predicted
    flown = flight.flown
    along = predicted.along
    up = predicted.points[:, 2]
    required = flight.scenario.limits.obstacle_distance
    near = list(near_track(predicted, flight.scenario.airspace, required))
    tops = np.array([min(one.top, float(up.max()) * 1.6) for one in near])
    heights = [up + required, predicted.ground, *([] if flown is None else [flown.points[:, 2]])]
    chart = Graph(along_axis(predicted), axis_over("height above home [m]", *heights, tops))
    layers = [
        *(_block(chart, one) for one in near),
        chart.band(along, np.full(len(along), chart.y.low), predicted.ground, "soil"),
        chart.band(along, up - required, up + required, "band"),
        chart.band(along, up - flight.deviation_bound.down, up + flight.deviation_bound.up, "deviation"),
        chart.curve(along, up, "planned"),
    ]
    if flown is not None:
        scaled = flown.along * (along[-1] / max(float(flown.along[-1]), 1e-9))  # to end with the predicted path
        layers.append(chart.curve(scaled, flown.points[:, 2], "flown"))
    spots = [(n, predicted.nearest(leg.time.done_s)) for n, leg in enumerate(flight.legs) if leg.place is not None]
    over = "".join(
        f'<button type="button" class="stop" data-stop="{n}" style="{chart.spot(along[i], up[i])}" '
        f'aria-label="item {flight.legs[n].time.seq}"></button>'
        for n, i in spots
    )
    return chart.html("profile", layers, over, "tall", along="along")


def profile_legend(flown: bool, zones: bool) -> str:
    keys = '<span class="key planned">path as predicted</span>' + '<span class="key flown">flown</span>' * flown
    keys += '<span class="key deviation">where flights are</span><span class="key band">must stay free</span>'
    looks: tuple[tuple[Look, str], ...] = (("below", "obstacles below"), ("beside", "within 15 m to the side"))
    keys += "".join(f'<span class="key {look}">{label}</span>' for look, label in looks)
    keys += '<span class="key zone">no-fly zone</span>' * zones
    return f'<p class="legend">{keys}</p>'


def distance_profile(predicted: SampledTrack, required: float) -> str:
    """Cut large distances; empty if all are large."""
    most = max(6 * required, 20.0)
    if not (predicted.apart < most).any():
        return ""
    chart = Graph(along_axis(predicted), GraphAxis(0.0, most, "to obstacles [m]"))
    apart = np.clip(predicted.apart, 0.0, most)
    layers = [
        chart.band(predicted.along, np.zeros(len(apart)), np.full(len(apart), required), "forbidden"),
        chart.curve(predicted.along, apart, "planned"),
        chart.level(required, "limit"),
    ]
    return chart.html("apart", layers, "", "low", along="along")


def speed_profile(flight: DrawnFlight) -> str:
    predicted = flight.predicted
    tracks = [flight.predicted, *([] if flight.flown is None else [flight.flown])]
    chart = Graph(
        axis_over("time from arming [s]", *(track.times for track in tracks), room=0.015, floor=0.0),
        axis_over("speed [m/s]", *(track.speeds for track in tracks), room=0.12, floor=0.0),
    )
    curves = zip(tracks, ("planned", "flown"), strict=False)
    layers = [
        chart.band(predicted.times, np.zeros(len(predicted.times)), predicted.speeds, "under"),
        *(chart.curve(track.times, track.speeds, look) for track, look in curves),
    ]
    over = ""
    for n, leg in enumerate(flight.legs):
        if leg.time.duration_s > 0:
            because = f": {leg.time.reason}" if leg.time.reason else ""
            words = escape(f"item {leg.time.seq}, {leg.name}{because}")
            left = 100 * float(chart.x.place(np.array([leg.time.done_s]))[0])
            over += f'<button type="button" class="mark" data-stop="{n}" style="left:{left:.2f}%" '
            over += f'title="{words}" aria-label="{words}"></button>'
    return chart.html("speed", layers, over, "middle", along="times")


def near_track(predicted: SampledTrack, airspace: Airspace, required: float) -> Iterator[NearbyObstacle]:
    flat = predicted.points[:, :2]
    reaches: tuple[tuple[Look, float], ...] = (("beside", max(15.0, 2 * required)), ("below", required))
    for look, reach in reaches:
        for body in airspace.obstacles:
            bounds = body.bounds
            close = np.asarray(((flat > bounds[0, :2] - reach) & (flat < bounds[1, :2] + reach)).all(axis=1))
            if not close.any():
                continue
            level = np.column_stack([flat[close], np.full(int(close.sum()), bounds[:, 2].mean())])
            close[close] = body.distance(level) < reach
            edges = np.flatnonzero(np.diff(np.concatenate([[False], close, [False]]).astype(int)))
            base, top = (float(up) for up in bounds[:, 2])
            for first, after in edges.reshape(-1, 2):
                begins = float(predicted.along[first])
                ends = float(predicted.along[after - 1])
                yield NearbyObstacle(body.name, look if body.solid else "zone", begins, ends, base, top)


def _block(chart: Graph, near: NearbyObstacle) -> str:
    least = MIN_WIDTH * (chart.x.high - chart.x.low)
    middle = (near.begins + near.ends) / 2
    half = max(near.ends - near.begins, least) / 2
    heights = (max(near.base, chart.y.low), min(near.top, chart.y.high))
    extent = "no-fly zone" if near.look == "zone" else f"{near.base:.0f} to {near.top:.0f} m"
    return chart.block((middle - half, middle + half), heights, near.look, f"{near.name}: {extent}")
