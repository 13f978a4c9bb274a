"""Line k has the ends 2k and 2k + 1; entered at end e, it is left at e ^ 1."""

# mypy: disable-error-code="no-untyped-def,misc"

import math

import numpy as np

from ipoa_mission.compiled import njit

NO_WAY = 1e9  # [s]
DIRECT, NONE = -1, -2
TOUCH_TOLERANCE = 0.05  # [m]
BOX_EDGES = 8  # successive edges that share a bounding box


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
def _boxes(edges):
    """Return west, east, south, north (k, 4) of each `BOX_EDGES` edges (m, 4)."""
    boxes = np.empty(((len(edges) + BOX_EDGES - 1) // BOX_EDGES, 4))
    for box in range(len(boxes)):
        boxes[box] = np.inf, -np.inf, np.inf, -np.inf
        for k in range(box * BOX_EDGES, min((box + 1) * BOX_EDGES, len(edges))):
            boxes[box, 0] = min(boxes[box, 0], edges[k, 0], edges[k, 2])
            boxes[box, 1] = max(boxes[box, 1], edges[k, 0], edges[k, 2])
            boxes[box, 2] = min(boxes[box, 2], edges[k, 1], edges[k, 3])
            boxes[box, 3] = max(boxes[box, 3], edges[k, 1], edges[k, 3])
    return boxes


@njit(cache=True, error_model="numpy")
def _is_clear(edges, boxes, px, py, qx, qy):
    west, east, south, north = min(px, qx), max(px, qx), min(py, qy), max(py, qy)
    for box in range(len(boxes)):
        if boxes[box, 1] < west or boxes[box, 0] > east or boxes[box, 3] < south or boxes[box, 2] > north:
            continue
        for k in range(box * BOX_EDGES, min((box + 1) * BOX_EDGES, len(edges))):
            ax, ay, bx, by = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
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
def sights(places, others, edges):
    """Return which `others` (m, 2) each place (n, 2) sees past the edges (k, 4), (n, m)."""
    seen, boxes = np.empty((len(places), len(others)), np.bool_), _boxes(edges)
    for i in range(len(places)):
        for j in range(len(others)):
            seen[i, j] = _is_clear(edges, boxes, places[i, 0], places[i, 1], others[j, 0], others[j, 1])
    return seen


@njit(cache=True, error_model="numpy")
def _goes_by(arms, corner, east, north):
    """Return whether both `arms` (4,) of a corner are on one side of a way."""
    one = east * arms[corner, 1] - north * arms[corner, 0]
    other = east * arms[corner, 3] - north * arms[corner, 2]
    return one * other >= 0.0 or min(abs(one), abs(other)) <= TOUCH_TOLERANCE


@njit(cache=True, error_model="numpy")
def straight_ways(corners, arms, edges):
    """Return straight distances between corners (n, 2), or NO_WAY, (n, n) [m]; `arms` (n, 4) lead to neighbors."""
    count = len(corners)
    apart, boxes = np.empty((count, count)), _boxes(edges)
    for i in range(count):
        apart[i, i] = NO_WAY
        for j in range(i):
            away, e, n = NO_WAY, corners[j, 0] - corners[i, 0], corners[j, 1] - corners[i, 1]
            is_way = _goes_by(arms, i, e, n) and _goes_by(arms, j, e, n)
            if is_way and _is_clear(edges, boxes, corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]):
                away = math.hypot(e, n)
            apart[i, j] = apart[j, i] = away
    return apart


@njit(cache=True, error_model="numpy")
def _near(ends, corners, arms, edges):
    """Return straight distances from ends (n, 2) to corners (m, 2), or NO_WAY, (n, m) [m]."""
    away, boxes = np.empty((len(ends), len(corners))), _boxes(edges)
    for i in range(len(ends)):
        for c in range(len(corners)):
            e, n = corners[c, 0] - ends[i, 0], corners[c, 1] - ends[i, 1]
            is_way = _goes_by(arms, c, e, n)
            is_way = is_way and _is_clear(edges, boxes, ends[i, 0], ends[i, 1], corners[c, 0], corners[c, 1])
            away[i, c] = math.hypot(e, n) if is_way else NO_WAY
    return away


@njit(cache=True, error_model="numpy")
def _lists(apart):
    """Return the columns of each row (n, m) below NO_WAY, concatenated, and each row's begin."""
    begins = np.empty(len(apart) + 1, np.int32)
    begins[0] = 0
    for i in range(len(apart)):
        begins[i + 1] = begins[i]
        for c in range(apart.shape[1]):
            begins[i + 1] += apart[i, c] < NO_WAY
    found, k = np.empty(begins[-1], np.int32), 0
    for i in range(len(apart)):
        for c in range(apart.shape[1]):
            if apart[i, c] < NO_WAY:
                found[k] = c
                k += 1
    return begins, found


@njit(cache=True, error_model="numpy")
def _spread(start, near, between, begins, others, bend, dist, prev):
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
        for k in range(begins[here], begins[here + 1]):
            through = least + between[here, others[k]] + bend
            if through < dist[others[k]]:
                dist[others[k]], prev[start, others[k]] = through, here


@njit(cache=True, error_model="numpy")
def ways_between(clock, ends, corners, arms, between, edges, bend):
    """Return the times of the ways between all line ends (n, n), corners at both ends included [s].

    Also return the last corner before an end (n, n) and before a corner (n, corners), or DIRECT, or NONE for no way.
    """
    count, many = len(ends), len(corners)
    near, boxes = _near(ends, corners, arms, edges), _boxes(edges)
    begins, others = _lists(between)
    first, near_corners = _lists(near)
    times, last = np.empty((count, count)), np.empty((count, count), np.int16)
    prev = np.empty((count, max(many, 1)), np.int16)
    dist = np.empty(max(many, 1))
    for i in range(count):
        _spread(i, near, between, begins, others, bend, dist, prev)
        out_e, out_n = ends[i, 0] - ends[i ^ 1, 0], ends[i, 1] - ends[i ^ 1, 1]
        out = math.hypot(out_e, out_n)
        for j in range(count):
            times[i, j], last[i, j] = NO_WAY, NONE
            if i == j or j == i ^ 1:
                continue
            if _is_clear(edges, boxes, ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]):
                last[i, j] = DIRECT
            else:
                least = NO_WAY
                for k in range(first[j], first[j + 1]):
                    through = dist[near_corners[k]] + near[j, near_corners[k]]
                    if through < least:
                        least, last[i, j] = through, near_corners[k]
                if last[i, j] == NONE:
                    continue
            in_e, in_n = ends[j ^ 1, 0] - ends[j, 0], ends[j ^ 1, 1] - ends[j, 1]
            length, total, c = math.hypot(in_e, in_n), 0.0, last[i, j]
            x, y = ends[j, 0], ends[j, 1]
            while True:
                bx, by = (ends[i, 0], ends[i, 1]) if c == DIRECT else (corners[c, 0], corners[c, 1])
                e, n = x - bx, y - by
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
