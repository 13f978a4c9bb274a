"""Plan everyday scenarios: refusals, CPU time, and least distance of the predicted path.

    python -m tools.benchmarks.everyday [--kinds lawn,forest] [--numbers 0-3] [--autopilot px4] [--out rows.csv]

Every scene has a passage that is wide enough by construction: a refusal is wrong. Shapely measures the distances from
the scenario's own numbers, without the package's world.
"""

import csv
import math
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.geometry import Points, arc_lengths
from ipoa_mission.scenario import Scenario
from tools import command_line

HOME = {"latitude_deg": 46.9232, "longitude_deg": 10.5127, "altitude_amsl": 1050.0}
EARTH_RADIUS = 6.371e6  # the ground is below a plane at home by the Earth's curvature [m]
STEP = 0.1  # sampling of a predicted path [m]
Table = dict[str, Any]


def _scatter(
    rng: np.random.Generator, many: int, area: tuple[float, float, float, float], apart: float, keep: list[Table]
) -> list[tuple[float, float]]:
    """Return places in an area (west, south, east, north), `apart` from each other and from the places `keep` [m]."""
    west, south, east, north = area
    clear = [(place["east"], place["north"]) for place in keep]
    chosen: list[tuple[float, float]] = []
    for _ in range(60 * many):
        spot = float(rng.uniform(west, east)), float(rng.uniform(south, north))
        if all(math.dist(spot, other) >= apart for other in [*chosen, *clear]):
            chosen.append(spot)
        if len(chosen) == many:
            break
    return [(round(x, 1), round(y, 1)) for x, y in chosen]


def _tree(n: int, spot: tuple[float, float], radius: float, height: float) -> Table:
    return {
        "kind": "cylinder",
        "name": f"tree {n}",
        "east": spot[0],
        "north": spot[1],
        "radius": radius,
        "height": height,
    }


def _box(name: str, spot: tuple[float, float], size: tuple[float, float, float], heading: float = 0.0) -> Table:
    width, depth, height = (round(side, 1) for side in size)
    return {
        "kind": "box",
        "name": name,
        "east": spot[0],
        "north": spot[1],
        "width": width,
        "depth": depth,
        "height": height,
        "heading_deg": round(heading, 1),
    }


def _village(rng: np.random.Generator) -> Table:
    """Fly between two gardens past houses and some trees, 150 to 400 m."""
    long = float(rng.uniform(150, 400))
    start, goal = {"east": 0.0, "north": 0.0, "up": 9.0}, {"east": long, "north": float(rng.uniform(-60, 60)), "up": 9}
    area = (10.0, -90.0, long - 10.0, 90.0)
    spots = _scatter(rng, int(long / 5), area, 24.0, [start, goal])
    houses = [
        _box(
            f"house {n}",
            spot,
            (rng.uniform(8, 13), rng.uniform(7, 11), rng.uniform(5, 11)),
            float(rng.uniform(0, 90)),
        )
        if n % 4
        else _tree(n, spot, float(rng.choice([2.0, 3.0])), float(rng.uniform(8, 18)))
        for n, spot in enumerate(spots)
    ]
    return {
        "safety_distance": 2.0,
        "start": start,
        "goal": goal,
        "bounds": {"east": (-40, long + 40), "north": (-120, 120), "up": (0, 60)},
        "vehicle": {"radius": 0.5, "cruise_speed": float(rng.uniform(5, 9))},
        "route": {"ending": "rtl" if rng.random() < 0.5 else "land"},
        "obstacles": houses,
    }


def _downtown(rng: np.random.Generator) -> Table:
    """Fly from corner to corner of a street grid, below the roofs of towers."""
    blocks, pitch = int(rng.integers(4, 7)), 46.0
    towers = [
        _box(
            f"tower {i}{j}",
            (round(pitch * (i + 0.5), 1), round(pitch * (j + 0.5), 1)),
            (rng.uniform(20, 28), rng.uniform(20, 28), rng.uniform(25, 95)),
        )
        for i, j in product(range(blocks), repeat=2)
    ]
    far = pitch * blocks
    return {
        "safety_distance": 2.0,
        "start": {"east": 0.0, "north": 0.0, "up": 15.0},
        "goal": {"east": far, "north": far, "up": 20.0},
        "bounds": {"east": (-30, far + 30), "north": (-30, far + 30), "up": (0, 70)},
        "vehicle": {"radius": 0.6, "cruise_speed": float(rng.uniform(5, 10))},
        "route": {"ending": "land"},
        "obstacles": towers,
    }


def _forest(rng: np.random.Generator) -> Table:
    """Fly among trees above the ceiling, ten and more meters apart."""
    goal = {"east": 130.0, "north": float(rng.uniform(-20, 20)), "up": 7.0}
    start = {"east": 0.0, "north": 0.0, "up": 6.0}
    spots = _scatter(rng, 70, (8.0, -50.0, 122.0, 50.0), 10.5, [start, goal])
    return {
        "safety_distance": 1.2,
        "start": start,
        "goal": goal,
        "bounds": {"east": (-20, 150), "north": (-60, 60), "up": (0, 13)},
        "vehicle": {"radius": 0.4, "cruise_speed": float(rng.uniform(3, 6))},
        "route": {"ending": "land"},
        "obstacles": [_tree(n, spot, float(rng.uniform(0.3, 0.9)), 20.0) for n, spot in enumerate(spots)],
    }


def _yard(rng: np.random.Generator) -> Table:
    """Fly from one walled yard into another, through their gates."""
    gate, walls = float(rng.uniform(9.0, 13.0)), list[Table]()
    for name, east, side in (("a", 0.0, 1), ("b", 90.0, -1)):
        north = 0.0 if name == "a" else float(rng.uniform(-30, 30))
        half, shut = 16.0, (32.0 - gate) / 2
        walls += [
            _box(f"{name} back", (east - side * half, north), (2, 2 * half, 18)),
            _box(f"{name} north", (east, north + half), (2 * half, 2, 18)),
            _box(f"{name} south", (east, north - half), (2 * half, 2, 18)),
            _box(f"{name} gate n", (east + side * half, north + (gate + shut) / 2), (2, shut, 18)),
            _box(f"{name} gate s", (east + side * half, north - (gate + shut) / 2), (2, shut, 18)),
        ]
    return {
        "safety_distance": 1.5,
        "start": {"east": 0.0, "north": 0.0, "up": 6.0},
        "goal": {"east": 90.0, "north": walls[-1]["north"] + (gate + shut) / 2, "up": 6.0},
        "bounds": {"east": (-30, 120), "north": (-60, 60), "up": (0, 15)},
        "vehicle": {"radius": 0.5, "cruise_speed": float(rng.uniform(3, 7))},
        "route": {"ending": "land"},
        "obstacles": walls,
    }


def _lawn(rng: np.random.Generator) -> Table:
    """Fly to and fro over a lawn among trees by 12 or 14 via points."""
    lanes = int(rng.choice([6, 7]))
    via = [
        {"east": east, "north": 10.0 + 15 * lane, "up": 6.0}
        for lane in range(lanes)
        for east in ((10.0, 110.0) if lane % 2 == 0 else (110.0, 10.0))
    ]
    start, goal = {"east": 0.0, "north": 0.0, "up": 6.0}, {"east": 5.0, "north": -12.0, "up": 6.0}
    apart, thickest = ((9.5, 1.0), (12.0, 2.0))[int(rng.integers(2))]
    spots = _scatter(rng, 45, (4.0, 2.0, 118.0, 15.0 * lanes + 4), apart, [start, goal, *via])
    return {
        "safety_distance": 1.2,
        "start": start,
        "goal": goal,
        "via": via,
        "bounds": {"east": (-30, 140), "north": (-30, 15 * lanes + 30), "up": (0, 14)},
        "vehicle": {"radius": 0.4, "cruise_speed": float(rng.uniform(3, 5))},
        "route": {"ending": "land"},
        "obstacles": [_tree(n, spot, float(rng.uniform(0.5, thickest)), 16.0) for n, spot in enumerate(spots)],
    }


def _long(rng: np.random.Generator) -> Table:
    """Fly three to eight kilometers with halls and masts along the straight line."""
    far, turn = float(rng.uniform(3000, 8000)), float(rng.uniform(0, 2 * math.pi))
    ahead = np.array([math.cos(turn), math.sin(turn)])
    aside, halls = np.array([-ahead[1], ahead[0]]), list[Table]()
    for n, along in enumerate(np.arange(150.0, far - 150.0, far / 24)):
        east, north = (along * ahead + rng.uniform(-90, 90) * aside).round(1).tolist()
        size = (rng.uniform(50, 130), rng.uniform(40, 90), rng.uniform(45, 80))
        halls.append(_box(f"hall {n}", (east, north), size, float(rng.uniform(0, 90))))
    corners = np.array([(0, 0), far * ahead])
    lower, upper = corners.min(axis=0) - 300, corners.max(axis=0) + 300
    goal = (far * ahead).round(1).tolist()
    return {
        "safety_distance": 4.0,
        "start": {"east": 0.0, "north": 0.0, "up": 40.0},
        "goal": {"east": goal[0], "north": goal[1], "up": 50.0},
        "bounds": {"east": (lower[0], upper[0]), "north": (lower[1], upper[1]), "up": (0, 95)},
        "vehicle": {"radius": 0.8, "cruise_speed": float(rng.uniform(10, 15))},
        "route": {"ending": "land"},
        "obstacles": halls,
    }


KINDS: dict[str, Callable[[np.random.Generator], Table]] = {
    "village": _village,
    "downtown": _downtown,
    "forest": _forest,
    "yard": _yard,
    "lawn": _lawn,
    "long": _long,
}


def table_of(kind: str, number: int, autopilot: Autopilot) -> Table:
    """Return scenario `number` of a kind as a table; the same for both autopilots."""
    table = KINDS[kind](np.random.default_rng([2026, 11, list(KINDS).index(kind), number]))
    table["vehicle"]["autopilot"] = str(autopilot)
    return {"name": f"{kind}{number}", "home": HOME, **table}


def measured(path: Points, table: Table) -> float:
    """Return the least distance of a path (n, 3) to the boxes and cylinders of a scenario's table, sampled [m]."""
    along = arc_lengths(path)
    stops = np.union1d(along, np.arange(0.0, along[-1], STEP))
    spots = np.column_stack([np.interp(stops, along, axis) for axis in path.T])
    points, least = shapely.points(spots[:, :2]), math.inf
    for body in table.get("obstacles", []):
        middle = shapely.Point(body["east"], body["north"])
        if body["kind"] == "cylinder":
            aside = np.maximum(shapely.distance(points, middle) - body["radius"], 0.0)
        else:
            half = body["width"] / 2, body["depth"] / 2
            flat = shapely.box(-half[0], -half[1], half[0], half[1])
            turned = shapely.affinity.rotate(flat, -body.get("heading_deg", 0.0), origin=(0, 0))
            aside = shapely.distance(points, shapely.affinity.translate(turned, middle.x, middle.y))
        around = math.hypot(body.get("width", 0.0), body.get("depth", 0.0)) / 2
        drop = max(math.hypot(body["east"], body["north"]) - around, 0.0) ** 2 / (2 * EARTH_RADIUS)
        above = np.maximum(spots[:, 2] - (body["height"] - drop), 0.0)
        least = min(least, float(np.hypot(aside, above).min()))
    return least


def way_of(flight: Flight) -> Points:
    """Return the predicted path from the end of the take-off to the last waypoint, (n, 3)."""
    predicted = flight.promise.flight
    return predicted.pieces.part(*predicted.way).points


def row_of(kind: str, number: int, autopilot: Autopilot) -> Table:
    table = table_of(kind, number, autopilot)
    scenario = Scenario.model_validate(table)
    required, begin = scenario.limits.obstacle_distance, time.process_time()
    row: Table = {"scene": table["name"], "autopilot": str(autopilot), "required": round(required, 3)}
    try:
        flight = plan_flight(scenario)
    except MissionError as error:
        return row | {"cpu_s": round(time.process_time() - begin, 2), "error": str(error)}
    row["cpu_s"] = round(time.process_time() - begin, 2)
    kept = flight.promise.clearance
    row |= {"total_s": round(flight.estimate.total_s, 1), "measured": round(measured(way_of(flight), table), 3)}
    return row | {
        "kept": "" if kept is None else round(kept.kept, 3),
        "on_way": "" if kept is None else kept.on_the_way,
    }


FIELDS = ["scene", "autopilot", "cpu_s", "required", "kept", "on_way", "measured", "total_s", "error"]


def _write(rows: list[Table], out: Path) -> None:
    """Write all rows so far, so that an interrupted run keeps them."""
    out.parent.mkdir(parents=True, exist_ok=True)
    with out.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        writer.writeheader()
        writer.writerows(rows)


def main() -> None:
    """Plan the scenes and report each, then per kind the median CPU time and the refusals."""
    parser = command_line(__doc__)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--numbers", default="0-3")
    parser.add_argument("--autopilot", choices=[str(autopilot) for autopilot in registered()])
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    first, last = map(int, asked.numbers.split("-"))
    pilots = [autopilot for autopilot in registered() if asked.autopilot in (None, str(autopilot))]
    rows = []
    for kind, number, autopilot in product(asked.kinds.split(","), range(first, last + 1), pilots):
        rows.append(row_of(kind, number, autopilot))
        print(*(f"{name}={rows[-1].get(name, '')}" for name in FIELDS), flush=True)
        if asked.out is not None:
            _write(rows, asked.out)
    for kind in asked.kinds.split(","):
        mine = [row for row in rows if row["scene"].startswith(kind)]
        seconds = [row["cpu_s"] for row in mine]
        cpu = f"{np.median(seconds):.1f} s in the median, {max(seconds):.1f} at worst"
        near = sum("error" not in row and row["measured"] < row["required"] - 1e-3 for row in mine)
        refused = sum("error" in row for row in mine)
        print(f"{kind}: {len(mine)} scenes, {cpu}, {refused} refused, {near} written too near")


if __name__ == "__main__":
    main()
