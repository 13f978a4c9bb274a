"""Hold recorded flights against the tube: what each promised and kept, and how far it lay beside its predicted path.

    python -m tools.benchmarks.tube [--scenarios DIR...] FLIGHT... [--passes FILE] [--traces FILE]

A FLIGHT is a folder that `tools.fly.flown` reads; its scenario is in it or in a DIR. Two tables go to standard output:
a line a mission, and how many flights fell short of what 50, 90 and 99 % were to keep, by autopilot and length.
`--passes` writes for every pass of some seconds how far the flight got to the east, north, west, south, up and down of
its predicted path, `--traces` where it was beside it, every second: what the law is made of.
"""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ipoa_mission.forecast.deviation.pieces import Pieces, pieces_of
from ipoa_mission.forecast.deviation.promise import PredictedFlight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.scenario import Scenario, read_scenario
from tools import command_line
from tools.fly.flown import Flown, is_flown, read_flown

LEVELS = (0.5, 0.9, 0.99)
PASS = 4.0  # a line of `--passes` [s]
LONG = 120.0  # a longer way from the take-off to the last waypoint is a long one [s]
COLUMNS = ("mission", "flights", "required", "nominal", "50 % keep", "90 %", "99 %", "flown", "short of 50, 90, 99 %")
GROUPS = ("autopilot", "way", "flights", "short of 50 %", "of 90 %", "of 99 %")


def promises(flown: Flown, scenario: Scenario) -> tuple[float, float, list[float]]:
    """Required, nominal, and what is kept at each level, to obstacles on the way [m]."""
    forecast = Forecast(flown.mission, wind=flown.wind)
    prediction = forecast.predicted(sure=True, fast=True)
    flight = PredictedFlight(forecast.itinerary, prediction, flown.mission.autopilot, scenario)
    found = [next(k for k in flight.limits(1 - level) if k.limit == "obstacles" and k.on_the_way) for level in LEVELS]
    return found[0].required, found[0].nominal, [each.kept for each in found]


def table(flights: list[Flown], scenarios: list[Path]) -> Iterator[str]:
    """The table by mission, as Markdown, and the one by length."""
    missions = defaultdict(list)
    for flight in flights:
        missions[flight.name, str(flight.mission.autopilot)].append(flight)
    counts: dict[tuple[str, str], list[list[bool]]] = defaultdict(list)
    yield from _head(COLUMNS)
    for (name, autopilot), group in sorted(missions.items(), key=lambda pair: (pair[0][1], pair[0][0])):
        paths = [folder / f"{stem}.toml" for stem in (name, name.split("_v")[0]) for folder in scenarios]
        path = group[0].scenario or next((path for path in paths if path.exists()), None)
        if path is None or not (scenario := read_scenario(path)).airspace.obstacles:
            continue
        required, nominal, kept = promises(group[0], scenario)
        flown = np.array([_flown_clearance(flight, scenario) for flight in group])
        short = [[value < level for level in kept] for value in flown]
        for flight, row in zip(group, short, strict=True):
            counts[autopilot, "long" if flight.end - flight.begin >= LONG else "short"].append(row)
        numbers = " | ".join(f"{value:.2f}" for value in (required, nominal, *kept, flown.min()))
        yield f"| {name}, {autopilot} | {len(group)} | {numbers} | {', '.join(map(str, np.sum(short, axis=0)))} |"
    yield ""
    yield from _head(GROUPS)
    for (autopilot, way), rows in sorted(counts.items()):
        total = " | ".join(f"{n} ({n / len(rows):.0%})" for n in np.sum(rows, axis=0))
        yield f"| {autopilot} | {way} | {len(rows)} | {total} |"


def _head(columns: tuple[str, ...]) -> Iterator[str]:
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"


def _flown_clearance(flight: Flown, scenario: Scenario) -> float:
    return float(scenario.airspace.obstacle_clearance(flight.on_the_way).distance)


def passes(flights: list[Flown]) -> Iterator[str]:
    """A line a pass: mission, autopilot, number of the flight, second, on the way or not, bend, six distances."""
    yield "mission,autopilot,flight,at_s,on_the_way,across,east,north,west,south,up,down"
    for number, (flight, course) in enumerate(_with_courses(flights)):
        key, times = (flight.name, str(flight.mission.autopilot)), flight.track[:, 0]
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


def traces(flights: list[Flown], judged: int) -> Iterator[str]:
    """A line a second on the way: autopilot, number of the flight, judged or not, second, bend, east, north, up."""
    for number, (flight, course) in enumerate(_with_courses(flights)):
        way = (flight.track[:, 0] >= flight.begin) & (flight.track[:, 0] <= flight.end)
        times = flight.track[way, 0] - flight.begin
        _, each = np.unique(times.astype(int), return_index=True)
        beside, piece = _beside(flight.track[way][each, 1:], course)
        for at, across, (east, north, up) in zip(times[each], course.across[piece], beside, strict=True):
            numbers = f"{at:.0f},{across:.1f},{east:.2f},{north:.2f},{up:.2f}"
            yield f"{flight.mission.autopilot},{number},{judged},{numbers}"


def _with_courses(flights: list[Flown]) -> Iterator[tuple[Flown, Pieces]]:
    """Every flight with its predicted path; a mission that is flown again is predicted once."""
    courses: dict[tuple[str, str], Pieces] = {}
    for flight in flights:
        key = flight.name, str(flight.mission.autopilot)
        if key not in courses:
            track = Forecast(flight.mission, wind=flight.wind).predicted(sure=True, fast=True).track
            courses[key] = pieces_of(track.local())
        yield flight, courses[key]


def _beside(places: Points, course: Pieces) -> tuple[Points, np.ndarray]:
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
    parser = command_line(__doc__)
    parser.add_argument("flights", type=Path, nargs="+")
    parser.add_argument("--scenarios", type=Path, nargs="+", default=[])
    parser.add_argument("--passes", type=Path)
    parser.add_argument("--traces", type=Path)
    parser.add_argument("--judged", type=int, choices=(0, 1), default=1, help="what the traces are for")
    given = parser.parse_args()
    missions: dict[str, Path] = {}
    flights = [read_flown(folder, missions) for folder in sorted(given.flights) if is_flown(folder)]
    if given.passes:
        given.passes.write_text("\n".join(passes(flights)) + "\n", encoding="utf-8")
    if given.traces:
        lines = ["autopilot,flight,judged,second,across,east,north,up", *traces(flights, given.judged)]
        given.traces.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(table(flights, given.scenarios)))


if __name__ == "__main__":
    main()
