r"""Fly surveys on a simulated autopilot, and compare flight time and number of photos with the forecast.

    python -m tools.fly.surveys --autopilot ardupilot --link tcp:127.0.0.1:5760 --work DIR --rows FILE \
        --start "env AC_DIR={folder} ac.sh 0 20 {latitude} {longitude} {altitude}" [--numbers 0 1 ...]

A survey's number determines its area, holes, obstacles, camera and speed, and its wind if the simulation has one. Lines
are added to FILE; its surveys are not flown again. The simulation needs a camera: ArduPilot with CAM1_TYPE = 1, PX4
with TRIG_MODE = 4 and TRIG_INTERFACE = 3.
"""

import argparse
import csv
import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.flight.procedure import fly_forecast
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.scenario.scenario_file import scenario_of
from ipoa_mission.survey.flown_coverage import AsFlown, as_flown, expected_lines
from ipoa_mission.survey.survey_flight import Survey, plan_survey
from ipoa_mission.vehicles.arducopter.dataflash import read_records
from tools import command_line
from tools.fly.ended_flight import flight_from
from tools.fly.flown import ARMED_STATE
from tools.fly.simulators import connected, newest_log, set_up, simulation

COUNT = 20
HOME = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
KINDS = ("field", "hole", "concave", "tower", "corridor")
AROUND, LATE = 3.0, 0.03  # tolerance of the time at a place: seconds, and share of the expected time
WINDY = 4  # every fourth has wind
PHOTO = "camera_trigger"  # PX4's topic, one message a photo


@dataclass(frozen=True)
class Row:
    """Record a flight from arming to disarming [s], with its photos as forecast and in the vehicle's log.

    `seen`: share of the visible area within half a spacing of the path along the lines. `outside_m`: distance of that
    path from the area. Both as forecast and by the simulator's true track.
    """

    survey: int
    kind: str
    autopilot: str
    wind_m_s: float
    lines: int
    speed_m_s: float
    estimated_s: float
    flown_s: float
    photos: int
    photos_logged: int
    seen_expected: float
    seen: float
    outside_expected_m: float
    outside_m: float

    @property
    def off(self) -> float:
        """Return the relative error of the estimated time."""
        return self.estimated_s / self.flown_s - 1


def surveyed(number: int, autopilot: Autopilot) -> dict[str, Any]:
    """Return the scenario of a survey's number."""
    rng = np.random.default_rng(number)
    kind = KINDS[number % len(KINDS)]
    wide, deep = rng.uniform(60.0, 110.0, 2).round().tolist()
    middle = rng.uniform(40.0, 70.0) * np.array([math.sin(number), math.cos(number)])

    def ring(*shares: tuple[float, float]) -> list[list[float]]:
        angle = math.radians(37.0 * number)
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        corners: list[list[float]] = (middle + np.array(shares) * (wide, deep) @ turn).round(2).tolist()
        return corners

    rings = [ring((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    if kind == "hole":
        rings.append(ring((-0.15, -0.2), (0.2, -0.1), (0.05, 0.2)))
    if kind == "concave":
        rings = [ring((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (0.1, 0.5), (0.1, 0.0), (-0.5, 0.0))]
    area: dict[str, Any] = {"polygon": rings}
    if kind == "corridor":
        area = {"line": ring((-1.0, -0.5), (0.0, 0.0), (1.2, 0.1)), "width": 30.0}
    survey = {
        **area,
        "camera": "DJI Mavic 3E",
        "height_above_ground": round(float(rng.uniform(28.0, 45.0)), 1),
        "side_overlap": 0.7 if kind != "corridor" else 0.75,
        "front_overlap": round(float(rng.uniform(0.6, 0.75)), 2),
    }
    tower = {"kind": "cylinder", "name": "tower", "east": middle[0], "north": middle[1], "radius": 4.0, "height": 70.0}
    return {
        "name": f"survey{number:02d}",
        "home": HOME,
        "survey": survey,
        "vehicle": {"autopilot": str(autopilot), "cruise_speed": round(float(rng.uniform(4.0, 8.0)), 1)},
        **({"obstacles": [tower]} if kind == "tower" else {}),
        **({"wind": _wind(rng)} if number % WINDY == 1 and autopilot is Autopilot.ARDUPILOT else {}),
    }


def _wind(rng: np.random.Generator) -> dict[str, float]:
    return {"speed": round(float(rng.uniform(2.5, 4.5)), 1), "from_deg": round(float(rng.uniform(0.0, 360.0)))}


def flown(survey: Survey, given: argparse.Namespace) -> tuple[FlightRecord, Path]:
    """Fly it, and return the record and the vehicle's log."""
    (forecast,) = survey.flights
    folder, home = given.work / survey.name, forecast.mission.home
    words = given.start.format(
        latitude=home.latitude_deg, longitude=home.longitude_deg, altitude=home.altitude, folder=folder
    )
    with simulation(words, folder), connected(given.link) as vehicle:
        set_up(vehicle, forecast.wind)
        record = fly_forecast(vehicle, forecast, set_params=True, anyway=False)
        time.sleep(1.0)  # wait for the log's last lines
    return record, newest_log(folder)


def seen_by(survey: Survey, log: Path) -> tuple[AsFlown, AsFlown]:
    """Return the view of a survey's only flight as forecast and by its true track, at most a spacing wide."""
    plan, (forecast,) = survey.plan, survey.flights
    expected, ends = expected_lines(forecast, plan.tour, plan.scenario.frame)
    flight = flight_from(log, forecast.mission.home)
    times, points = flight.track[:, 0], flight.track[:, 1:]
    true = Track(times, points, np.zeros(len(times)))
    passed = list[float]()
    for due, place in zip(ends.ravel().tolist(), expected.at(ends.ravel()), strict=True):
        near = np.abs(times - due) < AROUND + LATE * due
        away = np.where(near, np.linalg.norm(points[:, :2] - place[:2], axis=1), np.inf)
        passed.append(float(times[away.argmin()]))
    width = plan.sight.spacing
    visible = plan.area.visible(plan.keep_out, width)
    one, other = (
        as_flown([flight], plan.area.shape, visible, width)
        for flight in ((expected, ends), (true, np.array(passed).reshape(-1, 2)))
    )
    return one, other


def photos_in(log: Path) -> int:
    """Count the photos in the vehicle's log."""
    if log.suffix == ".BIN":
        return sum(1 for _ in read_records(log, frozenset({"CAM"})))
    read: Any = import_module("pyulog").ULog(str(log), [PHOTO, "vehicle_status"])
    topics = {topic.name: topic.data for topic in read.data_list}
    status = topics["vehicle_status"]
    armed = status["timestamp"][np.argmax(status["arming_state"] == ARMED_STATE)]
    return int((topics[PHOTO]["timestamp"] > armed).sum())  # its driver reports one at its start


def rows_of(path: Path) -> Iterator[Row]:
    if path.exists():
        with path.open(encoding="utf-8", newline="") as lines:
            for line in csv.DictReader(lines):
                yield Row(**{each.name: each.type(line[each.name]) for each in fields(Row)})  # type: ignore[operator]


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--autopilot", required=True, choices=["px4", "ardupilot"])
    parser.add_argument("--link", required=True)
    parser.add_argument("--start", required=True)
    parser.add_argument("--work", required=True, type=Path, help="where the simulator runs")
    parser.add_argument("--rows", required=True, type=Path)
    parser.add_argument("--numbers", type=int, nargs="*", default=range(COUNT))
    given = parser.parse_args()
    autopilot = autopilot_named(given.autopilot)
    rows = list(rows_of(given.rows))
    for number in given.numbers:
        if any((row.survey, row.autopilot) == (number, given.autopilot) for row in rows):
            continue
        scenario = scenario_of(surveyed(number, autopilot), Path("survey"))
        survey = plan_survey(scenario=scenario)
        record, log = flown(survey, given)
        if not record.completed:
            print(f"{survey.name}: not complete: {record.why_not}", flush=True)
            continue
        expected, true = seen_by(survey, log)
        rows.append(
            Row(
                survey=number,
                kind=KINDS[number % len(KINDS)],
                autopilot=given.autopilot,
                wind_m_s=scenario.wind.air().speed,
                lines=len(survey.plan.tour.swaths),
                speed_m_s=round(survey.plan.scenario.vehicle.cruise_speed, 2),
                estimated_s=round(survey.total_s, 2),
                flown_s=round(record.total_s, 2),
                photos=survey.plan.photos,
                photos_logged=photos_in(log),
                seen_expected=round(expected.share, 5),
                seen=round(true.share, 5),
                outside_expected_m=round(expected.outside_m, 2),
                outside_m=round(true.outside_m, 2),
            )
        )
        with given.rows.open("w", encoding="utf-8", newline="") as lines:
            written = csv.DictWriter(lines, [field.name for field in fields(Row)], lineterminator="\n")
            written.writeheader()
            written.writerows(map(asdict, rows))
        print(f"{rows[-1]} {100 * rows[-1].off:+.1f} %", flush=True)


if __name__ == "__main__":
    main()
