"""Lay out random scenes: streets, masts, trees, walls and houses."""

import math
import random
from itertools import product
from typing import Any

import numpy as np

HOME = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
Place = tuple[float, float, float]
Scene = dict[str, Any]


def mast(n: int, east: float, north: float, radius: float, height: float, name: str = "mast") -> Scene:
    place = {"east": east, "north": north, "radius": radius, "height": height}
    return {"kind": "cylinder", "name": f"{name} {n}", **place}


def box(name: str, east: float, north: float, width: float, depth: float, height: float) -> Scene:
    place = {"east": east, "north": north}
    return {"kind": "box", "name": name, **place, "width": width, "depth": depth, "height": height}


def slalom(rng: random.Random, count: int) -> Scene:
    spacing, radius, beside = rng.uniform(55, 90), rng.uniform(2, 6), rng.uniform(4.5, 7)
    masts, via = [], []
    for n in range(count):
        east, north = spacing * (n + 1), rng.uniform(-8, 8)
        masts.append(mast(n, east, north, radius, 60.0))
        via.append((east, north + (radius + beside) * (1 if n % 2 else -1), 15.0 + rng.uniform(-3, 3)))
    return _course(via, masts, rng.uniform(6, 9))


def lawn(rng: random.Random, count: int) -> Scene:
    row, long, tall = rng.uniform(15, 19), rng.uniform(110, 170), rng.uniform(14, 22)
    trees, via = [], []
    for n in range(count):
        ends = [(15.0, row * n), (15.0 + long, row * n)]
        via += [(*end, 9.0) for end in (ends if n % 2 == 0 else ends[::-1])]
        if n < count - 1:
            places = [25.0 + k * 22.0 for k in range(int(long // 22.0))]
            trees += [mast(100 * n + k, x, row * (n + 0.5), 1.5, tall) for k, x in enumerate(places)]
    return _course(via, trees, rng.uniform(5, 7))


def hurdles(rng: random.Random, count: int) -> Scene:
    walls, via, east = [], [], 30.0
    for n in range(count):
        tall = rng.uniform(8, 20)
        east += rng.uniform(35, 60)
        walls.append(box(f"block {n}", east, 0.0, 6.0, 60.0, tall))
        via.append((east, rng.uniform(-5, 5), tall + rng.uniform(5.0, 6.5)))
        east += rng.uniform(35, 60)
        via.append((east, rng.uniform(-10, 10), max(tall - 4.0, 8.0)))
    return _course(via, walls, rng.uniform(5, 8))


def town(rng: random.Random, count: int) -> Scene:
    """Fly along a street grid, below most of the roofs."""
    block, street = rng.uniform(28, 36), rng.uniform(18, 22)
    pitch, up = block + street, rng.uniform(14, 20)
    blocks = []
    for i, j in product(range(-1, count), repeat=2):
        height = rng.choice((8, 12, 18, 26, 38, 55, 70))
        blocks.append(box(f"block {10 * i + j}", (i + 0.5) * pitch, (j + 0.5) * pitch, block, block, height))
    via, at = [], [0, 0]
    for n in range(count):
        at[n % 2] += 1 if rng.random() < 0.8 or at[n % 2] == 0 else -1
        via.append((at[0] * pitch, at[1] * pitch, up + rng.uniform(-3, 3)))
    return _course(via, blocks, rng.uniform(4, 8))


def _course(places: list[Place], obstacles: list[Scene], speed: float) -> Scene:
    *via, goal = ({"east": x, "north": y, "up": z} for x, y, z in places)
    return {
        "safety_distance": 1.5, "safety": {}, "home": HOME, "start": {"east": 0.0, "north": 0.0, "up": 12.0},
        "goal": goal, "vehicle": {"radius": 0.5, "cruise_speed": speed}, "route": {"ending": "land"},
        "obstacles": obstacles, "via": via,
    }  # fmt: skip


def village(rng: np.random.Generator) -> Scene:
    """Fly between two gardens past houses and trees, 150 to 400 m."""
    long = float(rng.uniform(150, 400))
    start, goal = {"east": 0.0, "north": 0.0, "up": 9.0}, {"east": long, "north": float(rng.uniform(-60, 60)), "up": 9}
    spots = _scatter(rng, int(long / 5), (10.0, -90.0, long - 10.0, 90.0), 24.0, [start, goal])
    houses = []
    for n, spot in enumerate(spots):
        if n % 4 == 0:
            houses.append(mast(n, *spot, float(rng.choice([2.0, 3.0])), float(rng.uniform(8, 18)), "tree"))
        else:
            size = (rng.uniform(8, 13), rng.uniform(7, 11), rng.uniform(5, 11))
            houses.append(_rounded(f"house {n}", spot, size, float(rng.uniform(0, 90))))
    return {
        "home": HOME, "safety_distance": 2.0, "start": start, "goal": goal,
        "bounds": {"east": (-40, long + 40), "north": (-120, 120), "up": (0, 60)},
        "vehicle": {"radius": 0.5, "cruise_speed": float(rng.uniform(5, 9))},
        "route": {"ending": "rtl" if rng.random() < 0.5 else "land"}, "obstacles": houses,
    }  # fmt: skip


def downtown(rng: np.random.Generator) -> Scene:
    """Fly across a street grid, below the roofs of towers."""
    blocks, pitch = int(rng.integers(4, 7)), 46.0
    towers = []
    for i, j in product(range(blocks), repeat=2):
        spot = (round(pitch * (i + 0.5), 1), round(pitch * (j + 0.5), 1))
        size = (rng.uniform(20, 28), rng.uniform(20, 28), rng.uniform(25, 95))
        towers.append(_rounded(f"tower {i}{j}", spot, size))
    far = pitch * blocks
    return {
        "home": HOME, "safety_distance": 2.0,
        "start": {"east": 0.0, "north": 0.0, "up": 15.0}, "goal": {"east": far, "north": far, "up": 20.0},
        "bounds": {"east": (-30, far + 30), "north": (-30, far + 30), "up": (0, 70)},
        "vehicle": {"radius": 0.6, "cruise_speed": float(rng.uniform(5, 10))}, "route": {"ending": "land"},
        "obstacles": towers,
    }  # fmt: skip


def forest(rng: np.random.Generator) -> Scene:
    """Fly among trees above the ceiling, ten and more meters apart."""
    goal = {"east": 130.0, "north": float(rng.uniform(-20, 20)), "up": 7.0}
    start = {"east": 0.0, "north": 0.0, "up": 6.0}
    spots = _scatter(rng, 70, (8.0, -50.0, 122.0, 50.0), 10.5, [start, goal])
    return {
        "home": HOME, "safety_distance": 1.2, "start": start, "goal": goal,
        "bounds": {"east": (-20, 150), "north": (-60, 60), "up": (0, 13)},
        "vehicle": {"radius": 0.4, "cruise_speed": float(rng.uniform(3, 6))}, "route": {"ending": "land"},
        "obstacles": [mast(n, *spot, float(rng.uniform(0.3, 0.9)), 20.0, "tree") for n, spot in enumerate(spots)],
    }  # fmt: skip


def _scatter(
    rng: np.random.Generator, many: int, area: tuple[float, float, float, float], apart: float, keep: list[Scene]
) -> list[tuple[float, float]]:
    """Return places in an area (west, south, east, north), `apart` from each other and from the places `keep` [m]."""
    west, south, east, north = area
    clear = [(place["east"], place["north"]) for place in keep]
    chosen: list[tuple[float, float]] = []
    for _ in range(60 * many):
        spot = float(rng.uniform(west, east)), float(rng.uniform(south, north))
        if all(math.dist(spot, near) >= apart for near in [*chosen, *clear]):
            chosen.append(spot)
        if len(chosen) == many:
            break
    return [(round(x, 1), round(y, 1)) for x, y in chosen]


def _rounded(name: str, spot: tuple[float, float], size: tuple[float, float, float], heading: float = 0.0) -> Scene:
    width, depth, height = (round(side, 1) for side in size)
    return box(name, *spot, width, depth, height) | {"heading_deg": round(heading, 1)}
