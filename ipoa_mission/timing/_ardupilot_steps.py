"""ArduCopter along one leg, step by step: the path's clock, the legs that overlap, the vehicle that follows.

Plain scalar code over flat sequences, so that the same lines run as Python (on lists) and compiled (on arrays): see
`_compiled`. `ardupilot` packs the arguments and says what they mean.
"""

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any

jit: Callable[[Any], Any] = globals().get("jit", lambda function: function)

GRAVITY = 9.80665
SEGMENTS, WIDTH = 20, 7  # a leg's segments begin at this index, each so many numbers


@jit
def along(leg: Sequence[float], t: float) -> tuple[float, float, float]:
    """Acceleration, speed and way of a straight leg, t seconds after its start."""
    if t <= 0.0:
        return 0.0, leg[SEGMENTS + 5] if leg[11] > 0 else 0.0, 0.0
    if t >= leg[8]:
        return 0.0, 0.0, leg[7]
    at = SEGMENTS + WIDTH * (int(leg[11]) - 1)
    while at > SEGMENTS and leg[at] > t:
        at -= WIDTH
    t = t - leg[at]
    lasts, shape, j, a, v, way = leg[at + 1], leg[at + 2], leg[at + 3], leg[at + 4], leg[at + 5], leg[at + 6]
    if shape == 0.0 or lasts <= 0.0:
        return a + j * t, v + t * (a + j * t / 2), way + t * (v + t * (a / 2 + j * t / 6))
    b = lasts / math.pi
    s = b if shape == 1.0 else -b
    sine, cosine, half = math.sin(t / b), math.cos(t / b), j / 2
    return (
        a + half * (t - s * sine),
        v + a * t + half * (t * t / 2 + s * b * (cosine - 1.0)),
        way + v * t + a * t * t / 2 + half * (t * t * t / 6 + s * b * (b * sine - t)),
    )


@jit
def along_limit(x: float, y: float, z: float, flat: float, up: float, down: float) -> float:
    """The most that a vector along the unit direction (x, y, z) may have, so that each component keeps its limit."""
    level = math.sqrt(x * x + y * y)
    if level < 1e-9:
        return up if z > 0.0 else down
    if abs(z) < 1e-9:
        return flat / level
    return min(flat / level, (up if z > 0.0 else down) / abs(z))


@jit
def bend(leg: Sequence[float], u: float) -> tuple[float, float, float, float, float, float, float, float]:
    """A spline leg at parameter u: place, unit direction, length of its derivative, speed that the bend allows."""
    at = SEGMENTS
    px = leg[at] + u * (leg[at + 3] + u * (leg[at + 6] + u * leg[at + 9]))
    py = leg[at + 1] + u * (leg[at + 4] + u * (leg[at + 7] + u * leg[at + 10]))
    pz = leg[at + 2] + u * (leg[at + 5] + u * (leg[at + 8] + u * leg[at + 11]))
    dx = leg[at + 3] + u * (2 * leg[at + 6] + 3 * u * leg[at + 9])
    dy = leg[at + 4] + u * (2 * leg[at + 7] + 3 * u * leg[at + 10])
    dz = leg[at + 5] + u * (2 * leg[at + 8] + 3 * u * leg[at + 11])
    ax, ay, az = 2 * leg[at + 6] + 6 * u * leg[at + 9], 2 * leg[at + 7] + 6 * u * leg[at + 10], 2 * leg[at + 8]
    az += 6 * u * leg[at + 11]
    rate = math.sqrt(dx * dx + dy * dy + dz * dz)
    if rate < 1e-6:  # at rest the curve leaves along its second derivative
        size = math.sqrt(ax * ax + ay * ay + az * az)
        if size < 1e-9:
            return px, py, pz, 0.0, 0.0, 0.0, 0.0, 0.0
        top = along_limit(ax / size, ay / size, az / size, leg[14], leg[15], leg[16])
        return px, py, pz, ax / size, ay / size, az / size, 0.0, top
    dx, dy, dz = dx / rate, dy / rate, dz / rate
    top = along_limit(dx, dy, dz, leg[14], leg[15], leg[16])
    inward = ax * dx + ay * dy + az * dz
    ax, ay, az = ax - inward * dx, ay - inward * dy, az - inward * dz
    across = math.sqrt(ax * ax + ay * ay + az * az)
    if across > 1e-9:
        most = along_limit(ax / across, ay / across, az / across, leg[17], leg[18], leg[18])
        top = min(top, rate * math.sqrt(most / across))
    return px, py, pz, dx, dy, dz, rate, top


@jit
def turn_is_gentle(this: Sequence[float], following: Sequence[float], elapsed: float, pace: Sequence[float]) -> bool:
    """Whether the next leg may begin now: the middle of the overlap lies within radius and corner acceleration."""
    half = (this[8] - elapsed) / 2
    a, _, s = along(this, elapsed + half)
    a2, _, s2 = along(following, half)
    s -= this[7]
    x, y, z = s * this[4] + s2 * following[4], s * this[5] + s2 * following[5], s * this[6] + s2 * following[6]
    if x * x + y * y + z * z >= pace[0] * pace[0]:
        return False
    x, y, z = a * this[4] + a2 * following[4], a * this[5] + a2 * following[5], a * this[6] + a2 * following[6]
    return bool(x * x + y * y < pace[1] * pace[1] and abs(z) < pace[2])


@jit
def fly_leg(
    before: Sequence[float],
    this: Sequence[float],
    following: Sequence[float],
    pace: Sequence[float],
    state: MutableSequence[float],
    samples: MutableSequence[float],
) -> bool:
    """Fly until the leg counts as passed; False if that takes more samples than there is room for.

    `state` is left as it is at that moment, and eight numbers a sample are added: time, place, velocity, clock rate.
    """
    dt = pace[3]
    leaning, turning = 1.0 - math.exp(-dt / pace[4]), 1.0 - math.exp(-dt / pace[5])
    linear, quadratic, wind_x, wind_y = pace[6], pace[7], pace[8], pace[9]
    p_pos, p_vel, i_vel, d_vel = pace[10], pace[11], pace[12], pace[13]
    slowing, most, every = 1.0 - math.exp(-dt / pace[14]), pace[15], int(pace[16])
    smooth = 1.0 - math.exp(-dt / pace[17])
    t, px, py, vx, vy, ix, iy = state[0], state[1], state[2], state[3], state[4], state[5], state[6]
    lx, ly, bx, by, fx, fy, rate = state[7], state[8], state[9], state[10], state[11], state[12], state[13]
    tx, ty, tz, wx, wy, wz = state[14], state[15], state[16], state[17], state[18], state[19]
    e0, e1, e2 = state[20], state[21], state[22]
    used, u, speed, ox, oy = int(state[23]), state[24], state[25], state[26], state[27]
    spline, fast = this[0] == 1.0, following[0] >= 0.0
    straight_next = fast and following[0] == 0.0
    ex, ey = this[1] + this[7] * this[4], this[2] + this[7] * this[5]  # where the leg ends
    passed, step = False, 0
    while not passed:
        # The path's clock slows down where the vehicle does not keep up.
        wanted, pace_now = 1.0, math.sqrt(wx * wx + wy * wy + wz * wz)
        if pace_now > 1e-6:
            ahead = (vx * wx + vy * wy + rate * wz * wz - p_pos * ((tx - px) * wx + (ty - py) * wy)) / (
                pace_now * pace_now
            )
            wanted = min(max(0.05 + ahead, 0.0), 1.0)
        rate += (wanted - rate) * slowing
        h = rate * dt
        # The target: what is left of the leg before, this leg, and the next one where they overlap.
        e1 += h
        ax = ay = 0.0
        if spline:
            tx, ty, tz, dx, dy, dz, length, top = bend(this, min(u, 1.0))
            left = math.sqrt((ex - tx) ** 2 + (ey - ty) ** 2 + (this[3] + this[7] * this[6] - tz) ** 2)
            most_along = along_limit(dx, dy, dz, this[17], this[18], this[18])
            top = min(top, math.sqrt(2 * most_along * left + this[13] * this[13]))
            speed = max(speed - most_along * h, top) if speed > top else min(speed + most_along * h, top)
            if u >= 1.0:  # at its end, where the vehicle is not yet: wait for it there
                speed = 0.0
            wx, wy, wz = speed * dx, speed * dy, speed * dz
            if length > 1e-6:
                u += speed * h / length
            else:
                size = 2 * math.sqrt(this[SEGMENTS + 6] ** 2 + this[SEGMENTS + 7] ** 2 + this[SEGMENTS + 8] ** 2)
                u += math.sqrt(2 * speed * h / size) if size > 1e-9 else 1.0
            finished = u >= 1.0
        else:
            a, v, s = along(this, e1)
            tx, ty, tz = this[1] + s * this[4], this[2] + s * this[5], this[3] + s * this[6]
            wx, wy, wz, ax, ay = v * this[4], v * this[5], v * this[6], a * this[4], a * this[5]
            if before[0] == 0.0:
                e0 += h
                a, v, s = along(before, e0)
                s -= before[7]
                tx, ty, tz = tx + s * before[4], ty + s * before[5], tz + s * before[6]
                wx, wy, wz = wx + v * before[4], wy + v * before[5], wz + v * before[6]
                ax, ay = ax + a * before[4], ay + a * before[5]
            rest = this[8] - e1
            finished = rest <= 0.0
            if straight_next:
                if e2 > 0.0:
                    e2 += h
                elif (
                    e1 >= this[9] and rest <= following[10] and rest > 0.0 and turn_is_gentle(this, following, e1, pace)
                ):
                    e2 = h / 2  # it could have begun anywhere within this step
                if e2 > 0.0:
                    a, v, s = along(following, e2)
                    tx, ty, tz = tx + s * following[4], ty + s * following[5], tz + s * following[6]
                    wx, wy, wz = wx + v * following[4], wy + v * following[5], wz + v * following[6]
                    ax, ay = ax + a * following[4], ay + a * following[5]
                    finished = finished or e2 >= rest
            speed = math.sqrt(wx * wx + wy * wy + wz * wz)
        # The controllers, on the vehicle as it will be at the end of the step: position to velocity to lean, what is
        # across the path served before what is along it.
        qx, qy = wx + p_pos * (tx - px - vx * dt) - vx - ox * dt, wy + p_pos * (ty - py - vy * dt) - vy - oy * dt
        gx, gy = smooth * (qx - fx), smooth * (qy - fy)
        fx, fy = fx + gx, fy + gy
        cx, cy = ax + p_vel * fx + ix + d_vel * gx / dt, ay + p_vel * fy + iy + d_vel * gy / dt
        jx, jy = ix + i_vel * fx * dt, iy + i_vel * fy * dt
        if cx * cx + cy * cy > most * most:
            flat = math.sqrt(wx * wx + wy * wy)
            if flat < 1e-9:
                size = most / math.sqrt(cx * cx + cy * cy)
                cx, cy = cx * size, cy * size
            else:
                dx, dy = wx / flat, wy / flat
                s = cx * dx + cy * dy
                cx, cy = cx - s * dx, cy - s * dy
                size = math.sqrt(cx * cx + cy * cy)
                if size > most:
                    cx, cy = cx * most / size, cy * most / size
                else:
                    room = math.sqrt(most * most - size * size)
                    s = min(max(s, -room), room)
                    cx, cy = cx + s * dx, cy + s * dy
            grown, was = math.sqrt(jx * jx + jy * jy), math.sqrt(ix * ix + iy * iy)
            if fx * cx + fy * cy > 0.0 and grown > was:  # no winding up
                jx, jy = jx * was / grown, jy * was / grown
        ix, iy = jx, jy
        # The vehicle: lean follows the command, drag acts along the leaning body.
        lx, ly = lx + (cx - lx) * leaning, ly + (cy - ly) * leaning
        bx, by = bx + (lx - bx) * turning, by + (ly - by) * turning
        lean = math.sqrt(bx * bx + by * by)
        nx, ny = (bx / lean, by / lean) if lean > 1e-9 else (1.0, 0.0)
        cosine = GRAVITY / math.sqrt(GRAVITY * GRAVITY + lean * lean)
        rx, ry = vx - wind_x, vy - wind_y
        onward, aside = rx * nx + ry * ny, ry * nx - rx * ny
        onward = onward * cosine - wz * rate * cosine * lean / GRAVITY
        drag = linear + quadratic * math.sqrt(onward * onward + aside * aside)
        onward, aside = lean - drag * onward / cosine, -drag * aside
        ox, oy = onward * nx - aside * ny, onward * ny + aside * nx
        vx, vy = vx + ox * dt, vy + oy * dt
        px, py = px + vx * dt, py + vy * dt
        t += dt
        step += 1
        if step % every == 0:
            if used + 8 > len(samples):
                return False
            samples[used], samples[used + 1], samples[used + 2], samples[used + 3] = t, px, py, tz
            samples[used + 4], samples[used + 5], samples[used + 6], samples[used + 7] = vx, vy, wz * rate, rate
            used += 8
        passed = finished and (fast or (px - ex) ** 2 + (py - ey) ** 2 <= pace[0] * pace[0])
    state[0], state[1], state[2], state[3], state[4], state[5], state[6] = t, px, py, vx, vy, ix, iy
    state[7], state[8], state[9], state[10], state[11], state[12], state[13] = lx, ly, bx, by, fx, fy, rate
    state[14], state[15], state[16], state[17], state[18], state[19] = tx, ty, tz, wx, wy, wz
    state[20], state[21], state[22], state[23], state[24], state[25] = e0, e1, e2, used, u, speed
    state[26], state[27] = ox, oy
    return True
