"""Search for a quick order of lines; ends as in `_kernels`."""

# mypy: disable-error-code="no-untyped-def,misc"

import numpy as np

from ipoa_mission.compiled import njit


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
def search_order(lines_in_order, times, lines, rounds):
    """Return the ends (n,) at which lines are entered in a quick order, and its cost [s].

    `times` (2n + 2, 2n + 2): between ends; the tour's begin and end last. `lines` (2n,): by entry.
    """
    count = len(lines_in_order)
    best, now = np.empty(count + 2, np.int64), np.empty(count + 2, np.int64)
    best[0], best[count + 1] = 2 * count + 1, 2 * count  # begin and end of the tour
    sums, dirty = (np.empty(count + 2), np.empty(count + 2)), np.empty(count + 2, np.bool_)
    for k in range(count):
        best[k + 1] = lines_in_order[k]
    for k in range(count + 2):
        dirty[k] = True
    cost = _descend(best, times, lines, dirty, sums)
    state, failed, window = 2463534242, 0, min(count, 30)
    while failed < rounds and count > 3:
        for k in range(count + 2):
            now[k] = best[k]
        low, i, e, p = 1, 0, 0, 0
        for n in range(4):
            state ^= (state << 13) & 0xFFFFFFFF
            state ^= state >> 17
            state ^= (state << 5) & 0xFFFFFFFF
            if n == 0:
                low = 1 + state % (count - window + 1)
                continue
            at = low + state % window
            if n == 1:
                i = at
            elif n == 2:
                i, e = min(i, at), max(i, at)
            else:
                i, e, p = min(i, at), max(min(e, at), i), max(e, at)
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
    found_order = np.empty(count, np.int64)
    for k in range(count):
        found_order[k] = best[k + 1]
    return found_order, cost
