"""Transits and order of lines. Line k has the ends 2k and 2k + 1; entered at one end, it is left at the other."""

# mypy: disable-error-code="no-untyped-def,misc"

import math
from typing import NamedTuple

import numpy as np

from ipoa_mission.compiled import njit

NO_WAY = 1e9  # [s]
DIRECT, NONE = -1, -2
TOUCH_TOLERANCE = 0.05  # [m]
LEAST_SAVING = 1e-7  # of a change [s]: less is rounding
MOST_MOVED = 3  # neighboring lines


class OrderChange(NamedTuple):
    """A change of an order: lines first to last are flipped, or moved behind another, or both."""

    seconds: float  # added; negative
    is_flip: bool
    is_move: bool
    first: int
    last: int
    behind: int


@njit(cache=True, error_model="numpy")
def seconds_of(leg_times, east, north):
    length = math.sqrt(east * east + north * north)
    count = leg_times.pace.size
    if count == 1:
        return length * leg_times.pace[0]
    at = math.atan2(north, east) / (2.0 * math.pi) * count
    low = math.floor(at)
    share, k = at - low, int(low) % count
    return length * ((1.0 - share) * leg_times.pace[k] + share * leg_times.pace[(k + 1) % count])


@njit(cache=True, error_model="numpy")
def corner_at(leg_times, cosine, length):
    """Return the time a corner adds [s]; `length` [m]: its shorter leg."""
    angles, lengths = leg_times.corner.shape
    a = math.acos(min(max(cosine, -1.0), 1.0)) / math.pi * (angles - 1)
    i = min(int(a), angles - 2)
    b = 0.0 if length <= leg_times.shortest else math.log(length / leg_times.shortest) / leg_times.ratio
    j = min(int(b), lengths - 2)
    b = min(b, lengths - 1.0)
    s, t, c = a - i, b - j, leg_times.corner
    return (1 - s) * ((1 - t) * c[i, j] + t * c[i, j + 1]) + s * ((1 - t) * c[i + 1, j] + t * c[i + 1, j + 1])


@njit(cache=True, error_model="numpy")
def path_seconds(leg_times, path):
    """Return the time of a polyline (n, 2), at speed at both ends [s]."""
    total, before, was_e, was_n = 0.0, 0.0, 0.0, 0.0
    for k in range(len(path) - 1):
        e, n = path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1]
        length = math.sqrt(e * e + n * n)
        if length < 1e-6:
            continue
        total += seconds_of(leg_times, e, n)
        if before > 0.0:
            total += corner_at(leg_times, (e * was_e + n * was_n) / (length * before), min(length, before))
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
def _shortest_ways(start, near, between, bend, dist, prev):
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
def _other(end):
    """Return the other end of a line."""
    return end ^ 1


@njit(cache=True, error_model="numpy")
def ways_between(leg_times, ends, corners, near, between, edges, bend):
    """Return the times of the ways between all line ends (n, n), corners at both ends included [s].

    `near` and `between`: straight `times.Ways` from ends to corners and between corners. Also return the last corner
    before an end (n, n) and before a corner (n, m), or DIRECT, or NONE for no way.
    """
    count = len(ends)
    size = max(len(corners), 1)
    times = np.empty((count, count))
    last = np.empty((count, count), np.int16)
    prev = np.empty((count, size), np.int16)
    dist = np.empty(size)
    for i in range(count):
        _shortest_ways(i, near.lengths, between, bend, dist, prev)
        out_e = ends[i, 0] - ends[_other(i), 0]
        out_n = ends[i, 1] - ends[_other(i), 1]
        out = math.hypot(out_e, out_n)
        for j in range(count):
            times[i, j], last[i, j] = NO_WAY, NONE
            if i == j or j == _other(i):
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
            in_e = ends[_other(j), 0] - ends[j, 0]
            in_n = ends[_other(j), 1] - ends[j, 1]
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
                    total += seconds_of(leg_times, e, n)
                    if length > 1e-6:
                        total += corner_at(leg_times, (e * in_e + n * in_n) / (leg * length), min(leg, length))
                    in_e, in_n, length = e, n, leg
                if c == DIRECT:
                    break
                x, y, c = bx, by, prev[i, c]
            if out > 1e-6 and length > 1e-6:
                total += corner_at(leg_times, (out_e * in_e + out_n * in_n) / (out * length), min(out, length))
            times[i, j] = total
    return times, last, prev


@njit(cache=True, error_model="numpy")
def _add_up(entries, times, lines, sums):
    """Sum the times of the lines up to each, and of their transits: in order, and of the reverse."""
    forth, back = sums
    forth[1] = lines[entries[1]]
    back[1] = lines[_other(entries[1])]
    for k in range(2, len(entries) - 1):
        here, there = entries[k - 1], entries[k]
        forth[k] = forth[k - 1] + times[_other(here), there] + lines[there]
        back[k] = back[k - 1] + times[there, _other(here)] + lines[_other(there)]


@njit(cache=True, error_model="numpy")
def _flip(entries, first, last):
    """Fly lines first to last in reverse order, each from its other end."""
    while first <= last:
        entries[first], entries[last] = _other(entries[last]), _other(entries[first])
        first += 1
        last -= 1


@njit(cache=True, error_model="numpy")
def _back_less_forth(entries, first, last, lines, sums):
    """Return the time that lines first to last take longer in reverse [s]."""
    forth, back = sums
    entry = entries[first]
    reverse = back[last] - back[first] + lines[_other(entry)]
    return reverse - (forth[last] - forth[first] + lines[entry])


@njit(cache=True, error_model="numpy")
def _transits_of_flip(entries, first, last, times):
    """Return the time that a flip of lines first to last adds to the transits before and after them [s]."""
    before, after = _other(entries[first - 1]), entries[last + 1]
    entry, leave = entries[first], _other(entries[last])
    flipped = times[before, leave] + times[entry, after]
    return flipped - (times[before, entry] + times[leave, after])


@njit(cache=True, error_model="numpy")
def _best_change(entries, k, times, lines, sums):
    """Return the `OrderChange` at line k that saves most.

    It flips lines that begin or end with k, or moves up to three lines from k on between two others.
    """
    beyond = len(entries) - 1
    best = OrderChange(-LEAST_SAVING, False, False, 0, 0, 0)
    for first in range(1, k):
        added = _transits_of_flip(entries, first, k, times) + _back_less_forth(entries, first, k, lines, sums)
        if added < best.seconds:
            best = OrderChange(added, True, False, first, k, 0)
    for last in range(k, beyond):
        added = _transits_of_flip(entries, k, last, times) + _back_less_forth(entries, k, last, lines, sums)
        if added < best.seconds:
            best = OrderChange(added, True, False, k, last, 0)
    before, entry = _other(entries[k - 1]), entries[k]
    for last in range(k, min(k + MOST_MOVED, beyond)):
        leave, after = _other(entries[last]), entries[last + 1]
        removal = times[before, after] - times[before, entry] - times[leave, after]
        if removal > -LEAST_SAVING:  # an insertion only adds, where no detour is quicker than the direct way
            continue
        in_reverse = _back_less_forth(entries, k, last, lines, sums)
        for behind in range(beyond):
            if k - 1 <= behind <= last:
                continue
            here, there = _other(entries[behind]), entries[behind + 1]
            parted = removal - times[here, there]
            added = parted + times[here, entry] + times[leave, there]
            if added < best.seconds:
                best = OrderChange(added, False, True, k, last, behind)
            added = parted + times[here, leave] + times[entry, there] + in_reverse
            if added < best.seconds:
                best = OrderChange(added, True, True, k, last, behind)
    return best


@njit(cache=True, error_model="numpy")
def _move(entries, first, last, behind):
    """Move lines first to last behind another line; a rotation is three flips."""
    count = last - first + 1
    if behind < first:
        _flip(entries, behind + 1, last)
        _flip(entries, behind + 1, behind + count)
        _flip(entries, behind + count + 1, last)
    else:
        _flip(entries, first, behind)
        _flip(entries, first, behind - count)
        _flip(entries, behind - count + 1, behind)


@njit(cache=True, error_model="numpy")
def _descend(entries, times, lines, dirty, sums):
    """Change the order at its dirty lines while that saves time; return its time [s]."""
    beyond = len(entries) - 1
    _add_up(entries, times, lines, sums)
    k, clean = 1, 0
    while clean < beyond:
        if dirty[k]:
            change = _best_change(entries, k, times, lines, sums)
            first, last, at = change.first, change.last, change.first
            if change.is_flip:
                _flip(entries, first, last)
            if change.is_move:
                _move(entries, first, last, change.behind)
                at = change.behind + 1 if change.behind < first else change.behind - (last - first)
            if change.is_flip or change.is_move:
                for changed in (first, last, at, at + last - first):
                    for n in range(max(changed - 1, 1), min(changed + 2, beyond)):
                        dirty[n] = True
                _add_up(entries, times, lines, sums)
                clean = 0
                continue
            dirty[k] = False
        clean += 1
        k = k + 1 if k < beyond - 1 else 1
    return sums[0][beyond - 1] + times[_other(entries[0]), entries[1]] + times[_other(entries[-2]), entries[-1]]


@njit(cache=True, error_model="numpy")
def _next(state):
    """Return the next of Marsaglia's xorshift numbers of 32 bits."""
    state ^= (state << 13) & 0xFFFFFFFF
    state ^= state >> 17
    return state ^ ((state << 5) & 0xFFFFFFFF)


@njit(cache=True, error_model="numpy")
def search_order(times, lines, rounds):
    """Return the ends (n,) at which lines are entered in a quick order, and its time [s].

    Iterated local search: a random move or flip within 30 lines, then a descent. It ends after `rounds` changes
    without a gain.

    `times` (2n + 2, 2n + 2): between ends; the tour's begin and end last. `lines` (2n,): by entry [s].
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
    state = 2463534242  # Marsaglia's example
    failed = 0
    window = min(count, 30)
    while failed < rounds and count > 3:
        for k in range(count + 2):
            now[k] = best[k]
        state = _next(state)
        low = 1 + state % (count - window + 1)
        state = _next(state)
        one = low + state % window
        state = _next(state)
        two = low + state % window
        state = _next(state)
        three = low + state % window
        first = min(one, two, three)
        behind = max(one, two, three)
        last = one + two + three - first - behind
        if last < behind:
            _move(now, first, last, behind)
        else:
            _flip(now, first, behind)
        for parted in (first, first + behind - last, behind + 1):
            for n in range(max(parted - 1, 1), min(parted + 1, count + 1)):
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
