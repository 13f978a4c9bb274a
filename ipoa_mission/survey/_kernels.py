"""Transits and order of lines. Line k has the ends 2k and 2k + 1; entered at end e, it is left at e ^ 1."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit

NO_WAY = 1e9  # [s]
DIRECT, NONE = -1, -2
TOUCH_TOLERANCE = 0.05  # [m]


@njit(cache=True, error_model="numpy")
def seconds_of(clock, east, north):
    length = math.sqrt(east * east + north * north)
    count = clock.pace.size
    if count == 1:
        return length * clock.pace[0]
    at = math.atan2(north, east) / (2.0 * math.pi) * count
    low = math.floor(at)
    share, k = at - low, int(low) % count
    return length * ((1.0 - share) * clock.pace[k] + share * clock.pace[(k + 1) % count])


@njit(cache=True, error_model="numpy")
def corner_at(clock, cosine, length):
    """Return the time a corner adds [s]; `length` [m]: its shorter leg."""
    angles, lengths = clock.corner.shape
    a = math.acos(min(max(cosine, -1.0), 1.0)) / math.pi * (angles - 1)
    i = min(int(a), angles - 2)
    b = 0.0 if length <= clock.shortest else math.log(length / clock.shortest) / clock.ratio
    j = min(int(b), lengths - 2)
    b = min(b, lengths - 1.0)
    s, t, c = a - i, b - j, clock.corner
    return (1 - s) * ((1 - t) * c[i, j] + t * c[i, j + 1]) + s * ((1 - t) * c[i + 1, j] + t * c[i + 1, j + 1])


@njit(cache=True, error_model="numpy")
def path_seconds(clock, path):
    """Return the time of a polyline (n, 2), at speed at both ends [s]."""
    total, before, was_e, was_n = 0.0, 0.0, 0.0, 0.0
    for k in range(len(path) - 1):
        e, n = path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1]
        length = math.sqrt(e * e + n * n)
        if length < 1e-6:
            continue
        total += seconds_of(clock, e, n)
        if before > 0.0:
            total += corner_at(clock, (e * was_e + n * was_n) / (length * before), min(length, before))
        before, was_e, was_n = length, e, n
    return total


@njit(cache=True, error_model="numpy")
def _is_clear(edges, px, py, qx, qy):
    """Return whether a way from p to q crosses no edge."""
    west = min(px, qx)
    east = max(px, qx)
    south = min(py, qy)
    north = max(py, qy)
    for k in range(len(edges)):
        ax = edges[k, 0]
        ay = edges[k, 1]
        bx = edges[k, 2]
        by = edges[k, 3]
        if max(ax, bx) < west or min(ax, bx) > east or max(ay, by) < south or min(ay, by) > north:
            continue
        a = (qx - px) * (ay - py) - (qy - py) * (ax - px)
        b = (qx - px) * (by - py) - (qy - py) * (bx - px)
        if (a >= 0.0) == (b >= 0.0):
            continue
        p = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
        q = (bx - ax) * (qy - ay) - (by - ay) * (qx - ax)
        if (p > 0.0) != (q > 0.0):
            return False
    return True


@njit(cache=True, error_model="numpy")
def _goes_by(arms, corner, east, north):
    """Return whether both `arms` (4,) of a corner are on one side of a way."""
    one = east * arms[corner, 1] - north * arms[corner, 0]
    other = east * arms[corner, 3] - north * arms[corner, 2]
    return one * other >= 0.0 or min(abs(one), abs(other)) <= TOUCH_TOLERANCE


@njit(cache=True, error_model="numpy")
def straight_ways(places, place_arms, others, arms, edges):
    """Return straight distances from places (n, 2) to others (m, 2), or NO_WAY, (n, m) [m]; arms lead to neighbors."""
    away = np.empty((len(places), len(others)))
    for i in range(len(places)):
        for j in range(len(others)):
            e = others[j, 0] - places[i, 0]
            n = others[j, 1] - places[i, 1]
            is_way = _goes_by(place_arms, i, e, n) and _goes_by(arms, j, e, n)
            is_way = is_way and _is_clear(edges, places[i, 0], places[i, 1], others[j, 0], others[j, 1])
            away[i, j] = math.hypot(e, n) if is_way else NO_WAY
    return away


@njit(cache=True, error_model="numpy")
def _spread(start, near, between, bend, dist, prev):
    """Return the shortest ways from one end to all corners [m], and each previous corner."""
    count = near.shape[1]
    done = np.empty(count, np.bool_)
    for c in range(count):
        done[c], prev[start, c] = False, DIRECT
        dist[c] = bend + near[start, c] if near[start, c] < NO_WAY else NO_WAY
    for _ in range(count):
        here, least = -1, NO_WAY
        for c in range(count):
            if not done[c] and dist[c] < least:
                here, least = c, dist[c]
        if here < 0:
            break
        done[here] = True
        for k in range(between.begins[here], between.begins[here + 1]):
            there = between.columns[k]
            through = least + between.lengths[here, there] + bend
            if through < dist[there]:
                dist[there] = through
                prev[start, there] = here


@njit(cache=True, error_model="numpy")
def ways_between(clock, ends, corners, near, between, edges, bend):
    """Return the times of the ways between all line ends (n, n), corners at both ends included [s].

    `near` and `between`: straight `times.Ways` from ends to corners and between corners. Also return the last corner
    before an end (n, n) and before a corner (n, m), or DIRECT, or NONE for no way.
    """
    count = len(ends)
    room = max(len(corners), 1)
    times = np.empty((count, count))
    last = np.empty((count, count), np.int16)
    prev = np.empty((count, room), np.int16)
    dist = np.empty(room)
    for i in range(count):
        _spread(i, near.lengths, between, bend, dist, prev)
        out_e = ends[i, 0] - ends[i ^ 1, 0]
        out_n = ends[i, 1] - ends[i ^ 1, 1]
        out = math.hypot(out_e, out_n)
        for j in range(count):
            times[i, j], last[i, j] = NO_WAY, NONE
            if i == j or j == i ^ 1:
                continue
            if _is_clear(edges, ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]):
                last[i, j] = DIRECT
            else:
                least = NO_WAY
                for k in range(near.begins[j], near.begins[j + 1]):
                    corner = near.columns[k]
                    through = dist[corner] + near.lengths[j, corner]
                    if through < least:
                        least = through
                        last[i, j] = corner
                if last[i, j] == NONE:
                    continue
            in_e = ends[j ^ 1, 0] - ends[j, 0]
            in_n = ends[j ^ 1, 1] - ends[j, 1]
            length = math.hypot(in_e, in_n)
            total = 0.0
            c = last[i, j]
            x = ends[j, 0]
            y = ends[j, 1]
            while True:
                bx, by = (ends[i, 0], ends[i, 1]) if c == DIRECT else (corners[c, 0], corners[c, 1])
                e = x - bx
                n = y - by
                leg = math.hypot(e, n)
                if leg > 1e-6:
                    total += seconds_of(clock, e, n)
                    if length > 1e-6:
                        total += corner_at(clock, (e * in_e + n * in_n) / (leg * length), min(leg, length))
                    in_e, in_n, length = e, n, leg
                if c == DIRECT:
                    break
                x, y, c = bx, by, prev[i, c]
            if out > 1e-6 and length > 1e-6:
                total += corner_at(clock, (out_e * in_e + out_n * in_n) / (out * length), min(out, length))
            times[i, j] = total
    return times, last, prev


@njit(cache=True, error_model="numpy")
def _add_up(entries, times, lines, sums):
    """Sum costs up to each line."""
    forth, back = sums
    forth[1], back[1] = lines[entries[1]], lines[entries[1] ^ 1]
    for k in range(2, len(entries) - 1):
        here, there = entries[k - 1], entries[k]
        forth[k] = forth[k - 1] + times[here ^ 1, there] + lines[there]
        back[k] = back[k - 1] + times[there, here ^ 1] + lines[there ^ 1]


@njit(cache=True, error_model="numpy")
def _flip(entries, i, j):
    while i <= j:
        entries[i], entries[j] = entries[j] ^ 1, entries[i] ^ 1
        i, j = i + 1, j - 1


@njit(cache=True, error_model="numpy")
def _better(entries, k, times, lines, sums):
    """Return the best change at line k: 0 none, 1 flip, 2 move, 3 move and flip; and its indices."""
    beyond, (forth, back) = len(entries) - 1, sums
    best, kind, a, b, c = -1e-7, 0, 0, 0, 0
    before, head = entries[k - 1] ^ 1, entries[k]
    for i in range(1, k):
        y = entries[k + 1]
        delta = times[entries[i - 1] ^ 1, head ^ 1] + times[entries[i], y]
        delta -= times[entries[i - 1] ^ 1, entries[i]] + times[head ^ 1, y]
        delta += (back[k] - back[i] + lines[entries[i] ^ 1]) - (forth[k] - forth[i] + lines[entries[i]])
        if delta < best:
            best, kind, a, b = delta, 1, i, k
    for j in range(k, beyond):
        delta = times[before, entries[j] ^ 1] + times[head, entries[j + 1]]
        delta -= times[before, head] + times[entries[j] ^ 1, entries[j + 1]]
        delta += (back[j] - back[k] + lines[head ^ 1]) - (forth[j] - forth[k] + lines[head])
        if delta < best:
            best, kind, a, b = delta, 1, k, j
    for e in range(k, min(k + 3, beyond)):
        tail, after = entries[e] ^ 1, entries[e + 1]
        out = times[before, after] - times[before, head] - times[tail, after]
        if out > -1e-7:
            continue
        turned = (back[e] - back[k] + lines[head ^ 1]) - (forth[e] - forth[k] + lines[head])
        for p in range(beyond):
            if k - 1 <= p <= e:
                continue
            x, y = entries[p] ^ 1, entries[p + 1]
            gap = out - times[x, y]
            delta = gap + times[x, head] + times[tail, y]
            if delta < best:
                best, kind, a, b, c = delta, 2, k, e, p
            delta = gap + times[x, tail] + times[head, y] + turned
            if delta < best:
                best, kind, a, b, c = delta, 3, k, e, p
    return kind, a, b, c


@njit(cache=True, error_model="numpy")
def _move(entries, i, e, p):
    if p < i:
        _flip(entries, p + 1, e)
        _flip(entries, p + 1, p + e - i + 1)
        _flip(entries, p + e - i + 2, e)
    else:
        _flip(entries, i, p)
        _flip(entries, i, i + p - e - 1)
        _flip(entries, i + p - e, p)


@njit(cache=True, error_model="numpy")
def _descend(entries, times, lines, dirty, sums):
    """Improve at the dirty lines; return the cost [s]."""
    beyond = len(entries) - 1
    _add_up(entries, times, lines, sums)
    k, clean = 1, 0
    while clean < beyond:
        if dirty[k]:
            kind, a, b, c = _better(entries, k, times, lines, sums)
            if kind == 0:
                dirty[k] = False
            else:
                if kind != 2:
                    _flip(entries, a, b)
                at = a
                if kind != 1:
                    _move(entries, a, b, c)
                    at = c + 1 if c < a else c - (b - a)
                for m in (a, b, at, at + b - a):
                    for n in range(max(m - 1, 1), min(m + 2, beyond)):
                        dirty[n] = True
                _add_up(entries, times, lines, sums)
                clean = 0
                continue
        clean += 1
        k = k + 1 if k < beyond - 1 else 1
    return sums[0][beyond - 1] + times[entries[0] ^ 1, entries[1]] + times[entries[beyond - 1] ^ 1, entries[beyond]]


@njit(cache=True, error_model="numpy")
def _next(state):
    """Return the next of Marsaglia's xorshift numbers of 32 bits."""
    state ^= (state << 13) & 0xFFFFFFFF
    state ^= state >> 17
    return state ^ ((state << 5) & 0xFFFFFFFF)


@njit(cache=True, error_model="numpy")
def search_order(times, lines, rounds):
    """Return the ends (n,) at which lines are entered in a quick order, and its cost [s].

    `times` (2n + 2, 2n + 2): between ends; the tour's begin and end last. `lines` (2n,): by entry.
    """
    count = len(lines) // 2
    best, now = np.empty(count + 2, np.int64), np.empty(count + 2, np.int64)
    best[0], best[count + 1] = 2 * count + 1, 2 * count  # begin and end of the tour
    sums, dirty = (np.empty(count + 2), np.empty(count + 2)), np.empty(count + 2, np.bool_)
    for k in range(count):
        best[k + 1] = 2 * k
    for k in range(count + 2):
        dirty[k] = True
    cost = _descend(best, times, lines, dirty, sums)
    state = 2463534242
    failed = 0
    window = min(count, 30)
    while failed < rounds and count > 3:
        for k in range(count + 2):
            now[k] = best[k]
        state = _next(state)
        low = 1 + state % (count - window + 1)
        state = _next(state)
        first = low + state % window
        state = _next(state)
        second = low + state % window
        state = _next(state)
        third = low + state % window
        i = min(first, second, third)
        p = max(first, second, third)
        e = first + second + third - i - p
        if e < p:
            _move(now, i, e, p)
        else:
            _flip(now, i, p)
        for m in (i, i + p - e, p + 1):
            for n in range(max(m - 1, 1), min(m + 1, count + 1)):
                dirty[n] = True
        found = _descend(now, times, lines, dirty, sums)
        if found < cost - 1e-9:
            cost, failed = found, 0
            for k in range(count + 2):
                best[k] = now[k]
        else:
            failed += 1
    for k in range(count):
        now[k] = best[k + 1]
    return now[:count], cost
