"""Fly every recorded mission on the built-in autopilot.

python -m tools.generate.built_in_autopilot_table          print the table
python -m tools.generate.built_in_autopilot_table --write  write docs/data/built-in-autopilot.csv and its page's summary
"""

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from tests.flown_here import fly_here
from tests.recorded_flights import Recorded, read_flights
from tools import REPOSITORY, command_line
from tools.generate.recorded_rows import put

DOCUMENT = REPOSITORY / "docs" / "lab" / "built-in-autopilot.md"
NAMES = {Autopilot.ARDUPILOT: "ArduCopter 4.7", Autopilot.PX4: "PX4 1.17"}
SEEDS = {Autopilot.ARDUPILOT: range(1), Autopilot.PX4: range(8)}  # ArduCopter's flights do not depend on it


def row(flight: Recorded) -> tuple[str, float]:
    flown = [fly_here(flight, seed) for seed in SEEDS[flight.mission.autopilot]]
    spans = np.array([done[flight.last] - done[flight.first] for done, _ in flown])
    landing = float(np.mean([end - done[flight.last] for done, end in flown]))
    recorded_landing = flight.end_s - flight.runs[0][flight.last]
    error = float(spans.mean() / flight.spans.mean() - 1)
    spans_and_error = spread(flight.spans), spread(spans), f"{100 * error:+.1f} %"
    landings = f"{recorded_landing:.1f}", f"{landing:.1f}", f"{100 * (landing / recorded_landing - 1):+.1f} %"
    cells = flight.name.rsplit("-", 1)[0], *spans_and_error, *landings
    return f"| {' | '.join(cells)} |", error


def spread(spans: np.ndarray) -> str:
    return f"{spans.mean():.1f}" + (f" ± {spans.std(ddof=1):.1f} ({len(spans)})" if len(spans) > 1 else "")


def table(autopilot: Autopilot) -> str:
    flights = read_flights(autopilot)
    rows = [row(flight) for flight in flights]
    errors = np.abs([100 * error for _, error in rows])
    lines = [
        "| flight | recorded, s | flown here, s | error | RTL or LAND recorded, s | here, s | error |",
        "|---|--:|--:|--:|--:|--:|--:|",
        *(line for line, _ in rows),
        "",
        f"Median error {np.median(errors):.1f} %, largest {errors.max():.1f} %; {(errors <= 5).sum()} of {len(errors)} "
        "within 5 %.",
    ]
    if repeated := [error for error, flight in zip(errors, flights, strict=True) if len(flight.runs) > 1]:
        summary = f"median error {np.median(repeated):.1f} %, largest {max(repeated):.1f} %"
        lines.append(f"Of the missions that were recorded four times: {summary}.")
    return "\n".join(lines)


def tables() -> str:
    return "\n\n".join(f"### {name}\n\n{table(autopilot)}" for autopilot, name in NAMES.items())


if __name__ == "__main__":
    parser = command_line(__doc__)
    parser.add_argument("--write", action="store_true", help="write the files")
    is_written, text = parser.parse_args().write, tables()
    put(text, DOCUMENT, ("built-in-autopilot.csv",)) if is_written else print(text)
