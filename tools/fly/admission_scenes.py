"""List the scenes of an admission: shipped scenarios, then random ones of every kind at low, high and usual speed.

A random scene depends on seed and number alone. Towns, crests, slopes, terraces, steep flights and lawns alternate.
The speed changes after each round of kinds.
"""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.scenario import Scenario, read_scenario
from tools import REPOSITORY
from tools.fly import layouts
from tools.fly.layouts import HOME, Scene, box, mast

MISSIONS = REPOSITORY / "missions"
SLOW, FAST = (2.0, 4.0), (9.0, 14.0)  # cruise speeds [m/s]


def crest(rng: random.Random) -> Scene:
    tall, far = rng.uniform(25, 70), rng.uniform(160, 260)
    ridge = {"height": tall, "east": far, "north": 0.0, "a": rng.uniform(60, 110), "b": 400.0}
    over = rng.uniform(16, 28)
    via = [_over(far + rng.uniform(-25, 25), rng.uniform(-20, 20), over)]
    if rng.random() < 0.5:
        via.append(_over(far + 90.0, rng.uniform(-40, 40), over))
    things = [mast(n, far, side * rng.uniform(18, 40), 1.5, 30.0) for n, side in enumerate((-1, 1))]
    return _flight(via, _over(2 * far, rng.uniform(-40, 40), rng.uniform(14, 25)), things, rng, ridge)


def slope(rng: random.Random) -> Scene:
    tall, far = rng.uniform(50, 110), rng.uniform(220, 320)
    mountain = {"height": tall, "east": far, "north": 40.0, "a": 150.0, "b": 170.0}
    trees = [mast(n, rng.uniform(40, far), rng.uniform(-90, 90), rng.uniform(2, 4), 18.0) for n in range(14)]
    via = [_over(far * share, rng.uniform(-60, 60), rng.uniform(22, 30)) for share in (0.35, 0.7)]
    goal = (far, 20.0) if rng.random() < 0.5 else (far * 0.5, -150.0)
    return _flight(via, _over(*goal, rng.uniform(20, 28)), trees, rng, mountain)


def terrace(rng: random.Random) -> Scene:
    """Fly over rising roofs, a waypoint above each, and down."""
    roofs, via, east = [], [], 35.0
    heights = sorted(rng.uniform(6, 40) for _ in range(rng.randint(3, 5)))
    down = heights[-2::-1] if rng.random() < 0.5 else []
    for n, tall in enumerate([*heights, *down]):
        deep = rng.uniform(22, 40)
        roofs.append(box(f"block {n}", east + deep / 2, 0.0, deep, 50.0, tall))
        via.append({"east": east + deep / 2, "north": rng.uniform(-12, 12), "up": tall + rng.uniform(6, 9)})
        east += deep + rng.uniform(0, 12)
    goal = {"east": east + rng.uniform(40, 90), "north": rng.uniform(-30, 30), "up": rng.uniform(10, 18)}
    return _flight(via[:6], goal, roofs, rng)


def steep(rng: random.Random) -> Scene:
    via, towers, east = [], [], 0.0
    for n in range(rng.randint(2, 4)):
        east += rng.uniform(45, 80)
        towers.append(box(f"block {n}", east, 0.0, 14.0, 40.0, rng.uniform(25, 55)))
        aside = rng.choice((-1, 1)) * rng.uniform(30, 36)
        via.append({"east": east, "north": aside, "up": rng.choice((10.0, 14.0, 45.0, 62.0))})
    goal = {"east": east + rng.uniform(30, 70), "north": rng.uniform(-25, 25), "up": rng.choice((9.0, 20.0, 50.0))}
    return _flight(via, goal, towers, rng)


def _over(east: float, north: float, height: float) -> dict[str, float]:
    return {"east": east, "north": north, "height_above_ground": height}


def _flight(via: list[Scene], goal: Scene, things: list[Scene], rng: random.Random, *peaks: Scene) -> Scene:
    hills = {"terrain": {"kind": "analytic", "peaks": list(peaks)}} if peaks else {}
    return {
        "safety_distance": 2.0, "home": HOME, "start": {"east": 0.0, "north": 0.0, "up": rng.uniform(12, 20)},
        "goal": goal, "via": via, "vehicle": {"radius": 0.5, "cruise_speed": rng.uniform(5, 9)},
        "route": {"ending": "rtl" if rng.random() < 0.3 else "land"}, "obstacles": things, **hills,
    }  # fmt: skip


def _counted(make: Callable[[random.Random, int], Scene], least: int, most: int) -> Callable[[random.Random], Scene]:
    return lambda rng: make(rng, rng.randint(least, most))


def _numpy(make: Callable[[np.random.Generator], Scene]) -> Callable[[random.Random], Scene]:
    return lambda rng: make(np.random.default_rng(rng.getrandbits(63)))


KINDS: dict[str, Callable[[random.Random], Scene]] = {
    "town": _counted(layouts.town, 3, 5),
    "crest": crest,
    "slope": slope,
    "terrace": terrace,
    "lawn": _counted(layouts.lawn, 3, 5),
    "steep": steep,
    "village": _numpy(layouts.village),
    "hurdles": _counted(layouts.hurdles, 2, 4),
    "downtown": _numpy(layouts.downtown),
    "ridge": crest,
    "slalom": _counted(layouts.slalom, 3, 6),
    "forest": _numpy(layouts.forest),
}


def scene_name(number: int, seed: int) -> str:
    return f"{list(KINDS)[number % len(KINDS)]}{seed}x{number:03d}"


def scene(number: int, seed: int, autopilot: Autopilot) -> Scene:
    rng = random.Random(f"{seed}-{number}")
    made = list(KINDS.values())[number % len(KINDS)](rng)
    speeds = (None, SLOW, FAST)[number // len(KINDS) % 3]
    vehicle: dict[str, Any] = made["vehicle"] | {"autopilot": str(autopilot)}
    if speeds is not None:
        vehicle["cruise_speed"] = rng.uniform(*speeds)
    return made | {"vehicle": vehicle}


def written(number: int, seed: int, autopilot: Autopilot, path: Path) -> Path:
    text = json.dumps(scene(number, seed, autopilot))
    rounded = json.loads(text, parse_float=lambda digits: round(float(digits), 7))
    path.write_text(tomlkit.dumps(rounded), encoding="utf-8")
    return path


def shipped() -> list[Path]:
    return sorted(MISSIONS.glob("*.toml"))


def as_flown_by(path: Path, autopilot: Autopilot) -> Scenario:
    scenario = read_scenario(path)
    if scenario.vehicle.autopilot is autopilot:
        return scenario
    vehicle = scenario.vehicle.model_copy(update={"autopilot": autopilot, "parameters": {}, "firmware_version": None})
    return scenario.model_copy(update={"vehicle": vehicle})
