"""Judge flights on a simulated autopilot: one line a flight, and the table of docs/lab/flown.md.

    python -m tools.fly.judge --rows FILE [--scenarios DIR... --flights DIR]

With `--flights` every folder in DIR that `tools.fly.flown` can read is compared with its mission and scenario, and its
line is written to the CSV file. Without it the lines stay. The table goes to standard output.
"""

import csv
import hashlib
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import get_type_hints

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.forecast.deviation.promise import Kept
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.scenario import Scenario, read_scenario
from tools import command_line
from tools.fly.flown import Flown, read_flown

COLUMNS = ("scenario", "flights", "estimated s", "flown s", "mean", "required m", "nominal m")
LEAST = ("99 % keep m", "least flown m")
LEVELS = (0.9, 0.99)
ROUNDING = 0.005  # [m]
NAMES = {Autopilot.ARDUPILOT: "ArduCopter", Autopilot.PX4: "PX4"}


@dataclass(frozen=True)
class Row:
    """Record a flight: times from arming to disarming [s], least distances to obstacles [m].

    `plan`: first digits of its mission's SHA-256; `least_on_the_way`: between take-off and last waypoint.
    """

    scenario: str
    autopilot: str
    flight: int
    plan: str
    estimated_s: float
    flown_s: float
    required: float
    nominal: float
    kept_90: float
    kept_99: float
    least_on_the_way: float
    least: float
    to: str


def judge(folders: list[Path], scenarios: list[Path]) -> Iterator[Row]:
    """Compare each flight with its scenario; promises are computed once a mission."""
    promises: dict[tuple[str, str], list[Kept]] = {}
    for folder in folders:
        flight = read_flown(folder, {})
        scenario, plan = scenario_of(flight, scenarios), plan_digits(folder / "mission.plan")
        if (flight.name, plan) not in promises:
            promises[flight.name, plan] = [_promised(flight, scenario, level) for level in LEVELS]
        kept_90, kept_99 = promises[flight.name, plan]
        nearest = scenario.airspace.obstacle_clearance(flight.track[:, 1:])
        way = scenario.airspace.obstacle_clearance(flight.on_the_way)
        yield Row(
            scenario=flight.name,
            autopilot=str(flight.mission.autopilot),
            flight=int(folder.name.split("__")[1]),
            plan=plan,
            estimated_s=round(flight.estimated_s, 2),
            flown_s=round(flight.flown_s, 2),
            required=round(scenario.limits.obstacle_distance, 3),
            nominal=round(kept_99.nominal, 3),
            kept_90=round(kept_90.kept, 3),
            kept_99=round(kept_99.kept, 3),
            least_on_the_way=round(float(way.distance), 3),
            least=round(float(nearest.distance), 3),
            to=nearest.what,
        )


def plan_digits(path: Path) -> str:
    """Return the first twelve digits of a mission file's SHA-256."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:12]


def scenario_of(flight: Flown, folders: list[Path]) -> Scenario:
    """Return the scenario of a flight, for its autopilot and in its wind."""
    names = (f"{flight.name}.toml", f"{flight.name.rsplit('_', 1)[0]}.toml")
    path = next(path for name in names for folder in folders if (path := folder / name).exists())
    scenario = read_scenario(path).in_wind(flight.wind)
    vehicle = scenario.vehicle.model_copy(update={"autopilot": flight.mission.autopilot})
    return scenario.model_copy(update={"vehicle": vehicle})


def _promised(flight: Flown, scenario: Scenario, level: float) -> Kept:
    """Return the clearance that a share `level` of flights keeps, at the part of the flight with the least."""
    safety = scenario.safety.model_copy(update={"confidence": level})
    mission = flight.mission.assuming(scenario.vehicle.autopilot_parameters())
    promise = Forecast(mission, scenario.model_copy(update={"safety": safety})).promise
    return min((kept for kept in promise.limits if kept.limit == "obstacles"), key=lambda kept: kept.kept)


def table(rows: list[Row]) -> Iterator[str]:
    """Yield a Markdown line for each scenario and autopilot."""
    columns = (*COLUMNS, *LEAST)
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"
    groups = defaultdict(list)
    for row in rows:
        groups[row.autopilot, row.scenario].append(row)
    for (autopilot, scenario), group in sorted(groups.items()):
        first, flown = group[0], [row.flown_s for row in group]
        cells = (
            f"{scenario}, {NAMES[autopilot_named(autopilot)]}",
            str(len(group)),
            f"{first.estimated_s:.1f}",
            f"{min(flown):.1f} to {max(flown):.1f}",
            f"{100 * (first.estimated_s / float(np.mean(flown)) - 1):+.1f} %",
            *(f"{value:.2f}" for value in (first.required, first.nominal, first.kept_99)),
            f"{min(row.least for row in group):.2f}",
        )
        yield f"| {' | '.join(cells)} |"


def read_rows(path: Path) -> list[Row]:
    kinds = get_type_hints(Row)
    with path.open(encoding="utf-8", newline="") as lines:
        return [Row(**{name: kinds[name](value) for name, value in line.items()}) for line in csv.DictReader(lines)]


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--rows", type=Path, required=True)
    parser.add_argument("--flights", type=Path)
    parser.add_argument("--scenarios", type=Path, nargs="+", default=[Path("missions")])
    given = parser.parse_args()
    if given.flights:
        folders = sorted(path.parent for path in given.flights.glob("*/fly.json"))
        with given.rows.open("w", encoding="utf-8", newline="") as lines:
            written = csv.DictWriter(lines, [field.name for field in fields(Row)], lineterminator="\n")
            written.writeheader()
            written.writerows(map(asdict, judge(folders, given.scenarios)))
    rows = read_rows(given.rows)
    print("\n".join(table(rows)))
    near = sum(row.least < row.required for row in rows)
    short = [sum(row.least < kept - ROUNDING for kept, row in zip(column, rows, strict=True)) for column in _kept(rows)]
    print(f"\n{len(rows)} flights: {near} nearer than required, {short[0]} and {short[1]} than 90 and 99 % keep")


def _kept(rows: list[Row]) -> tuple[list[float], list[float]]:
    """Return the clearances that 90 and 99 % of flights must keep, for each flight [m]."""
    return [row.kept_90 for row in rows], [row.kept_99 for row in rows]


if __name__ == "__main__":
    main()
