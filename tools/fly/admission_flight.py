"""Plan and fly one flight of an admission on a simulator, stop a fly-away, and compare it with its forecast.

The folder of a flight is SCENE-AUTOPILOT__N, with `mission.plan`, `track.csv` and `outcome.json`.
"""

import hashlib
import json
import math
import shutil
import time
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission import plan_flight
from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.version import Version
from ipoa_mission.flight.procedure import ProcedureOptions, begin_mission
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Points
from ipoa_mission.link.messages import Message, Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import landing_on
from ipoa_mission.mission.mission_io import read_mission, write_mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import CALM
from tools.fly.admission_scenes import as_flown_by
from tools.fly.simulators import connected, load, newest_log, set_up, simulation, true_track

AWAY = 50.0  # distance from the whole predicted path of a fly-away [m]
LATE, LATE_S = 1.5, 60.0  # limits of the flight time: factor on the end of the interval, and seconds more
LEVEL = 0.99
MOST_LATE_S = 20.0  # of telemetry on a loaded machine
COMPLETED, FLEW_AWAY, NOT_COMPLETED = "completed", "fly-away", "not completed"
REFUSED, NOT_FLOWN = "refused", "not flown"


@dataclass(frozen=True)
class Simulator:
    """Hold commands, which may contain {instance}, {folder}, {latitude}, {longitude} and {altitude} of home.

    Without `start` a running simulator is used.
    """

    link: str
    instance: int
    work: Path
    start: str | None = None
    logs: str | None = None

    def words(self, command: str, home: Geodetic) -> str:
        place = {"latitude": home.latitude_deg, "longitude": home.longitude_deg, "altitude": home.altitude}
        return command.format(instance=self.instance, folder=self.folder, **place)

    @property
    def folder(self) -> Path:
        """Return the folder of its files, emptied before every flight."""
        return self.work / f"instance{self.instance}"


@dataclass(frozen=True)
class Row:
    """Record a flight: times from arming [s], distances from take-off to the last waypoint [m].

    `surplus`: clearance flown above the requirement; `over_guarantee`: above the clearance that 99 % of flights keep.
    `required`, `kept_99`, `least` and `to` belong to the limit with the least `over_guarantee`.
    `astray`: greatest distance from the predicted path.
    `truth`: source of the track, the simulator's log or the vehicle's own position.
    """

    scene: str
    autopilot: str
    flight: int
    version: str
    outcome: str
    why: str = ""
    plan: str = ""
    required: float = math.nan
    kept_99: float = math.nan
    least: float = math.nan
    to: str = ""
    surplus: float = math.nan
    over_guarantee: float = math.nan
    estimated_route_s: float = math.nan
    flown_route_s: float = math.nan
    estimated_s: float = math.nan
    low_s: float = math.nan
    high_s: float = math.nan
    flown_s: float = math.nan
    items: int = 0
    inside: int = 0
    astray: float = math.nan
    truth: str = ""

    @property
    def route_off(self) -> float:
        return self.estimated_route_s / self.flown_route_s - 1.0


class Broken(Exception):
    """Stop a flight that flies away or does not end."""

    def __init__(self, outcome: str, why: str) -> None:
        super().__init__(why)
        self.outcome = outcome


class Watch:
    def __init__(self, vehicle: Vehicle, forecast: Forecast) -> None:
        estimate = forecast.estimate
        self._vehicle, self._frame = vehicle, forecast.frame
        points = estimate.track.points
        self._way = np.vstack([points, points[-1] * (1.0, 1.0, 0.0)])  # the simulator's ground is level
        level = Forecast(landing_on(forecast.mission_as_read, 0.0)).estimate  # also at the landing
        self._ends_s = LATE * level.high_s + LATE_S
        self._armed_s = math.nan
        self.astray = 0.0

    def hear(self, message: Message) -> None:
        if not isinstance(message, Position) or not self._vehicle.state.armed:
            return
        if math.isnan(self._armed_s):
            self._armed_s = message.time_s
        place = self._frame.local(Geodetic(message.latitude_deg, message.longitude_deg, message.altitude))
        away, since = beside(self._way, place), message.time_s - self._armed_s
        self.astray = max(self.astray, away)
        current = self._vehicle.state.current
        item = "" if current is None else f" at item {current.seq + 1 - self._vehicle.autopilot.seq_offset}"
        if away > AWAY:
            raise Broken(FLEW_AWAY, f"{away:.0f} m from its path after {since:.0f} s{item}, {place[2]:.0f} m up")
        if since > self._ends_s:
            raise Broken(NOT_COMPLETED, f"not down after {since:.0f} s{item}")


def beside(path: Points, place: Points) -> float:
    """Return the distance of a place (3,) from a polyline (n, 3) [m]."""
    start, along = path[:-1], np.diff(path, axis=0)
    squared = np.maximum(np.sum(along**2, axis=1), 1e-9)
    share = np.clip(np.sum((place - start) * along, axis=1) / squared, 0.0, 1.0)
    return float(np.linalg.norm(place - start - share[:, None] * along, axis=1).min())


def planned(path: Path, autopilot: Autopilot, version: Version | None) -> tuple[Scenario, Mission]:
    """Return a scenario and its mission for flying; PX4's own simulator has no wind.

    Raises:
        MissionError: it is refused.
    """
    scenario = as_flown_by(path, autopilot)
    if autopilot is Autopilot.PX4:
        scenario = scenario.in_wind(CALM)
    named = str(version) if version is not None and version.series in autopilot.tables.series else None
    vehicle = scenario.vehicle.model_copy(update={"firmware_version": named, "unmeasured_version": True})
    scenario = scenario.model_copy(update={"vehicle": vehicle})
    return scenario, plan_flight(scenario).forecast.mission_as_read


def fly(scenario: Scenario, mission: Mission, simulator: Simulator, folder: Path) -> None:
    """Fly a mission, and store its results in the folder.

    Raises:
        MissionError, OSError: the flight did not begin.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_mission(mission, folder / "mission.plan")
    shutil.rmtree(simulator.folder, ignore_errors=True)
    home, began = mission.home, time.time()
    start = simulator.start and simulator.words(simulator.start, home)
    with simulation(start, simulator.folder) if start else nullcontext(), connected(simulator.link) as vehicle:
        forecast = Forecast(mission, scenario).on(vehicle.firmware_version())
        watch = Watch(vehicle, forecast)
        set_up(vehicle, forecast.wind)
        load(vehicle, forecast)
        vehicle.overhearing = watch.hear
        outcome, why = COMPLETED, ""
        try:
            record = begin_mission(vehicle, forecast, ProcedureOptions())
            if not record.completed:
                outcome, why = NOT_COMPLETED, record.why_not
        except Broken as broken:
            outcome, why = broken.outcome, str(broken)
            record = vehicle.record()
            if start is None:
                vehicle.overhearing = lambda message: None
                vehicle.return_to_launch()
                vehicle.watch()
        version = vehicle.firmware_version()
        time.sleep(0.5)  # wait for the log's last lines
    logs = Path(simulator.words(simulator.logs or "{folder}", home))
    track, truth = _track(logs, began, record)
    _write(folder, record, track, outcome=outcome, why=why, version=str(version), truth=truth, astray=watch.astray)


def _track(logs: Path, began: float, record: FlightRecord) -> tuple[Points, str]:
    """Return seconds from arming, latitude, longitude, height above home (n, 4), and their source."""
    try:
        log = newest_log(logs)
        if log.stat().st_mtime >= began:
            return true_track(log), "log"
    except (ValueError, IndexError, KeyError, OSError):
        pass
    path = [(at.time_s, at.latitude_deg, at.longitude_deg, at.height) for at in record.path]
    return np.array(path).reshape(-1, 4), "own position"


def _write(folder: Path, record: FlightRecord, track: Points, **outcome: Any) -> None:
    head = "s,latitude,longitude,height"
    digits = ["%.2f", "%.8f", "%.8f", "%.3f"]
    np.savetxt(folder / "track.csv", track, fmt=digits, delimiter=",", header=head, comments="")
    items = [{"seq": index + 1, "done_s": round(at, 3)} for index, at in sorted(record.item_reached_s.items())]
    times = {"flown_s": round(record.total_s, 3), "items": items}
    (folder / "outcome.json").write_text(json.dumps({**outcome, **times}, indent=1), encoding="utf-8")


def judged(folder: Path, scenario: Scenario) -> Row:
    stem, number = folder.name.split("__")
    name, autopilot = stem.rsplit("-", 1)
    flight: dict[str, Any] = json.loads((folder / "outcome.json").read_text(encoding="utf-8"))
    plan = hashlib.sha256((folder / "mission.plan").read_bytes()).hexdigest()[:12]
    row = Row(
        name, autopilot, int(number), flight["version"], flight["outcome"], flight["why"], plan, truth=flight["truth"]
    )
    row = replace(row, astray=round(flight["astray"], 2))
    version = None if flight["version"] == "None" else Version.parsed(flight["version"])
    mission = replace(read_mission(folder / "mission.plan", autopilot_named(autopilot)), firmware_version=version)
    done = {item["seq"]: float(item["done_s"]) for item in flight["items"]}
    if done:
        safety = scenario.safety.model_copy(update={"confidence": LEVEL})
        forecast = Forecast(mission, scenario.model_copy(update={"safety": safety}))
        flown = _on_the_way(folder, forecast, sorted(done.values()), flight["outcome"] == COMPLETED)
        row = _with_distances(row, flown, forecast)
    if flight["outcome"] != COMPLETED:
        return row
    expected = Forecast(landing_on(mission.assuming(scenario.vehicle.autopilot_parameters()), 0.0)).estimate
    items = [item for item in expected.items if item.seq in done]
    end = expected.items[-1]
    last = [item for item in items if item.seq < end.seq][-1]
    inside = sum(item.low_s <= done[item.seq] <= item.high_s for item in items)
    return replace(
        row, estimated_route_s=round(last.done_s, 2), flown_route_s=round(done[last.seq], 2),
        estimated_s=round(end.done_s, 2), low_s=round(end.low_s, 2), high_s=round(end.high_s, 2),
        flown_s=round(flight["flown_s"], 2), items=len(items), inside=inside,
    )  # fmt: skip


def _on_the_way(folder: Path, forecast: Forecast, done: list[float], is_completed: bool) -> Points:
    """Return the track from the take-off to the place nearest to the last waypoint, which may be reported late."""
    rows = np.loadtxt(folder / "track.csv", delimiter=",", skiprows=1, ndmin=2)
    end = done[-2] if is_completed else np.inf
    rows = rows[(rows[:, 0] >= done[0]) & (rows[:, 0] <= end)]
    home = forecast.mission.home
    flown = LocalFrame(home).to_local(rows[:, 1], rows[:, 2], rows[:, 3] + home.altitude)
    if not is_completed:
        return flown
    flight = forecast.guarantee.flight
    last = flight.prediction.track.at(np.array([flight.cruise_span[1]]))
    late = np.flatnonzero(rows[:, 0] > end - MOST_LATE_S)
    return flown[: late[np.argmin(np.linalg.norm(flown[late] - last, axis=1))] + 1] if len(late) else flown


def _with_distances(row: Row, flown: Points, forecast: Forecast) -> Row:
    air = forecast.world.airspace
    clearances = {"obstacles": air.obstacle_clearance(flown), "ground": air.terrain_clearance(flown)}
    limits = [kept for kept in forecast.guarantee.limits if kept.in_cruise and kept.limit in clearances]
    if not limits or len(flown) < 2:
        return row
    surplus = min(clearances[kept.limit].distance - kept.required for kept in limits)
    least = min(limits, key=lambda kept: clearances[kept.limit].distance - kept.guaranteed)
    nearest = clearances[least.limit]
    return replace(
        row, required=round(least.required, 3), kept_99=round(least.guaranteed, 3), to=nearest.what,
        least=round(float(nearest.distance), 3), surplus=round(float(surplus), 3),
        over_guarantee=round(float(nearest.distance - least.guaranteed), 3),
    )  # fmt: skip
