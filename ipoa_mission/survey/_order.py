"""The search for a quick order of lines, compiled.

Line k has the ends 2k and 2k+1; one that is entered at end e is left at e ^ 1.
"""

# mypy: disable-error-code="no-untyped-def,misc"

import numpy as np

from ipoa_mission.compiled import njit


@njit(cache=True, error_model="numpy")
def _sums(entries, times, lines, forth, back):
    """What the order costs up to each line, flown forth and back; the first and the last of `entries` are no lines."""
    forth[1], back[1] = lines[entries[1]], lines[entries[1] ^ 1]
    for k in range(2, len(entries) - 1):
        here, there = entries[k - 1], entries[k]
        forth[k] = forth[k - 1] + times[here ^ 1, there] + lines[there]
        back[k] = back[k - 1] + times[there, here ^ 1] + lines[there ^ 1]


@njit(cache=True, error_model="numpy")
def _flip(entries, i, j):
    """Fly lines i to j the other way round."""
    while i <= j:
        entries[i], entries[j] = entries[j] ^ 1, entries[i] ^ 1
        i, j = i + 1, j - 1


@njit(cache=True, error_model="numpy")
def _better(entries, k, times, lines, forth, back):
    """The best change that begins at line k: its kind (0: none, 1: flip, 2: move, 3: move and flip), and where."""
    beyond = len(entries) - 1
    best, kind, a, b, c = -1e-7, 0, 0, 0, 0
    before, head = entries[k - 1] ^ 1, entries[k]
    for i in range(1, k):  # flip what lies between k and another
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
    for e in range(k, min(k + 3, beyond)):  # move lines k to e elsewhere
        tail, after = entries[e] ^ 1, entries[e + 1]
        out = times[before, after] - times[before, head] - times[tail, after]
        if out > -1e-7:
            continue
        turned = (back[e] - back[k] + lines[head ^ 1]) - (forth[e] - forth[k] + lines[head])
        for p in range(beyond):  # behind line p
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
    """Put lines i to e behind line p: three flips."""
    if p < i:
        _flip(entries, p + 1, e)
        _flip(entries, p + 1, p + e - i + 1)
        _flip(entries, p + e - i + 2, e)
    else:
        _flip(entries, i, p)
        _flip(entries, i, i + p - e - 1)
        _flip(entries, i + p - e, p)


@njit(cache=True, error_model="numpy")
def _descend(entries, times, lines, dirty, forth, back):
    """Change the order for the better, beginning where it is dirty, until nothing helps; what it costs [s]."""
    beyond = len(entries) - 1
    _sums(entries, times, lines, forth, back)
    k, clean = 1, 0
    while clean < beyond:
        if dirty[k]:
            kind, a, b, c = _better(entries, k, times, lines, forth, back)
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
                _sums(entries, times, lines, forth, back)
                clean = 0
                continue
        clean += 1
        k = k + 1 if k < beyond - 1 else 1
    return forth[beyond - 1] + times[entries[0] ^ 1, entries[1]] + times[entries[beyond - 1] ^ 1, entries[beyond]]


@njit(cache=True, error_model="numpy")
def search_order(lines_in_order, times, lines, rounds):
    """A quick order of lines, by the ends at which they are entered (n,), and what it costs [s].

    Local search from the given order, kicked until nothing better was found so many times. `times` (2n + 2, 2n + 2) of
    ways between ends, and from and to two more, where the tour begins and ends; `lines` by their entry (2n,).
    """
    count = len(lines_in_order)
    best, now = np.empty(count + 2, np.int64), np.empty(count + 2, np.int64)
    best[0], best[count + 1] = 2 * count + 1, 2 * count  # left by the one, entered by the other
    forth, back, dirty = np.empty(count + 2), np.empty(count + 2), np.empty(count + 2, np.bool_)
    for k in range(count):
        best[k + 1] = lines_in_order[k]
    for k in range(count + 2):
        dirty[k] = True
    cost = _descend(best, times, lines, dirty, forth, back)
    state, failed, reach = 2463534242, 0, min(count, 30)
    while failed < rounds and count > 3:
        for k in range(count + 2):
            now[k] = best[k]
        low, i, e, p = 1, 0, 0, 0
        for n in range(4):
            state ^= (state << 13) & 0xFFFFFFFF
            state ^= state >> 17
            state ^= (state << 5) & 0xFFFFFFFF
            if n == 0:
                low = 1 + state % (count - reach + 1)
                continue
            at = low + state % reach
            if n == 1:
                i = at
            elif n == 2:
                i, e = min(i, at), max(i, at)
            else:
                i, e, p = min(i, at), max(min(e, at), i), max(e, at)
        if e < p:
            _move(now, i, e, p)  # two stretches change places
        else:
            _flip(now, i, p)
        for m in (i, i + p - e, p + 1):
            for n in range(max(m - 1, 1), min(m + 1, count + 1)):
                dirty[n] = True
        found = _descend(now, times, lines, dirty, forth, back)
        if found < cost - 1e-9:
            cost, failed = found, 0
            for k in range(count + 2):
                best[k] = now[k]
        else:
            failed += 1
    found_order = np.empty(count, np.int64)
    for k in range(count):
        found_order[k] = best[k + 1]
    return found_order, cost
