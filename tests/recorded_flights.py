"""The recorded flights as truth.

A flight is judged from the first item that its autopilot reports done to its last waypoint; RTL and LAND apart. Where
PX4 is noisy, the mean of several flights is its truth. `LANDINGS`, from 8 to 60 m high, judge take-off and landing.
`IN_WIND` are in wind, steady and gusty. Nothing was fitted to either. PX4's simulator has no wind: its drag was made to
act against moving air, with gusts whose standard deviation north and east is the turbulence.
"""

import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import WAYPOINTS, Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission_file
from ipoa_mission.wind import CALM, Wind

DATA = Path(__file__).resolve().parent / "data"
FLIGHTS, LANDINGS, IN_WIND = DATA / "flights", DATA / "landings", DATA / "flights_wind"
#: ArduPilot's simulated wind grows with the square root of the height up to 5 m.
SIMULATED_PROFILE = 0.5, 5.0
FLOWN_ON = {Autopilot.ARDUPILOT: Version(4, 7, 0, "dev"), Autopilot.PX4: Version(1, 17)}


@dataclass(frozen=True)
class Recorded:
    """One mission; `runs`: when each item was done [s], for each time it was flown."""

    folder: Path
    mission: Mission
    parameters: Parameters
    runs: tuple[dict[int, float], ...]
    end_s: float
    wind: Wind = CALM
    turbulence: float = 0.0  # of the simulated wind: its standard deviation [m/s]

    @property
    def name(self) -> str:
        """The mission and its autopilot: `survey-px4`."""
        return self.folder.name

    @property
    def first(self) -> int:
        return min(set.intersection(*(set(run) for run in self.runs)))

    @property
    def last(self) -> int:
        return max(n for n, item in enumerate(self.mission.items, 1) if item.command in WAYPOINTS)

    @property
    def spans(self) -> NDArray[np.float64]:
        """Seconds from the first item done to the last waypoint, for each run."""
        return np.array([run[self.last] - run[self.first] for run in self.runs])

    @property
    def trace(self) -> NDArray[np.float64]:
        """About once a second: time, latitude, longitude, height over home, velocity north, east, down."""
        return np.loadtxt(self.folder / "trace.csv", delimiter=",", skiprows=1)


def read_flight(folder: Path) -> Recorded:
    flight = json.loads((folder / "flight.json").read_text())
    autopilot = autopilot_named(flight["autopilot"])
    mission = read_mission_file(folder / "mission.waypoints", autopilot).mission
    mission = replace(mission, firmware_version=FLOWN_ON[autopilot])
    last = max(n for n, item in enumerate(mission.items, 1) if item.command in WAYPOINTS)
    runs = [_run(flight["item_done_s"], flight.get("complete_s"), mission, last)]
    for items, complete in zip(
        flight.get("repeats_item_done_s", ()), flight.get("repeats_complete_s", ()), strict=True
    ):
        runs.append(_run(items, complete, mission, last))
    air = flight.get("wind", {"speed_m_s": 0.0, "from_deg": 0.0, "turbulence": 0.0})
    grows = air["speed_m_s"] and mission.autopilot is Autopilot.ARDUPILOT
    wind = Wind(air["speed_m_s"], air["from_deg"], *(SIMULATED_PROFILE if grows else ()))
    return Recorded(folder, mission, flight["params"], tuple(runs), flight["end_s"], wind, air["turbulence"])


@cache
def read_flights(autopilot: Autopilot, folder: Path = FLIGHTS) -> tuple[Recorded, ...]:
    return tuple(read_flight(path) for path in sorted(folder.glob(f"*-{autopilot}")))


def _run(items: dict[str, Any], complete: float | None, mission: Mission, last: int) -> dict[int, float]:
    """PX4 reports the last waypoint as the mission's completion where RTL follows."""
    done = {int(seq): float(at) for seq, at in items.items()}
    if complete is not None and mission.items[-1].command == Command.NAV_RETURN_TO_LAUNCH:
        done[last] = complete
        done.pop(len(mission.items), None)
    return done
