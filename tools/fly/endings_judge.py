"""Compare aborted missions (`tools.fly.endings`) with their forecasts.

    python -m tools.fly.endings_judge MISSIONS OUT [--csv FILE]

Flights are judged by the simulator's true position and shapely's geometry, from the order to the motor stop. The
simulators' ground is level at home's height, so times are forecast over such ground. Points below a scenario's higher
ground are ignored. Writes one line an order, and a summary to standard output.
"""

import csv
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.returning import Contingency, FlightStage
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingencies import Contingencies, ContingencyRow
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade
from ipoa_mission.forecast.itinerary.itinerary import itinerary
from ipoa_mission.forecast.timing.flight_model import Abort, FlightModel
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.scenario import Scenario, read_scenario
from ipoa_mission.world.ground import LEVEL
from ipoa_mission.world.obstacles.cylinder import Cylinder
from ipoa_mission.world.obstacles.prism import Prism
from ipoa_mission.world.obstacles.sphere import Sphere
from tools import command_line
from tools.fly.causes import TRIGGERS
from tools.fly.ended_flight import EndedFlight

Between = tuple[float, float, float]  # at the earliest, in the mean, at the latest [s]
NOT_TOLD: Between = (math.nan,) * 3
STEP = 0.15  # between checked points of a flight [m]
AROUND_S = 12.0  # search window of the forecast about the time of the clock
LONG_ENOUGH = 10.0  # shorter endings do not count in shares [s]
BOTH_AT_ONCE = "where the voltage falls through both at once"
#: Actions that are no endings, by the text of their failsafe.
HAS_NO_ENDING = {"ALT_HOLD": "alt_hold", "LOITER": "loiter", "flies aside": "aside"}
FAR_OUTSIDE, FAR_M = "100 m outside it lands", 100.0
NOTICED_S = 15.0  # longest reaction time of a failsafe [s]
SILENCE_S = 75.0  # longest detection time of a silent ground station [s]
STAGES: Mapping[int, FlightStage] = {
    Command.NAV_TAKEOFF: FlightStage.TAKEOFF,
    Command.NAV_LAND: FlightStage.LANDING,
    Command.NAV_RETURN_TO_LAUNCH: FlightStage.RETURN,
}


@dataclass(frozen=True)
class Judged:
    """Compare an order's forecast with its flight. Meters, seconds; NaN for missing values.

    `stage` of its mission; `planned`: "returns" if all its returns are planned, else empty.
    `grade`: confidence that the ending keeps the requirement. `touched_s`: time to the final touchdown; `flown_s`: to
    disarming; `touch_low_s` ...: forecasts of it.
    """

    number: int
    autopilot: str
    version: str
    mission: str
    ending: str
    trigger: str
    second: float
    did: str
    flown_least: float
    flown_to: str
    flown_s: float
    level: bool
    clear: bool = True
    least: float = math.nan
    to: str = ""
    required: float = math.nan
    goal: str = ""
    low_s: float = math.nan
    expected_s: float = math.nan
    high_s: float = math.nan
    goal_off: float = math.nan
    track_off: float = math.nan
    stage: str = ""
    planned: str = ""
    grade: str = ""
    touched_s: float = math.nan
    touch_low_s: float = math.nan
    touch_expected_s: float = math.nan
    touch_high_s: float = math.nan


def distances(points: Points, scenario: Scenario) -> tuple[float, str]:
    """Return the least distance of points (n, 3) to the scenario's obstacles, negative inside, and the obstacle.

    Points below the scenario's ground do not count: only the simulator's lower ground allows them.
    """
    points = points[points[:, 2] >= np.minimum(scenario.airspace.ground(points), points[:1, 2])]
    found = [(float(_to(one, points).min()), str(one.name)) for one in scenario.airspace.obstacles]
    return min(found, default=(math.inf, ""))


def _to(one: Any, points: Points) -> Any:
    if isinstance(one, Sphere):
        return np.linalg.norm(points - np.array(one.center), axis=1) - one.radius
    if isinstance(one, Cylinder):
        level = np.hypot(points[:, 0] - one.east, points[:, 1] - one.north) - one.radius
    elif isinstance(one, Prism):
        shape = shapely.Polygon(one.outer, one.holes)
        at = shapely.points(points[:, :2])
        outside = shapely.distance(shape, at)
        level = np.where(outside > 0.0, outside, -shapely.distance(shape.boundary, at))
    else:
        raise TypeError(type(one).__name__)
    upright = np.maximum(one.base - points[:, 2], points[:, 2] - one.top)
    return np.where((level > 0.0) & (upright > 0.0), np.hypot(level, upright), np.maximum(level, upright))


def dense(track: Points) -> Points:
    """Return points (n, 3) along a track (m, 4), at most `STEP` apart."""
    pieces = [track[:1, 1:]]
    for one, other in zip(track[:-1, 1:], track[1:, 1:], strict=True):
        count = max(1, math.ceil(float(np.linalg.norm(other - one)) / STEP))
        pieces.append(one + (other - one) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.concatenate(pieces)


class Foretold:
    """Hold the forecast of one mission."""

    def __init__(self, path: Path, others: Mapping[str, float]) -> None:
        """Read a mission; `others`: parameters changed by an order."""
        self.name, self.scenario = path.stem, read_scenario(path.with_suffix(".toml"))
        autopilot = self.scenario.vehicle.autopilot
        mission = read_mission(path, autopilot).with_parameters(others)
        self.endings = Contingencies(Forecast(mission, self.scenario))
        self.level = bool(self.scenario.ground.is_level)
        self.over_level_ground = itinerary(self.endings.mission, LEVEL)

    @property
    def planned(self) -> str:
        """Return how its returns were planned; empty if they were not."""
        return "returns" if self.scenario.safety.returns == "planned" else ""

    def stage(self, time: float) -> FlightStage:
        """Return the forecast stage of the mission at a time."""
        mission, stops = self.endings.mission, self.endings.stops()
        command = mission.items[int(stops.seqs_at(np.array([time]))[0]) - 1].command
        return STAGES.get(command, FlightStage.ROUTE)

    def row(self, ending: Contingency, time: float) -> ContingencyRow:
        return self.endings.at(ending, float(np.clip(time, *self.endings.in_air)), timed=False)

    def timed(self, ending: Contingency, time: float) -> tuple[Between, Between]:
        """Return the forecast durations of the ending over level ground, and until touchdown."""
        forecast = self.endings.forecast
        model = forecast.mission.autopilot.part(FlightModel)
        order = Abort(float(np.clip(time, *self.endings.in_air)), ending)
        if ending not in (Contingency.RTL, Contingency.LAND):
            return NOT_TOLD, NOT_TOLD
        try:
            found = model.broken_off(self.over_level_ground, forecast.mission, forecast.wind, None, order)
        except MissionError:
            return NOT_TOLD, NOT_TOLD
        low, mean, high = (float(end[-1]) - order.time for end in (found.low, found.done, found.high))
        first, touched, last = (time - order.time for time in found.touched or NOT_TOLD)
        return (low, mean, high), (first, touched, last)

    def time_at(self, place: Points, time: float) -> float:
        times = self.endings.stops().times
        near = np.abs(times - time) <= AROUND_S
        if not near.any():
            return time
        return float(times[near][np.linalg.norm(self.endings.stops().places[near] - place, axis=1).argmin()])


def asked(order: Mapping[str, Any], away: float, mission: Mission, stage: FlightStage) -> tuple[str, str]:
    """Return the ending expected after an order `away` from home [m], and its cause."""
    if order["trigger"] is None:
        return order["ending"], ""
    before: Mapping[str, float] = order["before"]
    said = mission.autopilot.failsafes({**mission.parameters, **before}, mission.firmware_version)
    route = next(one for one in said if one.cause == order["cause"]).at(stage)
    if BOTH_AT_ONCE in route.words:  # it was made to fall
        said = mission.autopilot.failsafes({**mission.parameters, **before, "BATT_LOW_VOLT": 0.0})
        route = next(one for one in said if one.cause == order["cause"]).at(stage)
    ending = str(route.contingency)
    if ending == Contingency.LAND_START:  # none of these missions has one
        ending = str(route.otherwise[0])
    if ending == Contingency.UNKNOWN:
        ending = next((does for words, does in HAS_NO_ENDING.items() if route.words.startswith(words)), ending)
    radius = TRIGGERS[mission.autopilot][order["trigger"]].then.get("FENCE_RADIUS", math.inf)
    if FAR_OUTSIDE in route.words and away - radius > FAR_M:
        ending = str(Contingency.LAND)
    return ending, f"{order['cause']} ({', '.join(f'{name} {value:g}' for name, value in before.items())})"


def judge(order: Mapping[str, Any], flight: EndedFlight, foretold: Foretold) -> Judged:
    mission = foretold.endings.mission
    left = flight.left_mission()
    second = left if not math.isnan(left) else float(order["ordered_s"])
    ended = flight.track[-1, 0] if math.isnan(flight.ended_s) else flight.ended_s
    stage = foretold.stage(second)
    ending, trigger = asked(order, float(np.hypot(*flight.place(second)[:2])), mission, stage)
    after = flight.track[(flight.track[:, 0] >= second) & (flight.track[:, 0] <= ended)]
    least, to = distances(dense(after), foretold.scenario)
    judged = Judged(
        number=order["number"],
        autopilot=str(mission.autopilot),
        version=order["version"],
        mission=order["mission"],
        ending=ending,
        trigger=trigger,
        second=second,
        did=" ".join(flight.did()),
        flown_least=least,
        flown_to=to,
        flown_s=flight.ended_s - second,
        level=foretold.level,
        stage=str(stage),
        planned=foretold.planned,
    )
    if ending not in (Contingency.RTL, Contingency.LAND, Contingency.SMART_RTL, Contingency.HOLD):
        return judged
    kind, place, stops = (
        Contingency(ending),
        flight.place(second),
        foretold.endings.stops(Contingency(ending)),
    )
    row, ((low, expected, high), touches) = foretold.row(kind, second), foretold.timed(kind, second)
    begin, end = foretold.endings.in_air
    stand = stops.at(np.clip([foretold.time_at(place, second)], begin, end))[1][0]
    lands = stand[:2] if row.lands is None else np.array(row.lands)
    return replace(
        judged,
        clear=row.clear,
        grade=row.grade.name.lower(),
        least=row.least_m,
        to=row.to,
        required=row.required_m,
        goal=row.goal,
        low_s=low,
        high_s=high,
        expected_s=expected,
        touched_s=flight.touched() - second,
        touch_low_s=touches[0],
        touch_expected_s=touches[1],
        touch_high_s=touches[2],
        goal_off=float(np.linalg.norm(flight.place(ended)[:2] - lands)),
        track_off=float(np.linalg.norm(stops.at(np.clip([second], begin, end))[0][0] - place)),
    )


def changed(order: Mapping[str, Any], autopilot: Autopilot) -> dict[str, float]:
    """Return an order's changes of the vehicle's own fence, which lowers ArduPilot's return."""
    if order["trigger"] is None:
        return {}
    told = {**order["before"], **TRIGGERS[autopilot][order["trigger"]].then}
    return {name: float(value) for name, value in told.items() if name.startswith("FENCE")}


def spoiled(order: Mapping[str, Any], flight: EndedFlight) -> str:
    """Return why a flight cannot be judged; empty if it can."""
    ordered, left = float(order["ordered_s"]), flight.left_mission()
    if not math.isfinite(ordered) or left < ordered - 0.5:
        return "left its mission before the order: the simulation was stalled, and its sensors timed out"
    if order["trigger"] is None and math.isnan(left):
        return "the order was not heard before it stood"
    ends = flight.ended_s if math.isfinite(flight.ended_s) else math.inf
    noticed = SILENCE_S if "ground station lost" in str(order.get("cause", "")) else NOTICED_S
    noticed += float(order.get("before", {}).get("COM_RC_LOSS_T", 0.0))
    if math.isnan(left) and ends - ordered < noticed and not flight.stopped:
        return "it stood before the cause could be noticed"
    return ""


def rounded(row: Judged) -> dict[str, Any]:
    told = asdict(row)
    return {name: round(value, 2) if isinstance(value, float) else value for name, value in told.items()}


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("missions", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--csv", type=Path)
    given = parser.parse_args()
    foretold: dict[tuple[str, str], Foretold] = {}
    judged = []
    for told in sorted(given.out.glob("*/order.json")):
        order: dict[str, Any] = json.loads(told.read_text(encoding="utf-8"))
        flight, name = EndedFlight.read(told.parent), order["mission"]
        others = changed(order, autopilot_named(name.rsplit("-", 1)[1]))
        if (key := (name, json.dumps(others))) not in foretold:
            foretold[key] = Foretold(given.missions / f"{name}.plan", others)
        if why := spoiled(order, flight):
            print(f"{told.parent.name}: {why}")
            continue
        judged.append(judge(order, flight, foretold[key]))
        print(told.parent.name, json.dumps(rounded(judged[-1])), flush=True)
    if given.csv and judged:
        with given.csv.open("w", newline="", encoding="utf-8") as out:
            lines = csv.DictWriter(out, [f.name for f in fields(Judged)], lineterminator="\n")
            lines.writeheader()
            lines.writerows(map(rounded, judged))
    for line in summary(judged):
        print(line)


def summary(judged: list[Judged]) -> Iterator[str]:
    """Yield counts, and the relative errors of times."""
    known = [one for one in judged if math.isfinite(one.least) and one.to != "the ground"]
    nearer = [one for one in known if one.flown_least < one.required]
    alarms = [one for one in known if not one.clear]
    missed = [one for one in nearer if one.clear]
    false = [one for one in alarms if one.flown_least >= one.required]
    yield f"{len(judged)} orders, {len(known)} of them with obstacles; nearer than required {len(nearer)}"
    yield f"of these not foretold: {len(missed)}; alarms {len(alarms)}, of these false {len(false)}"
    for grade in Grade:
        own = [one.flown_least < one.required for one in known if one.grade == grade.name.lower()]
        yield f"{grade}: {len(own)}, of these nearer than required {sum(own)}"
    planned = [one for one in known if one.planned == "returns" and one.ending != Contingency.LAND]
    yield f"of planned returns: {len(planned)}, nearer {sum(one.flown_least < one.required for one in planned)}"
    for name in ("rtl", "land"):
        timed = [one for one in judged if one.did == name and not one.trigger and one.ending == name]
        lasted = [(one.flown_s, one.low_s, one.expected_s, one.high_s) for one in timed]
        stood = [(one.touched_s, one.touch_low_s, one.touch_expected_s, one.touch_high_s) for one in timed]
        yield from _times(f"{name}, disarmed", np.array(lasted).reshape(-1, 4))
        yield from _times(f"{name}, on the ground", np.array(stood).reshape(-1, 4))
    fails = [one for one in judged if one.trigger]
    as_said = [one for one in fails if (one.did.split() or ["continue"])[-1] == one.ending]
    yield f"failsafes {len(fails)} of {len({one.trigger for one in fails})} kinds, as said {len(as_said)}"
    yield from (f"otherwise: {rounded(one)}" for one in fails if one not in as_said)
    yield from (f"not foretold: {rounded(one)}" for one in missed)
    yield from (f"false: {rounded(one)}" for one in false)


def _times(name: str, seconds: Points) -> Iterator[str]:
    """Yield errors of forecasts, and shares within their intervals: rows of flown, low, expected, high (n, 4) [s]."""
    flown, low, expected, high = (known := seconds[np.isfinite(seconds).all(axis=1)]).T
    off = (expected / flown - 1.0)[flown > LONG_ENOUGH]
    if len(off):
        quantiles = ", ".join(f"{np.quantile(np.abs(off), share):.1%}" for share in (0.5, 0.9, 0.95, 1.0))
        within, late = int(((low <= flown) & (flown <= high)).sum()), np.median(flown - expected)
        middle = f"{within} within the interval, median {np.median(off):+.1%}, {late:+.2f} s late"
        yield f"{name}: {len(known)}, {middle}, sizes (50, 90, 95, 100 %) {quantiles}"


if __name__ == "__main__":
    main()
