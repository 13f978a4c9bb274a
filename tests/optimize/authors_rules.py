"""The rivals' rules, written apart from the package: one member, one coordinate at a time.

After the authors' MATLAB code (HHO, DBO) and the SSA paper, with Table 2's constants. Each takes a cost of one point,
the bounds, N, T and a generator, and returns the best cost.
"""

import math
from collections.abc import Callable

import numpy as np

Cost = Callable[[np.ndarray], float]


def inside(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    return np.array([min(max(c, lo), hi) for c, lo, hi in zip(x, low, high, strict=True)])


def mantegna(d: int, rng: np.random.Generator) -> np.ndarray:
    beta = 1.5
    sigma = math.gamma(1 + beta) * math.sin(math.pi * beta / 2)
    sigma = (sigma / (math.gamma((1 + beta) / 2) * beta * 2 ** ((beta - 1) / 2))) ** (1 / beta)
    return np.array([rng.normal() * sigma / abs(rng.normal()) ** (1 / beta) for _ in range(d)])


def hho(cost: Cost, low: np.ndarray, high: np.ndarray, n: int, total: int, rng: np.random.Generator) -> float:
    d = len(low)
    hawks = [low + rng.random(d) * (high - low) for _ in range(n)]
    rabbit, least = hawks[0], math.inf
    for t in range(total + 1):
        costs = [cost(hawk) for hawk in hawks]
        for hawk, c in zip(hawks, costs, strict=True):
            if c < least:
                rabbit, least = hawk.copy(), c
        if t == total:
            return least
        mean = sum(hawks) / n
        flock = [hawk.copy() for hawk in hawks]
        for i in range(n):
            x = flock[i]
            energy = 2 * (1 - t / total) * rng.uniform(-1, 1)
            if abs(energy) >= 1:
                if rng.random() < 0.5:
                    other = flock[rng.integers(n)]
                    new = other - rng.random() * abs(other - 2 * rng.random() * x)
                else:
                    new = (rabbit - mean) - rng.random() * ((high - low) * rng.random() + low)
                hawks[i] = inside(new, low, high)
                continue
            jump = 2 * (1 - rng.random())
            if rng.random() >= 0.5:
                if abs(energy) < 0.5:
                    new = rabbit - energy * abs(rabbit - x)
                else:
                    new = (rabbit - x) - energy * abs(jump * rabbit - x)
                hawks[i] = inside(new, low, high)
                continue
            y = rabbit - energy * abs(jump * rabbit - (x if abs(energy) >= 0.5 else mean))
            if cost(inside(y, low, high)) < costs[i]:
                hawks[i] = inside(y, low, high)
                continue
            z = inside(y + rng.random(d) * mantegna(d, rng), low, high)
            if cost(z) < costs[i]:
                hawks[i] = z
    raise AssertionError


def dbo(cost: Cost, low: np.ndarray, high: np.ndarray, n: int, total: int, rng: np.random.Generator) -> float:
    assert n == 30
    d = len(low)
    x = [low + rng.random(d) * (high - low) for _ in range(n)]
    fit = [cost(beetle) for beetle in x]
    own, own_fit, earlier = [b.copy() for b in x], fit[:], [b.copy() for b in x]
    g = int(np.argmin(own_fit))
    best, least = own[g].copy(), own_fit[g]
    for t in range(1, total + 1):
        worse = x[int(np.argmax(fit))].copy()
        dancing = rng.random() >= 0.9
        for i in range(6):
            if not dancing:
                a = 1 if rng.random() > 0.1 else -1
                new = own[i] + 0.1 * abs(own[i] - worse) + a * 0.1 * earlier[i]
            else:
                degrees = int(rng.integers(1, 181))
                turn = 0.0 if degrees in (90, 180) else math.tan(math.radians(degrees))
                new = own[i] + turn * abs(own[i] - earlier[i])
            x[i] = inside(new, low, high)
            fit[i] = cost(x[i])
        local = x[int(np.argmin(fit))].copy()
        r = 1 - t / total
        a1, a2 = inside(local * (1 - r), low, high), inside(local * (1 + r), low, high)
        b1, b2 = inside(best * (1 - r), low, high), inside(best * (1 + r), low, high)
        for i in range(6, 12):
            new = local + rng.random(d) * (own[i] - a1) + rng.random(d) * (own[i] - a2)
            x[i] = inside(inside(new, a1, a2), low, high)
        for i in range(12, 19):
            x[i] = inside(own[i] + rng.normal() * (own[i] - b1) + rng.random(d) * (own[i] - b2), low, high)
        for i in range(19, 30):
            pull = abs(own[i] - local) + abs(own[i] - best)
            x[i] = inside(best + 0.3 * rng.standard_normal(d) * pull, low, high)
        for i in range(6, 30):
            fit[i] = cost(x[i])
        earlier = [b.copy() for b in own]
        for i in range(n):
            if fit[i] < own_fit[i]:
                own[i], own_fit[i] = x[i].copy(), fit[i]
            if own_fit[i] < least:
                best, least = own[i].copy(), own_fit[i]
    return least


def ssa(cost: Cost, low: np.ndarray, high: np.ndarray, n: int, total: int, rng: np.random.Generator) -> float:
    d = len(low)
    flock = [(cost(b), b) for b in (low + rng.random(d) * (high - low) for _ in range(n))]

    def settle(i: int, new: np.ndarray) -> None:
        new = inside(new, low, high)
        c = cost(new)
        if c < flock[i][0]:
            flock[i] = (c, new)

    producers = round(0.7 * n)
    for _ in range(total):
        flock.sort(key=lambda pair: pair[0])
        worst = flock[-1][1]
        calm = rng.random() < 0.6
        for i in range(producers):
            x = flock[i][1]
            settle(i, x * math.exp(-(i + 1) / ((1 - rng.random()) * total)) if calm else x + rng.normal())
        prey = min(flock[:producers], key=lambda pair: pair[0])[1]
        for i in range(producers, n):
            x = flock[i][1]
            if i + 1 > producers + (n - producers) / 2:
                settle(i, rng.normal() * np.exp((worst - x) / (i + 1) ** 2))
            else:
                settle(i, prey + sum(abs(c - p) * rng.choice([-1, 1]) for c, p in zip(x, prey, strict=True)) / d)
        best, worst_now = min(flock, key=lambda pair: pair[0]), max(flock, key=lambda pair: pair[0])
        for i in rng.permutation(n)[: round(0.2 * n)]:
            c, x = flock[i]
            if c > best[0]:
                settle(i, best[1] + rng.standard_normal(d) * abs(x - best[1]))
            else:
                settle(i, x + rng.uniform(-1, 1) * abs(x - worst_now[1]) / (c - worst_now[0] - 1e-50))
    return min(c for c, _ in flock)
