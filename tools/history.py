"""Measure each release: append to docs/data/history.csv, and plot it.

    taskset -c 0 python -m tools.history             measure every shipped scenario, append, plot
    python -m tools.history --plot history.svg       plot what is there

A row is one measure of one scenario by one version. Costs and times are the same on any machine, CPU seconds are not.
"""

import csv
import time
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import ipoa_mission as api
from tools import REPOSITORY, command_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HISTORY = REPOSITORY / "docs" / "data" / "history.csv"


@dataclass(frozen=True)
class Row:
    version: str
    date: str
    scenario: str
    measure: str
    value: float


def measured(path: Path, version: str, date: str) -> Iterator[Row]:
    scenario = api.read_scenario(path)
    begun = time.process_time()
    flight = api.plan_flight(scenario)
    planned = time.process_time()
    again = api.estimate(flight.mission, wind=scenario.wind.air())
    values = {
        "path cost": flight.plan.cost.total,
        "estimated time [s]": again.total_s,
        "plan [s of CPU]": planned - begun,
        "estimate [s of CPU]": time.process_time() - planned,
    }
    yield from (Row(version, date, path.stem, measure, round(value, 3)) for measure, value in values.items())


def append(rows: Iterator[Row], path: Path) -> None:
    is_new = not path.exists()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if is_new:
            writer.writerow([field.name for field in fields(Row)])
        for row in rows:
            writer.writerow(astuple(row))
            print(*astuple(row), flush=True)


def read(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        next(rows := csv.reader(file))
        return [Row(version, date, scenario, measure, float(value)) for version, date, scenario, measure, value in rows]


def plotted(rows: list[Row]) -> "Figure":
    """Plot a panel a measure and a line a scenario over the versions, relative to the first."""
    import matplotlib
    from matplotlib.figure import Figure

    from ipoa_mission.report.plots import STYLE

    measures = list(dict.fromkeys(row.measure for row in rows))
    versions = list(dict.fromkeys(row.version for row in rows))
    with matplotlib.rc_context(dict(STYLE)):
        figure = Figure(figsize=(4.0 * len(measures), 3.2), layout="constrained")
        for panel, measure in zip(figure.subplots(1, len(measures), squeeze=False)[0], measures, strict=True):
            for scenario in dict.fromkeys(row.scenario for row in rows):
                mine = [row for row in rows if (row.scenario, row.measure) == (scenario, measure)]
                places = [versions.index(row.version) for row in mine]
                panel.plot(places, [row.value / mine[0].value for row in mine], marker="o", label=scenario)
            panel.set(title=measure, ylabel="over the first")
            panel.set_xticks(range(len(versions)), versions)
        figure.axes[0].legend(frameon=False)
    return figure


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--scenarios", type=Path, nargs="*", default=sorted((REPOSITORY / "missions").glob("*.toml")))
    parser.add_argument("--version", default=api.__version__, help="what the rows are called")
    parser.add_argument("--rows", type=Path, default=HISTORY)
    parser.add_argument("--plot", type=Path, help="plot only, into this file")
    wanted = parser.parse_args()
    if wanted.plot is None:
        date = datetime.now(UTC).date().isoformat()
        api.plan_flight(api.read_scenario(wanted.scenarios[0]))  # compile before measuring
        append((row for path in wanted.scenarios for row in measured(path, wanted.version, date)), wanted.rows)
    api.write_picture(plotted(read(wanted.rows)), wanted.plot or wanted.rows.with_suffix(".svg"))


if __name__ == "__main__":
    main()
