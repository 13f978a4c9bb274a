"""Compare what the package computes with a manifest of digests, over shipped and random scenarios on each autopilot.

    python -m tools.freeze --write FILE
    python -m tools.freeze --against FILE

Each scenario is planned, and its files are digested: `.plan`, `.waypoints`, `.params`, `.json`. So are the estimate and
the checks of the mission, and the error of a refusal. Prose (any string with a blank, in JSON or an error) has a digest
of its own, so that a rewording is listed as "words only". The exit code is 1 if an output differs.
"""

import hashlib
import json
import math
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import cycle, product
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.checks.check import check_mission
from ipoa_mission.cli.checking import estimate_as_json
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.flight import plan_flight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.report.summary import findings_as_json
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.scenario_file import scenario_of
from ipoa_mission.survey.survey_flight import plan_survey
from tools import command_line
from tools.fly.admission_scenes import KINDS, MISSIONS, as_flown_by, scene, scene_name, shipped
from tools.fly.layouts import HOME, mast

SEED, RANDOM, SURVEYS = 4, 40, 4
Outputs = dict[str, tuple[str, str]]  # digests of data and of prose by name


def cases() -> Iterator[tuple[str, Scenario]]:
    """Scenarios by name: every shipped one on each autopilot, then random flights and surveys that take turns."""
    one, other = registered()
    for path, autopilot in product(shipped(), registered()):
        yield f"{path.stem} on {autopilot}", as_flown_by(path, autopilot)
    for number in range(RANDOM):
        autopilot = (one, other)[(number + number // len(KINDS)) % 2]  # each kind meets both in turn
        yield f"{scene_name(number, SEED)} on {autopilot}", scenario_of(scene(number, SEED, autopilot), MISSIONS)
    for number, autopilot in zip(range(SURVEYS), cycle(registered()), strict=False):
        yield f"survey {number} on {autopilot}", scenario_of(surveyed(number, autopilot), MISSIONS)


def surveyed(number: int, autopilot: Autopilot) -> dict[str, Any]:
    """Return a survey of an area: plain, with a hole, concave, round a tower, or a corridor."""
    rng = np.random.default_rng(number)
    kind = ("field", "hole", "concave", "tower", "corridor")[number % 5]
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
    made: dict[str, Any] = {
        "name": f"survey{number:02d}",
        "home": HOME,
        "survey": survey,
        "vehicle": {"autopilot": str(autopilot), "cruise_speed": round(float(rng.uniform(4.0, 8.0)), 1)},
    }
    if kind == "tower":
        made["obstacles"] = [mast(0, middle[0], middle[1], 4.0, 70.0) | {"name": "tower"}]
    if number % 4 == 1 and autopilot is Autopilot.ARDUPILOT:
        speed, whence = rng.uniform(2.5, 4.5), rng.uniform(0.0, 360.0)
        made["wind"] = {"speed": round(float(speed), 1), "from_deg": round(float(whence))}
    return made


def outputs(scenario: Scenario) -> Outputs:
    digests: Outputs = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            if "survey" not in scenario.added:
                flight = plan_flight(scenario, seed=SEED)
                files, forecasts = flight.write(folder), [flight.forecast]
            else:
                survey = plan_survey(scenario=scenario, seed=SEED)
                files, forecasts = survey.write(folder), list(survey.flights)
            for path in files:
                text = path.read_bytes()
                digests[path.name] = _both(json.loads(text)) if path.suffix == ".json" else (_digest(text), "")
    except MissionError as error:
        return digests | {"error": _refusal(error)}
    for n, forecast in enumerate(forecasts):
        digests |= _of_mission(forecast, f"flight {n}")
    return digests


def _of_mission(forecast: Forecast, name: str) -> Outputs:
    digests: Outputs = {}
    try:
        digests[f"{name}: estimate"] = _both(estimate_as_json(forecast.estimate))
        findings = check_mission(forecast.mission, forecast.scenario)
        digests[f"{name}: checks"] = _both(findings_as_json(findings))
    except MissionError as error:
        digests[f"{name}: error"] = _refusal(error)
    return digests


def _refusal(error: MissionError) -> tuple[str, str]:
    return _digest(f"{type(error).__name__} {error.exit_code}".encode()), _digest(f"{error}\n{error.hint}".encode())


def _both(tree: Any) -> tuple[str, str]:
    prose: list[str] = []

    def data_of(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: data_of(child) for key, child in value.items() if key != "version"}
        if isinstance(value, list | tuple):
            return [data_of(child) for child in value]
        if isinstance(value, str) and " " in value:
            prose.append(value)
            return ""
        return value

    return _digest(json.dumps(data_of(tree), sort_keys=True).encode()), _digest("\n".join(prose).encode())


def _digest(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:16]


def differences(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    lines = []
    for case, name in sorted({(one, name) for side in (old, new) for one in side for name in side[one]}):
        before, after = (tuple(side.get(case, {}).get(name, ())) for side in (old, new))
        if before != after:
            how = "words only" if before[:1] == after[:1] else "data"
            how = how if before and after else "is new" if after else "gone"
            lines.append(f"{case}: {name}: {how}")
    return lines


def main() -> None:
    parser = command_line(__doc__)
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--write", type=Path, metavar="FILE", help="write the manifest")
    where.add_argument("--against", type=Path, metavar="FILE", help="compare with a manifest")
    options = parser.parse_args()
    old = json.loads(options.against.read_text(encoding="utf-8")) if options.against else {}
    begun, files = time.monotonic(), [*MISSIONS.glob("*.plan"), *MISSIONS.glob("*.waypoints")]
    manifest: dict[str, Any] = {path.name: _of_mission(Forecast(read_mission(path)), "file") for path in files}
    for n, (name, scenario) in enumerate(cases()):
        manifest[name] = outputs(scenario)
        print(f"\r{n + 1} scenarios, {time.monotonic() - begun:.0f} s, {name:40.40}", end="", file=sys.stderr)
    print(file=sys.stderr)
    if options.write:
        sys.exit(options.write.write_text(json.dumps(manifest, indent=1, sort_keys=True), encoding="utf-8") and 0)
    lines = differences(old, json.loads(json.dumps(manifest)))
    print(*lines, f"{sum(map(len, manifest.values()))} outputs compared, {len(lines)} differ", sep="\n")
    sys.exit(any(not line.endswith("words only") for line in lines))


if __name__ == "__main__":
    main()
