"""Motion along an S-curve leg of ArduCopter.

The same code runs as Python and compiled.
"""

import math

from ipoa_mission.vehicles.arducopter.dynamics.motion import CopterLeg

Triple = tuple[float, float, float]


def along(leg: CopterLeg, t: float) -> Triple:
    """Return acceleration, speed and way after t seconds."""
    segments = leg.profile.segments
    at = len(segments) - 1
    if t <= 0.0:
        return 0.0, segments[0].speed, 0.0
    if t >= leg.profile.lasts:
        return 0.0, leg.profile.leave, leg.length
    while at > 0 and segments[at].begin > t:
        at -= 1
    one = segments[at]
    t -= one.begin
    lasts, j, a, v, way = one.lasts, one.jerk, one.accel, one.speed, one.way
    if one.shape == 0.0 or lasts <= 0.0:
        return a + j * t, v + t * (a + j * t / 2), way + t * (v + t * (a / 2 + j * t / 6))
    b = lasts / math.pi
    s = b if one.shape == 1.0 else -b
    sine, cosine, half = math.sin(t / b), math.cos(t / b), j / 2
    return (
        a + half * (t - s * sine),
        v + a * t + half * (t * t / 2 + s * b * (cosine - 1.0)),
        way + v * t + a * t * t / 2 + half * (t * t * t / 6 + s * b * (b * sine - t)),
    )


def on_way(leg: CopterLeg, a: float, v: float, s: float, way_back: float) -> tuple[Triple, Triple, Triple]:
    """Return place, velocity and acceleration [m, m/s, m/s^2].

    The place is relative to the origin, or with the length as `way_back` to the target.
    """
    if leg.turn == 0.0:
        way = leg.direction
        s -= way_back
        return (s * way.x, s * way.y, s * way.z), (v * way.x, v * way.y, v * way.z), (a * way.x, a * way.y, a * way.z)
    east, north = leg.origin.x - leg.center.x, leg.origin.y - leg.center.y
    angle = leg.turn * s / leg.length
    sine, cosine = math.sin(angle), math.cos(angle)
    x, y = east * cosine + north * sine, north * cosine - east * sine
    start = leg.target if way_back > 0.0 else leg.origin
    radius, rise = math.sqrt(east * east + north * north), (leg.target.z - leg.origin.z) / leg.length
    upward = rise / math.sqrt(1.0 + rise * rise)
    onward = (1.0 if leg.turn > 0.0 else -1.0) / (radius * math.sqrt(1.0 + rise * rise))
    inward = (v / radius) ** 2
    return (
        (x + leg.center.x - start.x, y + leg.center.y - start.y, (s - way_back) * rise),
        (v * onward * y, -v * onward * x, v * upward),
        (a * onward * y - inward * x, -a * onward * x - inward * y, a * upward),
    )
