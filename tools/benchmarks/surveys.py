"""How long surveys of areas with holes take that are planned here, and by others, on each autopilot.

    python -m tools.benchmarks.surveys [--holes 0 1 ...] [--maps 20] [--turned] [--csv FILE]
                                       [--autopilots px4 ...]

Each map is planned by `quickest_tour`, by boustrophedon cells as a generalized traveling salesman's problem, and as
QGroundControl lays out its transects: as they are, through holes; led round them; and so near to each other that they
see 99.9 % too, by steps of 1 %. All begin and end at a corner of the map, have the same spacing but for these, and are
flown by the forecast of a mission of their corners. Coverage and how far the path leaves the area are told by
`coverage`, the sensor on all the way for all but ours. Times are sums [s], CPU is the median [s]. `--turned`: each map
lies at an angle of its own, as fields do. Maps that are already in FILE are not planned again.
"""

import csv
import io
import statistics
import sys
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely

from ipoa_mission.files import write_atomically
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.items import Mission, change_speed, takeoff, waypoint
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.cover import quickest_tour
from ipoa_mission.survey.coverage import Coverage, coverage
from ipoa_mission.survey.free import FreeSpace, Ways
from ipoa_mission.survey.times import LegTimes
from ipoa_mission.survey.tour import Swath, Tour
from ipoa_mission.vehicles.autopilot import Autopilot, registered
from ipoa_mission.world.frame import Geodetic, LocalFrame
from tools import command_line
from tools.benchmarks.survey_benchmark.boustrophedon import sweep_cells
from tools.benchmarks.survey_benchmark.maps import MAPS, MOST_HOLES, SPACING, SPEED, survey_map
from tools.benchmarks.survey_benchmark.transects import led_round, transects

HOME = Geodetic(47.397742, 8.545594, 488.0)
HEIGHT = 20.0
ENOUGH = 0.999  # share of the area
Row = tuple[str, str, int, int, float, float, float, float]
INSIDE = 1e-3  # of the way from a corner to the middle: where all begin and end


def flown_seconds(path: Points, autopilot: Autopilot) -> float:
    """From the first corner of a path (n, 2) to the last, by the forecast of its mission."""
    places = np.column_stack([path, np.full(len(path), HEIGHT)])
    latitude, longitude, altitude = LocalFrame(HOME).to_geodetic(places)
    corners = [Geodetic(*map(float, at)) for at in zip(latitude, longitude, altitude, strict=True)]
    items = (takeoff(corners[0], HEIGHT), change_speed(SPEED), *(waypoint(at, HEIGHT) for at in corners))
    done = Forecast(Mission(HOME, items, autopilot)).predicted(sure=True).done
    return float(done[-1] - done[2])


def all_on(path: Points) -> Tour:
    """A path with the sensor on all the way."""
    swaths = tuple(Swath(*leg) for leg in pairwise(path))
    return Tour(swaths, tuple(np.array([swath.end, swath.end]) for swath in swaths[:-1]))


def ours(area: Area, cost: LegTimes, place: Vector) -> tuple[Points, Tour]:
    """Our tour, with the ways to its begin from a place and back."""
    tour = quickest_tour(area, SPACING, cost=cost, begin=place, end=place)
    path, space = tour.path, FreeSpace.of(area.shape)
    ways = Ways(np.array([place, place, path[0], path[0], path[-1], path[-1]]), space, space, cost)
    return np.concatenate([ways.way(0, 2)[:-1], path, ways.way(4, 0)[1:]]), tour


def planned(area: Area, cost: LegTimes) -> Iterator[tuple[str, Points, Tour, float]]:
    """Name, path, what is seen and CPU of each planner."""
    ring = area.shape.geoms[0].exterior
    place = shapely.get_coordinates(ring)[0]
    place = place + INSIDE * (shapely.get_coordinates(ring.centroid)[0] - place)
    started = time.process_time()
    path, tour = ours(area, cost, place)
    yield "ours", path, tour, time.process_time() - started
    started = time.process_time()
    path = sweep_cells(area, SPACING, cost, place)
    yield "cells, salesman", path, all_on(path), time.process_time() - started
    lines = transects(area, SPACING, HOME)
    path = np.concatenate([[place], lines, [place]])
    yield "QGroundControl", path, all_on(path), 0.0
    path = led_round(lines, area, cost, place)
    yield "QGroundControl, led round", path, all_on(path), 0.0
    for nearer in np.arange(1.0, 0.3, -0.01):
        path = led_round(transects(area, SPACING * float(nearer), HOME), area, cost, place)
        if coverage(area, all_on(path), SPACING).share >= ENOUGH:
            yield "QGroundControl, led round, sees 99.9 %", path, all_on(path), 0.0
            break


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--holes", type=int, nargs="*", default=range(MOST_HOLES + 1))
    parser.add_argument("--maps", type=int, default=MAPS)
    parser.add_argument("--autopilots", nargs="*", help="their names; left out, all")
    parser.add_argument("--turned", action="store_true")
    parser.add_argument("--csv", type=Path)
    wanted = parser.parse_args()
    rows = recorded(wanted.csv) if wanted.csv else []
    known = {(row[0], *row[2:4]) for row in rows}
    for number in range(wanted.maps):
        for autopilot in (one for one in registered() if str(one) in (wanted.autopilots or map(str, registered()))):
            cost = LegTimes.of(Mission(HOME, (), autopilot), SPEED, HEIGHT)
            for holes in wanted.holes:
                if (str(autopilot), holes, number) not in known:
                    rows += [*judged(survey_map(holes, number, wanted.turned), cost, autopilot, holes, number)]
                    if wanted.csv:
                        record(wanted.csv, rows)
        print(f"map {number} of each number of holes", file=sys.stderr)
    tell(rows)


def judged(area: Area, cost: LegTimes, autopilot: Autopilot, holes: int, number: int) -> Iterator[Row]:
    """What each planner comes to on one map."""
    for name, path, tour, cpu in planned(area, cost):
        seen: Coverage = coverage(area, tour, SPACING)
        seconds = flown_seconds(path, autopilot)
        yield str(autopilot), name, holes, number, seconds, seen.share, seen.outside_m, cpu


def recorded(file: Path) -> list[Row]:
    """The rows of a run before, if there was one."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as lines:
        return [
            (a, b, int(c), int(d), float(e), float(f), float(g), float(h))
            for a, b, c, d, e, f, g, h in csv.reader(lines)
        ]


def record(file: Path, rows: list[Row]) -> None:
    """All rows so far, whole or not at all."""
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    write_atomically(file, text.getvalue())


def tell(rows: list[Row]) -> None:
    """Tables by number of holes, and over all."""
    print("| autopilot | holes | planner | flown [s] | of ours | worst of ours | least share | outside [m] | CPU [s] |")
    print("|---|---:|---|---:|---:|---:|---:|---:|---:|")
    counts = sorted({row[2] for row in rows})
    for autopilot in dict.fromkeys(row[0] for row in rows):
        for some in [*([n] for n in counts), counts]:
            mine = {row[2:4]: row[4] for row in rows if row[:2] == (autopilot, "ours") and row[2] in some}
            for name in dict.fromkeys(row[1] for row in rows):
                those = [row for row in rows if row[:2] == (autopilot, name) and row[2] in some]
                if not those:
                    continue
                same = sum(mine[row[2:4]] for row in those)
                total, worst = sum(row[4] for row in those), min(row[4] / mine[row[2:4]] for row in those)
                print(
                    f"| {autopilot} | {some[0] if len(some) == 1 else 'all'} | {name} | {total:.0f} "
                    f"| {total / same:.3f} | {worst:.3f} | {min(row[5] for row in those):.4f} "
                    f"| {max(row[6] for row in those):.2f} | {statistics.median(row[7] for row in those):.2f} |"
                )


if __name__ == "__main__":
    main()
