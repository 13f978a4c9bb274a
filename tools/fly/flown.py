"""Read recorded flights with their missions: true positions, and times of items.

A folder is named SCENARIO-AUTOPILOT or SCENARIO_CONDITION-AUTOPILOT (a part before `_` that begins with `r`, and
parts after `__`, are ignored). It has the mission and one of these:

* the output of `fly --json` (`fly.json`) with the simulated vehicle's log (`log.BIN`, `log.ulg`);
* `flight.json` (autopilot, `item_done_s`) with `truth.csv`, or `trace.csv` without true positions;
* `track.csv` (true positions, heights above ground) with `times.json` and SCENARIO-AUTOPILOT.plan and .toml.

A repeated flight may use the mission of the first one. `wind.json` has the fields of a `Wind`.
"""

import json
import re
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.vehicles.arducopter.dataflash import read_records
from ipoa_mission.wind import CALM, Wind
from ipoa_mission.world.frame import LocalFrame

MISSIONS = ("mission.plan", "mission.waypoints")
PLACE = ("TimeUS", "Lat", "Lng", "Alt")  # of ArduPilot's record SIM
ARMED_STATE = 2  # PX4's vehicle_status.ARMING_STATE_ARMED
TRUE_PLACE = "vehicle_global_position_groundtruth"


@dataclass(frozen=True)
class Flown:
    """Hold times and places (n, 4) from arming, and the end of the take-off and of the last waypoint [s].

    `estimated_s` and `flown_s` are from arming to disarming; NaN if not recorded.
    """

    name: str
    mission: Mission
    track: Points
    begin: float
    end: float
    estimated_s: float = np.nan
    flown_s: float = np.nan
    wind: Wind = CALM
    scenario: Path | None = None

    @property
    def on_the_way(self) -> Points:
        """Return places (n, 3) [m] from the end of the take-off to the last waypoint."""
        times = self.track[:, 0]
        return np.asarray(self.track[(times >= self.begin) & (times <= self.end), 1:])


def is_flown(folder: Path) -> bool:
    return any((folder / name).exists() for name in ("flight.json", "fly.json", "times.json"))


def read_flown(folder: Path, missions: dict[str, Path]) -> Flown:
    """Read a folder; `missions` are those read before, by scenario and autopilot."""
    stem = re.sub(r"^(r\d*|rep\d+)_", "", folder.name).split("__")[0]
    name, autopilot = stem.rsplit("-", 1)
    own = [folder / file for file in (*MISSIONS, f"{stem}.plan") if (folder / file).exists()]
    missions.setdefault(stem, own[0] if own else folder.parent / stem / MISSIONS[-1])
    mission = read_mission(missions[stem], autopilot_named(autopilot))
    if (folder / "outcome.json").exists():
        said = json.loads((folder / "outcome.json").read_text())["version"]
        mission = replace(mission, firmware_version=Version.parsed(said))
    if (folder / "fly.json").exists():
        told: dict[str, Any] = json.loads((folder / "fly.json").read_text())
        done = sorted(float(item["done_s"]) for item in told["items"])
        estimated, flown = float(told["estimate"]["total_s"]), float(told["flown_s"])
        track = _from_log(folder, mission)
    elif (folder / "times.json").exists():
        told = json.loads((folder / "times.json").read_text())
        done = sorted(float(item["done_s"]) for item in told["items"])
        estimated, flown = np.nan, float(told["flown_s"])
        rows = np.loadtxt(folder / "track.csv", delimiter=",", skiprows=1)
        track = in_frame(rows + np.array([0.0, 0.0, 0.0, mission.home.altitude]), mission)
    else:
        told = json.loads((folder / "flight.json").read_text())
        done = sorted(float(at) for at in told["item_done_s"].values())
        estimated, flown = np.nan, np.nan
        track = _from_csv(folder, mission)
    air = folder / "wind.json"
    wind = Wind(**json.loads(air.read_text())) if air.exists() else CALM
    world = folder / f"{stem}.toml"
    begun = track[track[:, 0] >= 0]
    scenario = world if world.exists() else None
    return Flown(name, mission, begun, done[0], done[-2], estimated, flown, wind, scenario)


def _from_csv(folder: Path, mission: Mission) -> Points:
    true = (folder / "truth.csv").exists()
    rows = np.loadtxt(folder / ("truth.csv" if true else "trace.csv"), delimiter=",", skiprows=1)
    rows[:, 3] += 0.0 if true else mission.home.altitude
    return in_frame(rows[:, :4], mission)


def _from_log(folder: Path, mission: Mission) -> Points:
    """Return the simulator's own position, with heights from the vehicle's place at the log's begin."""
    rows = _ulog(folder / "log.ulg") if (folder / "log.ulg").exists() else _dataflash(folder / "log.BIN")
    rows[:, 3] += mission.home.altitude - rows[0, 3]
    return in_frame(rows, mission)


def in_frame(rows: Points, mission: Mission) -> Points:
    """Return seconds, and east, north, up of home, from rows of seconds, latitude, longitude, altitude AMSL."""
    places = LocalFrame(mission.home).to_local(rows[:, 1], rows[:, 2], rows[:, 3])
    return np.column_stack([rows[:, 0], places])


def _dataflash(path: Path) -> Points:
    """Read an ArduPilot simulation: seconds since arming, latitude, longitude, altitude, (n, 4)."""
    rows = [tuple(record[name] for name in PLACE) for _, record in read_records(path, frozenset({"SIM"}))]
    table = np.array(rows, dtype=float)
    table[:, 0] = (table[:, 0] - table[0, 0]) / 1e6
    return table


def _ulog(path: Path) -> Points:
    """Read a PX4 simulation, in the form of `_dataflash`."""
    log: Any = import_module("pyulog").ULog(str(path), [TRUE_PLACE, "vehicle_status"])
    topics = {topic.name: topic.data for topic in log.data_list}
    status, place = topics["vehicle_status"], topics[TRUE_PLACE]
    armed = status["timestamp"][np.argmax(status["arming_state"] == ARMED_STATE)]
    times = (place["timestamp"].astype(float) - float(armed)) / 1e6
    return np.column_stack([times, place["lat"], place["lon"], place["alt"]])
