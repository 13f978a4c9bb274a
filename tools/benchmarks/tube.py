"""Hold recorded flights against the tube: what each promised and kept, and how far it lay beside its predicted path.

    python -m tools.benchmarks.tube --scenarios DIR FLIGHT... [--passes FILE]

A FLIGHT is a folder that `tools.fly.flown` reads. The table, a line a mission, goes to standard output; `--passes`
writes for every pass of some seconds how far the flight got to the east, north, west, south, up and down of its
predicted path: what the law is made of.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.items import Mission
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.timing.estimate import in_local_frame, predict
from ipoa_mission.tube.course import Course, course_of
from ipoa_mission.tube.law import PASS
from ipoa_mission.tube.promise import PredictedFlight
from tools.fly.flown import Flown, is_flown, read_flown

LEVELS = (0.9, 0.99)
COLUMNS = ("mission", "flights", "required", "nominal", "90 % keep", "99 % keep", "flown", "short of 90, 99 %")


def promises(mission: Mission, scenario: Scenario) -> tuple[float, float, list[float]]:
    """Required, nominal, and what is kept at each level, to obstacles on the way [m]."""
    route, prediction = predict(mission, fast=True, sure=True)
    flight = PredictedFlight(route, prediction, mission.autopilot, scenario)
    found = [next(k for k in flight.limits(1 - level) if k.limit == "obstacles" and k.on_the_way) for level in LEVELS]
    return found[0].required, found[0].nominal, [each.kept for each in found]


def table(flights: list[Flown], scenarios: Path) -> Iterator[str]:
    """The table by mission, as Markdown."""
    groups = defaultdict(list)
    for flight in flights:
        groups[flight.name, str(flight.mission.autopilot)].append(flight)
    yield f"| {' | '.join(COLUMNS)} |"
    yield f"|{'---|' * len(COLUMNS)}"
    short, count = [0, 0], 0
    for (name, autopilot), group in sorted(groups.items(), key=lambda pair: (pair[0][1], pair[0][0])):
        path = scenarios / f"{name.split('_v')[0]}.toml"
        if not path.exists() or not (scenario := read_scenario(path)).airspace.obstacles:
            continue
        required, nominal, kept = promises(group[0].mission, scenario)
        flown = np.array([_flown_clearance(flight, scenario) for flight in group])
        missed = [int((flown < level - 0.005).sum()) for level in kept]
        short, count = [a + b for a, b in zip(short, missed, strict=True)], count + len(group)
        numbers = " | ".join(f"{value:.2f}" for value in (required, nominal, *kept, flown.min()))
        yield f"| {name}, {autopilot} | {len(group)} | {numbers} | {missed[0]}, {missed[1]} |"
    yield f"| all | {count} | | | | | | {short[0]}, {short[1]} |"


def _flown_clearance(flight: Flown, scenario: Scenario) -> float:
    return float(scenario.airspace.obstacle_clearance(flight.on_the_way).distance)


def passes(flights: list[Flown]) -> Iterator[str]:
    """A line a pass: mission, autopilot, number of the flight, second, on the way or not, bend, six distances."""
    yield "mission,autopilot,flight,at_s,on_the_way,across,east,north,west,south,up,down"
    courses: dict[tuple[str, str], Course] = {}
    for number, flight in enumerate(flights):
        key = flight.name, str(flight.mission.autopilot)
        if key not in courses:
            courses[key] = course_of(
                in_local_frame(predict(flight.mission, flight.wind, fast=True, sure=True)[1].track)
            )
        course, times = courses[key], flight.track[:, 0]
        beside, piece = _beside(flight.track[:, 1:], course)
        across, during = course.across[piece], ((times - times[0]) // PASS).astype(int)
        for n in np.unique(during):
            here = during == n
            east, north, up = beside[here].T
            ends = (east.max(), north.max(), -east.min(), -north.min(), up.max(), -up.min())
            middle = float(times[here].mean())
            way = int(flight.begin <= middle <= flight.end)
            told = ",".join(f"{value:.2f}" for value in (across[here].max(), *ends))
            yield f"{key[0]},{key[1]},{number},{middle:.0f},{way},{told}"


def _beside(places: Points, course: Course) -> tuple[Points, np.ndarray]:
    """From the nearest point of the course to each place, (n, 3), and on which piece that is, (n,)."""
    a, step = course.points[:-1], np.diff(course.points, axis=0)
    squares = np.maximum((step**2).sum(axis=1), 1e-12)
    found, pieces = np.empty_like(places), np.empty(len(places), dtype=int)
    for n, place in enumerate(places):
        along = np.clip(((place - a) * step).sum(axis=1) / squares, 0.0, 1.0)
        away = place - a - along[:, None] * step
        pieces[n] = int(np.argmin((away**2).sum(axis=1)))
        found[n] = away[pieces[n]]
    return found, pieces


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path, nargs="+")
    parser.add_argument("--scenarios", type=Path, required=True)
    parser.add_argument("--passes", type=Path)
    given = parser.parse_args()
    missions: dict[str, Path] = {}
    flights = [read_flown(folder, missions) for folder in sorted(given.flights) if is_flown(folder)]
    if given.passes:
        given.passes.write_text("\n".join(passes(flights)) + "\n", encoding="utf-8")
    print("\n".join(table(flights, given.scenarios)))


if __name__ == "__main__":
    main()
