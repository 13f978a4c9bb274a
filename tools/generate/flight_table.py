"""Compare estimates with recorded flights.

python -m tools.generate.flight_table          print the tables
python -m tools.generate.flight_table --write  write docs/data/estimates*.csv and the summary in docs/lab/flight-time.md
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.timing.estimate import Estimate, qgroundcontrol_time
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.mission.items import Mission
from ipoa_mission.wind import CALM
from tests.recorded_flights import IN_WIND, LANDINGS, Recorded, read_flights
from tools import REPOSITORY, command_line
from tools.fly.admission_flight import beside
from tools.generate.recorded_rows import put

DOCUMENT = REPOSITORY / "docs" / "lab" / "flight-time.md"
FILES = ("estimates.csv", "estimates-wind.csv", "estimates-landings.csv")
NAMES = {Autopilot.ARDUPILOT: "ArduCopter 4.7", Autopilot.PX4: "PX4 1.17"}


@dataclass(frozen=True)
class Row:
    """Hold times of a flight and its estimate [s] over the judged span, take-off, landing; and the path error [m]."""

    flight: Recorded
    flown: float
    estimated: float
    quoted: float
    take_off: tuple[float, float]
    landing: tuple[float, float]
    miss: float
    kept: float

    @property
    def error(self) -> float:
        return self.estimated / self.flown - 1


def compare(flight: Recorded) -> Row:
    predicted = estimate(flight.mission, flight.parameters, flight.wind)
    done = {item.seq: item.done_s for item in predicted.items}
    main = flight.runs[0]
    return Row(
        flight,
        float(flight.spans.mean()),
        done[flight.last] - done[flight.first],
        _quoted(flight.mission, flight.last) - _quoted(flight.mission, flight.first),
        (float(np.mean([run[flight.first] for run in flight.runs])), done[flight.first]),
        (flight.end_s - main[flight.last], predicted.total_s - done[flight.last]),
        _miss(flight, predicted),
        _kept(flight, predicted),
    )


def _quoted(mission: Mission, items: int) -> float:
    return qgroundcontrol_time(replace(mission, items=mission.items[:items]))


def _miss(flight: Recorded, predicted: Estimate) -> float:
    """Return the 95th percentile of the lateral distance from the predicted path [m]."""
    trace, done = flight.trace, {item.seq: item.done_s for item in predicted.items}
    inside = (trace[:, 0] > flight.runs[0][flight.first]) & (trace[:, 0] < flight.runs[0][flight.last])
    flown = LocalFrame(flight.mission.home).to_local(trace[inside, 1], trace[inside, 2], flight.mission.home.altitude)
    track = predicted.track
    meant = track.points[(track.times >= done[flight.first] - 1) & (track.times <= done[flight.last] + 1)]
    return float(np.quantile([beside(meant[:, :2], place) for place in flown[:, :2]], 0.95))


def _kept(flight: Recorded, predicted: Estimate) -> float:
    runs = flight.runs
    return float(np.mean([i.low_s <= run[i.seq] <= i.high_s for i in predicted.items for run in runs if i.seq in run]))


def table(rows: list[Row]) -> str:
    lines = [
        "| flight | flown, s | estimated, s | error | QGroundControl | take-off | RTL or LAND | path |",
        "|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        flown = f"{row.flown:.1f}"
        if len(row.flight.runs) > 1:
            flown += f" ± {row.flight.spans.std(ddof=1):.1f} ({len(row.flight.runs)})"
        ends = [f"{100 * (estimated / flown_s - 1):+.1f} %" for flown_s, estimated in (row.take_off, row.landing)]
        quoted = f"{100 * (row.quoted / row.flown - 1):+.0f} %"
        cells = (flown, f"{row.estimated:.1f}", f"{100 * row.error:+.1f} %", quoted, *ends, f"{row.miss:.1f} m")
        lines.append(f"| {row.flight.name.rsplit('-', 1)[0]} | " + " | ".join(cells) + " |")
    errors = [abs(100 * row.error) for row in rows]
    off = np.abs([100 * (row.quoted / row.flown - 1) for row in rows])
    kept = np.mean([row.kept for row in rows])
    quoted = f"QGroundControl: median {np.median(off):.0f} %, largest {off.max():.0f} %"
    inside = f"{100 * kept:.0f} % of all items were done within the interval given for them."
    lines += ["", f"{_errors(errors)} ({quoted}). {inside}"]
    if repeated := [abs(100 * row.error) for row in rows if len(row.flight.runs) > 1]:
        lines.append(f"Of the missions that were flown four times: {_errors(repeated).lower()}.")
    return "\n".join(lines)


def _errors(errors: Sequence[float]) -> str:
    return f"Median error {np.median(errors):.2f} %, largest {max(errors):.1f} %"


def wind_table(autopilot: Autopilot) -> str:
    """Return the flights in wind in Markdown, with the estimate's error with and without the wind."""
    lines = [
        "| flight | wind | flown, s | estimated, s | error | without wind | RTL or LAND |",
        "|---|---|--:|--:|--:|--:|--:|",
    ]
    errors, calm_errors = [], []
    for flight in read_flights(autopilot, IN_WIND):
        row, calm = compare(flight), compare(replace(flight, wind=CALM))
        errors.append(abs(100 * row.error))
        calm_errors.append(abs(100 * calm.error))
        gusty = ", gusty" if flight.turbulence else ""
        wind = f"{flight.wind.speed:g} m/s from {flight.wind.from_deg:g}°{gusty}"
        landing = f"{100 * (row.landing[1] / row.landing[0] - 1):+.1f} %"
        route = f"{row.flown:.1f}", f"{row.estimated:.1f}", f"{100 * row.error:+.1f} %", f"{100 * calm.error:+.0f} %"
        cells = wind, *route, landing
        lines.append(f"| {flight.name.rsplit('_w', 1)[0]} | {' | '.join(cells)} |")
    calm_median = f"median {np.median(calm_errors):.0f} %, largest {max(calm_errors):.0f} %"
    return "\n".join([*lines, "", f"{_errors(errors)} (without the wind: {calm_median})."])


def landing_table() -> str:
    lines = [
        "| flight | take-off flown, s | estimated, s | error | LAND flown, s | estimated, s | error |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    summary = []
    for autopilot, name in NAMES.items():
        errors = []
        for flight in read_flights(autopilot, LANDINGS):
            done = {item.seq: item.done_s for item in estimate(flight.mission, flight.parameters).items}
            land = len(flight.mission.items)
            cells, off = [flight.name], []
            for begin, end in ((0, flight.first), (flight.last, land)):
                flown = np.array([run[end] - run.get(begin, 0.0) for run in flight.runs if end in run])
                ours = done[end] - done.get(begin, 0.0)
                spread = f" ± {flown.std(ddof=1):.1f} ({len(flown)})" if len(flown) > 1 else ""
                off.append(100 * (ours / flown.mean() - 1))
                cells += [f"{flown.mean():.1f}{spread}", f"{ours:.1f}", f"{off[-1]:+.1f} %"]
            lines.append(f"| {' | '.join(cells)} |")
            errors.append(np.abs(off))
        (take_off, land), (most, longest) = np.median(errors, axis=0), np.max(errors, axis=0)
        first = f"take-off median {take_off:.1f} %, largest {most:.1f} %"
        summary.append(f"* {name}: {first}; LAND median {land:.1f} %, largest {longest:.1f} %.")
    return "\n".join([*lines, "", *summary])


def tables() -> str:
    parts = [f"### {name}\n\n{table([*map(compare, read_flights(each))])}" for each, name in NAMES.items()]
    parts += [f"### {name} in wind\n\n{wind_table(autopilot)}" for autopilot, name in NAMES.items()]
    return "\n\n".join([*parts, f"### Take-off and landing, armed as `fly` arms\n\n{landing_table()}"])


if __name__ == "__main__":
    parser = command_line(__doc__)
    parser.add_argument("--write", action="store_true", help="write the files")
    is_written, text = parser.parse_args().write, tables()
    put(text, DOCUMENT, FILES) if is_written else print(text)
