"""Make courses for real autopilots: long ones past many obstacles, short ones of every kind, and ones to be aborted.

    python -m tools.fly.courses DIR --kind long|short|returns

A course depends on its number alone. Each is a scenario for each autopilot, NAME-px4.toml and NAME-ardupilot.toml.
They differ only in PX4's missing splines and in its simulator's missing wind. Courses to be aborted are made twice:
with and without a planned return.
"""

import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from tools import command_line

HOME = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
Place = tuple[float, float, float]
Course = dict[str, Any]


def slalom(rng: random.Random, count: int) -> Course:
    """Fly past masts in a line, alternately on the left and the right."""
    spacing, radius, beside = rng.uniform(55, 90), rng.uniform(2, 6), rng.uniform(4.5, 7)
    masts, via = [], []
    for n in range(count):
        east, north = spacing * (n + 1), rng.uniform(-8, 8)
        masts.append(mast(n, east, north, radius, 60.0))
        via.append((east, north + (radius + beside) * (1 if n % 2 else -1), 15.0 + rng.uniform(-3, 3)))
    return _course(via, masts, rng.uniform(6, 9))


def lawn(rng: random.Random, count: int) -> Course:
    """Fly to and fro between rows of trees."""
    row, long, tall = rng.uniform(15, 19), rng.uniform(110, 170), rng.uniform(14, 22)
    trees, via = [], []
    for n in range(count):
        ends = [(15.0, row * n), (15.0 + long, row * n)]
        via += [(*end, 9.0) for end in (ends if n % 2 == 0 else ends[::-1])]
        if n < count - 1:
            places = [25.0 + k * 22.0 for k in range(int(long // 22.0))]
            trees += [mast(100 * n + k, x, row * (n + 0.5), 1.5, tall) for k, x in enumerate(places)]
    return _course(via, trees, rng.uniform(5, 7))


def perimeters(rng: random.Random, count: int) -> Course:
    """Fly round blocks, close to their walls."""
    blocks, via, east = [], [], 45.0
    for n in range(count):
        wide, deep, beside, up = rng.uniform(30, 55), rng.uniform(25, 45), rng.uniform(4.5, 6.5), rng.uniform(10, 18)
        east += wide / 2
        blocks.append(box(n, east, 0.0, wide, deep, up + 15.0))
        w, d = wide / 2 + beside, deep / 2 + beside
        via += [(east + x, y, up) for x, y in ((-w, -d), (-w, d), (w, d), (w, -d))]
        east += wide / 2 + 30.0
    return _course(via, blocks, rng.uniform(5, 8))


def hurdles(rng: random.Random, count: int) -> Course:
    """Fly over low walls, descending between them."""
    walls, via, east = [], [], 30.0
    for n in range(count):
        tall = rng.uniform(8, 20)
        east += rng.uniform(35, 60)
        walls.append(box(n, east, 0.0, 6.0, 60.0, tall))
        via.append((east, rng.uniform(-5, 5), tall + rng.uniform(5.0, 6.5)))
        east += rng.uniform(35, 60)
        via.append((east, rng.uniform(-10, 10), max(tall - 4.0, 8.0)))
    return _course(via, walls, rng.uniform(5, 8))


def gates(rng: random.Random, count: int) -> Course:
    """Fly through gaps of walls at different places."""
    walls, via, east = [], [], 20.0
    for n in range(count):
        gap, north = rng.uniform(11, 14), rng.uniform(-18, 18)
        east += rng.uniform(55, 85)
        for k, side in enumerate((-1, 1)):
            walls.append(box(10 * n + k, east, north + side * (gap / 2 + 15.0), 5.0, 30.0, 40.0))
        via += [(east - 14.0, north, 14.0), (east + 14.0, north, 14.0)]
    return _course(via, walls, rng.uniform(5, 8))


LONG: tuple[tuple[Callable[[random.Random, int], Course], int], ...] = (
    (slalom, 32), (lawn, 14), (perimeters, 10), (hurdles, 16), (gates, 20),
    (slalom, 36), (lawn, 16), (perimeters, 11), (hurdles, 18), (gates, 22),
    (slalom, 34), (lawn, 15), (perimeters, 12), (hurdles, 17), (gates, 21),
)  # fmt: skip


def free(rng: random.Random, kind: int) -> Course:
    """Fly past two or three obstacles; ending, waypoints, height and ground change with `kind`."""
    span, turn = rng.uniform(90, 320), rng.uniform(-math.pi, math.pi)
    goal = (span * math.cos(turn), span * math.sin(turn), (5.0, 9.0, 14.0, 22.0, 31.0)[kind % 5])
    course = _course([goal], [], rng.uniform(4, 12))
    course["start"]["up"] = rng.choice((8.0, 12.0, 20.0))
    for n in range(rng.randint(1, 3)):
        share = (n + 1) / 4
        place = (goal[0] * share + rng.uniform(-8, 8), goal[1] * share + rng.uniform(-8, 8))
        course["obstacles"].append(mast(n, *place, rng.uniform(3, 9), 60.0))
    course["route"]["ending"] = "rtl" if kind % 4 in (1, 3) else "land"
    if kind % 4 == 3:  # a return to a rally point near the goal
        course["rally"] = [{"east": goal[0] + 25.0, "north": goal[1] - 20.0, "up": rng.choice((10.0, 25.0))}]
        if kind % 8 == 7:
            course["rally"].append({"east": goal[0] / 2, "north": goal[1] / 2 + 30.0, "up": 20.0})
    if kind % 5 == 2:  # a hill under the goal: the landing heights are raised
        hill = {"height": rng.uniform(6, 25), "east": goal[0], "north": goal[1], "a": 60.0, "b": 60.0}
        course["terrain"] = {"kind": "analytic", "peaks": [hill]}
        course["goal"]["up"] = goal[2] + hill["height"]
        course["start"]["up"] = 12.0
    return course


SHORT = 40


def town(rng: random.Random, count: int) -> Course:
    """Fly along a street grid, below most of the roofs."""
    block, street = rng.uniform(28, 36), rng.uniform(18, 22)
    pitch, up = block + street, rng.uniform(14, 20)
    blocks = [
        box(10 * i + j, (i + 0.5) * pitch, (j + 0.5) * pitch, block, block, rng.choice((8, 12, 18, 26, 38, 55, 70)))
        for i in range(-1, count)
        for j in range(-1, count)
    ]
    via, at = [], [0, 0]
    for n in range(count):
        at[n % 2] += 1 if rng.random() < 0.8 or at[n % 2] == 0 else -1
        via.append((at[0] * pitch, at[1] * pitch, up + rng.uniform(-3, 3)))
    return _course(via, blocks, rng.uniform(4, 8))


def yard(rng: random.Random, count: int) -> Course:
    """Fly between stacks, cranes and balloons at random places."""
    via = [(35.0 * (n + 1), rng.uniform(-30, 30), rng.uniform(10, 24)) for n in range(count)]
    things: list[Course] = []
    while len(things) < 4 * count:
        east, north = rng.uniform(15, 35.0 * (count + 1)), rng.uniform(-60, 60)
        if min(math.dist((east, north), one[:2]) for one in [*via, (0.0, 0.0, 0.0)]) < 14.0:
            continue
        kind, n = rng.random(), len(things)
        if kind < 0.4:
            things.append(mast(n, east, north, rng.uniform(1, 4), rng.uniform(15, 70)))
        elif kind < 0.8:
            turned = {"heading_deg": rng.uniform(0, 90)}
            things.append(box(n, east, north, rng.uniform(6, 14), 6.0, rng.uniform(6, 30)) | turned)
        else:
            ball = {"kind": "sphere", "name": f"balloon {n}", "radius": rng.uniform(2, 4)}
            things.append(ball | {"east": east, "north": north, "up": rng.uniform(20, 45)})
    return _course(via, things, rng.uniform(5, 10))


BROKEN_OFF: tuple[tuple[Callable[[random.Random, int], Course], int], ...] = (
    (town, 4), (yard, 5), (slalom, 5), (town, 5), (gates, 3), (perimeters, 2),
    (yard, 6), (hurdles, 4), (slalom, 6), (town, 6), (yard, 4), (gates, 4),
    (hurdles, 5), (town, 4), (yard, 7), (slalom, 4), (town, 5), (yard, 5),
)  # fmt: skip
LOTS = 3 * len(BROKEN_OFF)


def kind_of(number: int) -> tuple[Callable[[random.Random, int], Course], int]:
    """Return the kind of a course to be aborted; from the third round on some have wind, rally points or hills."""
    return BROKEN_OFF[(number + number // (2 * len(BROKEN_OFF))) % len(BROKEN_OFF)]


def broken_off(number: int) -> Course:
    """Return a course to be aborted; a third each with rally points, wind and a slope; default confidence."""
    make, count = kind_of(number)
    rng = random.Random(3000 + number)
    course = make(rng, count) | {"safety_distance": 1.5, "safety": {}}
    if number % 3 == 1:
        goal = course["goal"]
        beside = {"east": goal["east"] + 12.0, "north": goal["north"] - 8.0, "up": rng.choice((12.0, 25.0))}
        course["rally"] = [beside, {"east": -15.0, "north": 45.0, "up": 20.0}]
    if number % 3 == 2:
        course["wind"] = {"speed": rng.uniform(3, 6), "from_deg": float(rng.randrange(0, 360, 10))}
    if number % 6 in (0, 4):
        hill = {"height": rng.uniform(3, 8), "east": 130.0, "north": 60.0, "a": 110.0, "b": 90.0}
        course["terrain"] = {"kind": "analytic", "peaks": [hill]}
        for place in (course["start"], course["goal"], *course.get("via", [])):
            place["up"] += hill["height"]
    return course


def mast(n: int, east: float, north: float, radius: float, height: float) -> Course:
    return {"kind": "cylinder", "name": f"mast {n}", "east": east, "north": north, "radius": radius, "height": height}


def box(n: int, east: float, north: float, width: float, depth: float, height: float) -> Course:
    size = {"width": width, "depth": depth, "height": height}
    return {"kind": "box", "name": f"block {n}", "east": east, "north": north, **size}


def _course(places: list[Place], obstacles: list[Course], speed: float) -> Course:
    *via, goal = ({"east": x, "north": y, "up": z} for x, y, z in places)
    course = {
        "safety_distance": 1.0,
        "safety": {"confidence": 0.9},
        "home": HOME,
        "start": {"east": 0.0, "north": 0.0, "up": 12.0},
        "goal": goal,
        "vehicle": {"radius": 0.5, "cruise_speed": speed},
        "route": {"ending": "land"},
        "obstacles": obstacles,
    }
    return course | ({"via": via} if via else {})


def long_courses() -> dict[str, Course]:
    made = enumerate(LONG)
    return {f"long{n:02d}_{kind.__name__}": kind(random.Random(1000 + n), count) for n, (kind, count) in made}


def short_courses() -> dict[str, Course]:
    courses = {f"short{n:02d}": free(random.Random(2000 + n), n) for n in range(SHORT)}
    for n, course in enumerate(courses.values()):
        if n % 3 == 0:
            course["route"] |= {"mode": "even", "spacing": 12.0}
        if n % 3 == 1:
            course["route"] |= {"mode": "spline", "spacing": 20.0}
    return courses


def returning_courses() -> dict[str, Course]:
    """Return the courses by name; `n` precedes those with a planned return."""
    courses = {f"ret{n:02d}_{kind_of(n)[0].__name__}": broken_off(n) for n in range(LOTS)}
    planned = {f"n{name}": one | {"safety": {"returns": "planned"}} for name, one in courses.items()}
    return courses | planned


MAKERS = {"long": long_courses, "short": short_courses, "returns": returning_courses}


def as_toml(course: Course) -> str:
    plain = {key: value for key, value in course.items() if not isinstance(value, dict | list)}
    lines = [f"{key} = {_value(value)}" for key, value in plain.items()]
    for key, value in course.items():
        tables = value if isinstance(value, list) else [value] if isinstance(value, dict) else []
        head = f"[[{key}]]" if isinstance(value, list) else f"[{key}]"
        for table in tables:
            lines += ["", head, *(f"{name} = {_value(one)}" for name, one in table.items())]
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{name} = {_value(one)}' for name, one in value.items())} }}"
    return f"{value:.7f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kind", choices=list(MAKERS), required=True)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    for name, course in MAKERS[given.kind]().items():
        for autopilot in registered():
            own = course | {"vehicle": course["vehicle"] | {"autopilot": str(autopilot)}}
            if autopilot is Autopilot.PX4 and course["route"].get("mode") == "spline":
                own["route"] = course["route"] | {"mode": "corridor"}
            if autopilot is Autopilot.PX4:
                own.pop("wind", None)
            (given.folder / f"{name}-{autopilot}.toml").write_text(as_toml(own), encoding="utf-8")


if __name__ == "__main__":
    main()
