"""PX4 towards one waypoint, step by step: the smoothed trajectory, and the vehicle that follows it.

Plain scalar code over flat sequences, so that the same lines run as Python (on lists) and compiled (on arrays): see
`_compiled`. `px4` packs the arguments and says what they mean.
"""

import math
from collections.abc import Callable, MutableSequence, Sequence
from typing import Any

jit: Callable[[Any], Any] = globals().get("jit", lambda function: function)

GRAVITY = 9.80665
STAGES = 3  # of being sure to have landed: in contact, perhaps landed, landed
ON_LINE, BEYOND, BEFORE, BESIDE = 0, 1, 2, 3  # where the vehicle is, seen from its leg
AT_TARGET = 1e-5  # nearer than this PX4 steers nowhere [m]
STANDING = 1e-6  # a trajectory slower than this stands still, and always waits for the vehicle [m/s]
HOVER_SURE, HOVER_SURE_UP = 10.0, 2.0  # up to these speeds the hover thrust is learned well: HTE_VXY_THR, HTE_VZ_THR
#: Two multiplicative congruences (L'Ecuyer, 1988), whose products are exact in floating point.
FACTOR, MODULUS = 40014.0, 2147483563.0
FACTOR_2, MODULUS_2 = 40692.0, 2147483399.0


@jit
def speed_to(distance: float, leave: float, accel: float, jerk: float) -> float:
    """The speed from which one comes down to `leave` within `distance`, acceleration turning round in 2 a/j first.

    v^2 + (4 a^2/j) v = leave^2 + 2 a d, and never less than `leave`.
    """
    half = 2.0 * accel * accel / jerk
    return max(math.sqrt(half * half + 2.0 * accel * distance + leave * leave) - half, leave)


@jit
def quickest(v: float, a: float, goal: float, accel: float, jerk: float) -> tuple[float, float, float, float]:
    """The quickest jerk-limited change from speed v and acceleration a to `goal` at rest of acceleration.

    Signed jerk j and the durations of j, 0 and -j. With p the greatest acceleration, p^2 = j (goal - v) + a^2/2.
    """
    miss = goal - v - a * abs(a) / (2.0 * jerk)
    if miss == 0.0 and a == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    j = math.copysign(jerk, miss if miss != 0.0 else a)
    p = math.copysign(math.sqrt(max(j * (goal - v) + a * a / 2.0, 0.0)), j)
    coast = 0.0
    if abs(p) > accel:
        p = math.copysign(accel, j)
        coast = max((goal - v - (2.0 * p * p - a * a) / (2.0 * j)) / p, 0.0)
    first = (p - a) / j
    if first < 0.0:  # already beyond the greatest acceleration: only bring it down
        return j, 0.0, coast, a / j
    return j, first, coast, p / j


@jit
def stretched(v: float, a: float, goal: float, accel: float, j: float, lasts: float) -> tuple[float, float, float]:
    """The same change made to last `lasts`: durations of j, 0 and -j, by a smaller greatest acceleration p.

    p^2 - (j T + a) p + j (goal - v) + a^2/2 = 0, of which the smaller in the direction of j.
    """
    b = j * lasts + a
    root = math.sqrt(max(b * b - 4.0 * (j * (goal - v) + a * a / 2.0), 0.0))
    p = (b - root) / 2.0 if j > 0.0 else (b + root) / 2.0
    p = min(max(p, -accel), accel)
    first, last = max((p - a) / j, 0.0), max(p / j, 0.0)
    return first, max(lasts - first - last, 0.0), last


@jit
def moved(
    x: float, v: float, a: float, j: float, first: float, coast: float, last: float, t: float
) -> tuple[float, float, float]:
    """Place, speed and acceleration t seconds into a change that lasts first + coast + last."""
    d = min(t, first)
    if d > 0.0:
        x, v, a = x + d * (v + d * (a / 2.0 + d * j / 6.0)), v + d * (a + d * j / 2.0), a + d * j
        t -= d
    d = min(t, coast)
    if d > 0.0:
        x, v = x + d * (v + d * a / 2.0), v + d * a
        t -= d
    d = min(t, last)
    if d > 0.0:
        x, v, a = x + d * (v + d * (a / 2.0 - d * j / 6.0)), v + d * (a - d * j / 2.0), a - d * j
        t -= d
    if t > 0.0:
        x, a = x + t * v, 0.0
    return x, v, a


@jit
def half_tangent(cosine: float) -> float:
    """The tangent of half the angle whose cosine this is; of a straight line very much."""
    return math.sqrt(max(1.0 - cosine, 0.0) / max(1.0 + cosine, 1e-14))


@jit
def corner_speed(
    tox: float, toy: float, onx: float, ony: float, accel: float, jerk: float, cruise: float, gain: float, radius: float
) -> float:
    """The level speed now, (tox, toy) before a target that is left along (onx, ony).

    At the target: that of the circle that touches both legs at the acceptance radius, at `gain` of the acceleration;
    nothing where the next leg has no length or is shorter than the radius.
    """
    distance, onward = math.sqrt(tox * tox + toy * toy), math.sqrt(onx * onx + ony * ony)
    leave = 0.0
    if onward > 0.001 and onward >= radius:
        cosine = 0.0 if distance < 1e-9 else -(tox * onx + toy * ony) / (distance * onward)
        turn = math.sqrt(gain * accel * radius * half_tangent(cosine))
        leave = min(turn, speed_to(onward, 0.0, accel, jerk), cruise)
    speed: float = speed_to(distance, leave, accel, jerk)
    return min(cruise, speed)


@jit
def vertical_speed(
    now: float, z: float, at: float, height: float, then: float, next_height: float,
    top: float, accel: float, jerk: float, radius: float,
) -> float:  # fmt: skip
    """The vertical speed now, so that the target's height can be passed on the way to the next one.

    The angle at the target is seen in the plane of height and distance from the origin (`now`, `at`, `then`), as PX4
    has it.
    """
    leave = 0.0
    if abs(next_height - height) > 0.001:
        back, down, on, up = at - now, height - z, at - then, height - next_height
        size = math.sqrt((back * back + down * down) * (on * on + up * up))
        cosine = (back * on + down * up) / size if size > 1e-9 else 0.0
        leave = min(math.sqrt(accel * radius * half_tangent(cosine)), top)
    speed: float = speed_to(abs(height - z), leave, accel, jerk)
    return min(top, speed)


@jit
def sinking(
    height: float, low: float, high: float, slow: float, fast: float, crawl_below: float, crawl_speed: float
) -> float:
    """How fast a landing sinks: `fast` above `high`, from there ever slower to `slow` at `low`; at last it crawls."""
    if height <= crawl_below:
        return crawl_speed
    share = (height - low) / max(high - low, 1e-6)
    return slow + min(max(share, 0.0), 1.0) * (fast - slow)


@jit
def normal(first: float, second: float) -> tuple[float, float, float, float]:
    """The next two seeds, and two normally distributed numbers (Box and Muller)."""
    first, second = first * FACTOR % MODULUS, second * FACTOR_2 % MODULUS_2
    size, angle = math.sqrt(-2.0 * math.log(first / MODULUS)), 2.0 * math.pi * second / MODULUS_2
    return first, second, size * math.cos(angle), size * math.sin(angle)


@jit
def fly_to(
    way: Sequence[float], pace: Sequence[float], state: MutableSequence[float], samples: MutableSequence[float]
) -> bool:
    """Fly until the target counts as reached, and is noticed to be; False if that is not within `way[13]` seconds.

    Having been at the target is enough, but it does not count before the nose points where it should (`way[14]`);
    before `way[15]` the vehicle brakes and stays, for its nose to turn first.

    `state` is left as it is at that moment (26: when it was reached). Every so many steps (pace[2]; 0: never) seven
    numbers are added to the samples: time, place, velocity. A landing (way[12] < 0) sinks over the target, and has
    reached it when it stands on the ground and is sure of it: the thrust is low and the speed that is believed upwards
    is small, for as long as each of three stages takes.
    """
    radius, height_radius, cruise = way[9], way[10], way[11]
    climbing_off, landing, patience, headed, starts = way[12] > 0.0, way[12] < 0.0, way[13], way[14], way[15]
    dt, latency, every = pace[0], pace[1], int(pace[2])
    accel, jerk, gain, most_error, most_speed = pace[3], pace[4], pace[5], pace[6], pace[7]
    up, down, accel_up, accel_down = pace[8], pace[9], pace[10], pace[11]
    slow_up, slow_accel, slow_below = pace[12], pace[13], pace[14]
    p_xy, p_v, i_v, d_v, lean, p_z, p_vz = pace[15], pace[16], pace[17], pace[18], pace[19], pace[20], pace[21]
    leaning, turning, drag, wind_x, wind_y = pace[22], pace[23], pace[24], pace[25], pace[26]
    i_vz, learning, untold, noise_step, noise, beyond, until = (
        pace[27], pace[28], pace[29], pace[30], pace[31], pace[32], pace[33],
    )  # fmt: skip
    drift, drift_up, kept, most_up, most_down = pace[34], pace[35], pace[36], pace[37], pace[38]
    land_low, land_speed, crawl_below, crawl_speed = pace[39], pace[40], pace[41], pace[42]
    ramp = pace[43]
    seen_late, low_thrust, at_rest, stage_seen, stage_lost = pace[44], pace[45], pace[46], pace[47], pace[48]
    t, x, y, z, vx, vy, vz = state[0], state[1], state[2], state[3], state[4], state[5], state[6]
    ix, iy, lx, ly, bx, by, az = state[7], state[8], state[9], state[10], state[11], state[12], state[13]
    tx, ty, tz, ux, uy, uz = state[14], state[15], state[16], state[17], state[18], state[19]
    cx, cy, cz, held, used, rising = state[20], state[21], state[22], state[23], int(state[24]), state[25] > 0.0
    seed, fx, fy, home, wait = state[27], state[28], state[29], state[30], state[31]
    sx, sy, sz, told, due, iz = state[32], state[33], state[34], state[35], state[36], state[37]
    hover, off, seed_2 = state[38], state[39], state[40]
    ax, ay, az_, gx, gy, gz, nx, ny, nz = (
        way[0], way[1], way[2], way[3], way[4], way[5], way[6], way[7], way[8],
    )  # fmt: skip
    legx, legy = way[3] - way[0], way[4] - way[1]
    leg = math.sqrt(legx * legx + legy * legy)
    seen, step, mode, corrected = -1.0, 0, ON_LINE, False
    begun, grounded, stands, lost, sure, since = t, climbing_off and z <= 0.0, False, False, 0, t
    while True:
        shift = 0.0 if climbing_off else told  # a take-off first climbs to where home was
        # Where to steer: along the leg, unless the vehicle has passed its end, is before its start, or beside it.
        if leg > 1e-6:
            along = ((x - way[0]) * legx + (y - way[1]) * legy) / leg
            was, mode = mode, ON_LINE
            if along > leg:
                mode = BEYOND
            elif along < 0.0 and (x - way[0]) ** 2 + (y - way[1]) ** 2 > radius * radius:
                mode = BEFORE
            elif abs((x - way[0]) * legy - (y - way[1]) * legx) > radius * leg:
                mode = BESIDE
            if mode != was or mode == BESIDE or corrected:
                corrected = False
                ax, ay, az_, gx, gy, gz = x, y, z - shift, way[3], way[4], way[5]
                nx, ny, nz = way[6], way[7], way[8]
                if mode == ON_LINE:
                    ax, ay, az_ = way[0], way[1], way[2]
                elif mode == BEFORE:
                    gx, gy, gz, nx, ny, nz = way[0], way[1], way[2], way[3], way[4], way[5]
                elif mode == BESIDE:
                    gx, gy = way[0] + along * legx / leg, way[1] + along * legy / leg
                    nx, ny, nz = way[3], way[4], way[5]
        # The speeds that the waypoints allow; in a turn the speed may not rise and the aim is a point on the line.
        below = tz - shift  # heights over home as the guidance has it
        qx, qy, qz = gx - tx, gy - ty, gz - below
        far, speed = math.sqrt(qx * qx + qy * qy), math.sqrt(ux * ux + uy * uy)
        fast = corner_speed(qx, qy, nx - gx, ny - gy, accel, jerk, cruise, gain, radius)
        if speed > 0.2 and far > radius and ux * qx + uy * qy < 0.98 * speed * far:
            fast = min(held, fast)
            dx, dy, dz = gx - ax, gy - ay, gz - az_
            size = math.sqrt(dx * dx + dy * dy + dz * dz)
            if size > 1e-6:
                dx, dy, dz = dx / size, dy / size, dz / size
                onto = (tx - ax) * dx + (ty - ay) * dy + (below - az_) * dz
                qx, qy, qz = ax + onto * dx - tx, ay + onto * dy - ty, az_ + onto * dz - below
                ahead = max(radius, 5.0)
                ahead = math.sqrt(max(ahead * ahead - qx * qx - qy * qy - qz * qz, 0.0))
                qx, qy, qz = qx + ahead * dx, qy + ahead * dy, qz + ahead * dz
        else:
            held = fast
        low = climbing_off and z < slow_below
        top = (slow_up if low else up) if rising else down
        top_accel = (min(accel_up, slow_accel) if low else accel_up) if rising else accel_down
        rise = vertical_speed(
            math.sqrt(tx * tx + ty * ty), below, math.sqrt(gx * gx + gy * gy), gz, math.sqrt(nx * nx + ny * ny), nz,
            top, top_accel, jerk, height_radius,
        )  # fmt: skip
        # The velocity wanted points at the aim; both its level and its vertical part keep their limits.
        size = far if landing else math.sqrt(qx * qx + qy * qy + qz * qz)
        wx = wy = wz = 0.0
        if landing:
            if size > AT_TARGET:
                wx, wy = qx * fast / size, qy * fast / size
            lost = lost or (stands and (sz > 0.0 or crawl_below <= 0.0))  # once believed below the ground
            height = crawl_below + 1.0 if lost else z - seen_late * vz
            wz = -sinking(height, land_low, slow_below, land_speed, down, crawl_below, crawl_speed)
        elif size > AT_TARGET:
            size = math.sqrt(fast * fast + rise * rise) / size
            wx, wy, wz = qx * size, qy * size, qz * size
            level = math.sqrt(wx * wx + wy * wy)
            if level > fast:
                size = fast / level
                wx, wy = wx * size, wy * size
                if fast >= 0.5 or level >= 0.5:
                    wz *= size
            if abs(wz) > rise:
                size = rise / abs(wz)
                if rise >= 0.5 or abs(wz) >= 0.5:
                    wx, wy = wx * size, wy * size
                wz *= size
        if t < starts:
            wx = wy = wz = 0.0
        rising = wz > 0.0
        if low:
            tz = z
        wx, wy = min(max(wx, -most_speed), most_speed), min(max(wy, -most_speed), most_speed)
        wz = min(max(wz, -top), top)
        # The trajectory: three changes of speed that end together; its time is stretched where the vehicle lags.
        jx, x1, x2, x3 = quickest(ux, cx, wx, accel, jerk)
        jy, y1, y2, y3 = quickest(uy, cy, wy, accel, jerk)
        jz, z1, z2, z3 = quickest(uz, cz, wz, top_accel, jerk)
        longest = max(x1 + x2 + x3, y1 + y2 + y3, z1 + z2 + z3)
        if jx != 0.0 and x1 + x2 + x3 < longest:
            x1, x2, x3 = stretched(ux, cx, wx, accel, jx, longest)
        if jy != 0.0 and y1 + y2 + y3 < longest:
            y1, y2, y3 = stretched(uy, cy, wy, accel, jy, longest)
        if jz != 0.0 and z1 + z2 + z3 < longest:
            z1, z2, z3 = stretched(uz, cz, wz, top_accel, jz, longest)
        ox, oy = tx - x, ty - y
        lags = speed < STANDING or ox * ux + oy * uy >= 0.0
        behind = ox * ox + oy * oy if lags else 0.0
        h = dt * (1.0 - min(math.sqrt(behind) / most_error, 1.0))
        tx, ux, cx = moved(tx, ux, cx, jx, x1, x2, x3, h)
        ty, uy, cy = moved(ty, uy, cy, jy, y1, y2, y3, h)
        tz, uz, cz = moved(tz, uz, cz, jz, z1, z2, z3, h)
        # The controllers, on the vehicle as it will be at the end of the step: place to speed, speed to lean.
        ex, ey = p_xy * (tx - x - vx * dt) + ux, p_xy * (ty - y - vy * dt) + uy
        size = math.sqrt(ex * ex + ey * ey)
        if size > most_speed:
            ex, ey = ex * most_speed / size, ey * most_speed / size
        ex, ey = ex - vx - fx * dt, ey - vy - fy * dt
        mx, my = cx + p_v * ex + ix - d_v * fx, cy + p_v * ey + iy - d_v * fy
        # A take-off begins with a limit of the climb that gives no thrust, and rises; until then nothing is foreseen.
        highest, foreseen = most_up, cz
        if climbing_off and t - begun < ramp:
            highest, foreseen = ((t - begun) / ramp) * (most_up + GRAVITY / p_vz) - GRAVITY / p_vz, 0.0
        ez = min(max(uz + p_z * (tz - z), -most_down), highest) - vz
        mz = max(foreseen + p_vz * ez + iz, -GRAVITY)
        size = math.sqrt(mx * mx + my * my)
        share = 1.0 if size <= lean else lean / size
        # Where less is had than asked for, by the greatest lean or by less thrust, the integrator is led back.
        back = 2.0 / p_v * max(1.0 - share * (1.0 + mz / GRAVITY) / hover, 0.0)
        ix, iy = ix + i_v * (ex - back * mx) * dt, iy + i_v * (ey - back * my) * dt
        if ez > 0.0 or mz > -GRAVITY:
            iz += i_vz * ez * dt
        mx, my = mx * share, my * share
        # The vehicle: lean and thrust follow the command, drag is linear; the thrust that hovering takes is learned as
        # if there were none, so a climb makes it too large.
        lx, ly = lx + (mx - lx) * leaning, ly + (my - ly) * leaning
        bx, by = bx + (lx - bx) * turning, by + (ly - by) * turning
        az += (mz - az) * turning
        lift = 1.0 + az / GRAVITY
        doubt = 1.0 + 10.0 * max(abs(vz) - HOVER_SURE_UP, math.sqrt(vx * vx + vy * vy) - HOVER_SURE, 0.0)
        learned = (1.0 / learning + 1.0 / max(t - off, 1.0)) * dt / doubt
        if grounded:
            off = t
        elif not stands:
            hover += (1.0 + drag * vz / GRAVITY - hover) * min(learned, 1.0)
        fx, fy = bx * lift - drag * (vx - wind_x), by * lift - drag * (vy - wind_y)
        grounded = grounded and az <= 0.0
        stands = landing and (stands or z <= 0.0)
        if stands:  # the place stays, and what is believed of its speed is wrong
            vx, vy, vz = -sx, -sy, -sz
        elif not grounded:
            vx, vy, vz = vx + fx * dt, vy + fy * dt, vz + (az - drag * vz) * dt
            x, y, z = x + (vx + sx) * dt, y + (vy + sy) * dt, z + (vz + sz) * dt
        t += dt
        step += 1
        if step * dt > patience:
            return False
        if every > 0 and step % every == 0:
            samples[used], samples[used + 1], samples[used + 2], samples[used + 3] = t, x, y, z
            samples[used + 4], samples[used + 5], samples[used + 6] = vx, vy, vz
            used += 7
        # What the vehicle measures is noisy: place and speed do not quite agree, and at first home's height is
        # corrected, which moves all waypoints, for the navigator at once and for the guidance a little later.
        wait -= dt
        if wait <= 0.0 and noise > 0.0:
            wait += noise_step
            seed, seed_2, n1, n2 = normal(seed, seed_2)
            sx, sy = kept * sx + drift * n1, kept * sy + drift * n2
            seed, seed_2, n1, n2 = normal(seed, seed_2)
            sz = kept * sz + drift_up * n1
            if t < until and abs(noise * n2 - home) > beyond:
                home = noise * n2
                due = t + untold if due < 0.0 else due
        if due >= 0.0 and t >= due:
            told, due, corrected = home, -1.0, True
        # Reached, and noticed to be a little later.
        if seen < 0.0:
            reached = False
            if landing:
                if not stands or abs(vz) >= at_rest or (sure == 0 and mz > low_thrust):
                    sure, since = 0, t
                elif t - since >= (stage_lost if lost else stage_seen):
                    sure, since = sure + 1, t
                reached = sure == STAGES
            elif climbing_off:
                reached = z > way[5] - height_radius
            else:
                near = (x - way[3]) ** 2 + (y - way[4]) ** 2 <= radius * radius
                reached = near and abs(z - home - way[5]) <= height_radius
            if reached:
                seen = t
        if seen >= 0.0 and t - max(seen, headed) >= latency:
            seen = max(seen, headed)
            break
    state[0], state[1], state[2], state[3], state[4], state[5], state[6] = t, x, y, z, vx, vy, vz
    state[7], state[8], state[9], state[10], state[11], state[12], state[13] = ix, iy, lx, ly, bx, by, az
    state[14], state[15], state[16], state[17], state[18], state[19] = tx, ty, tz, ux, uy, uz
    state[20], state[21], state[22], state[23], state[24], state[25] = cx, cy, cz, held, used, 1.0 if rising else -1.0
    state[26], state[27], state[28], state[29], state[30], state[31] = seen, seed, fx, fy, home, wait
    state[32], state[33], state[34], state[35], state[36], state[37] = sx, sy, sz, told, due, iz
    state[38], state[39], state[40] = hover, off, seed_2
    return True
