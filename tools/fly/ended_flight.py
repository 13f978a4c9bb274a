"""Read an aborted flight from a simulator's log: true positions, modes, end.

A flight is stored as `flight.json` and `track.csv`, to judge it again without the log.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.vehicles.arducopter.dataflash import read_records
from ipoa_mission.world.frame import Geodetic, LocalFrame
from tools.fly.flown import ARMED_STATE, TRUE_PLACE

#: Action of a mode, by ArduPilot's number and by PX4's nav_state.
COPTER_DOES = {
    **{3: "mission", 6: "rtl", 9: "land", 21: "smart_rtl", 17: "hold", 5: "loiter", 2: "alt_hold", 27: "land_start"},
    19: "aside",  # AVOID_ADSB
}
PX4_DOES = {3: "mission", 4: "hold", 5: "rtl", 18: "land", 12: "land", 13: "terminate", 17: "take-off"}
TRACK_EVERY = 0.1  # [s]
STANDS = 0.03  # tolerance of the final height on the ground [m]
STOPPED_UP = 2.0  # height of a motor stop that is no landing [m]
CRASHED = "Crash: Disarming"


@dataclass(frozen=True)
class EndedFlight:
    """Hold seconds from arming and the true track (n, 4): time, east, north, up of the place of arming [m].

    `modes`: begin of each action, the mission first; `ended_s`: disarming, NaN without one.
    """

    modes: tuple[tuple[float, str], ...]
    track: Points
    ended_s: float
    texts: tuple[tuple[float, str], ...]

    def touched(self) -> float:
        """Return the time of the final touchdown; NaN if it was not disarmed."""
        track = self.track[self.track[:, 0] <= self.ended_s]
        above = np.flatnonzero(track[:, 3] > track[-1, 3] + STANDS) if len(track) else np.array([], int)
        return float(track[above[-1] + 1, 0]) if len(above) else math.nan

    def left_mission(self) -> float:
        """Return when it left its mission; NaN if it did not."""
        seen = False
        for time, does in self.modes:
            if seen and does not in ("mission", "take-off"):
                return time
            seen = seen or does == "mission"
        return math.nan

    def did(self) -> tuple[str, ...]:
        """Return the actions after its mission, each once in order; last a motor stop in the air."""
        left = self.left_mission()
        until = math.inf if math.isnan(self.ended_s) else self.ended_s
        did = [does for time, does in self.modes if left <= time < until - 0.05]
        return tuple(dict.fromkeys([*did, "terminate"] if self.stopped else did))

    @property
    def stopped(self) -> bool:
        """Return whether the motors stopped before the landing."""
        if math.isnan(self.ended_s):
            return False
        return self.place(self.ended_s)[2] > STOPPED_UP or any(words.startswith(CRASHED) for _, words in self.texts)

    def place(self, time: float) -> Points:
        """Return the true position (3,) [m]."""
        return np.array([np.interp(time, self.track[:, 0], self.track[:, axis]) for axis in (1, 2, 3)])

    def write(self, folder: Path) -> None:
        told = {"modes": self.modes, "ended_s": None if np.isnan(self.ended_s) else self.ended_s, "texts": self.texts}
        (folder / "flight.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
        np.savetxt(folder / "track.csv", self.track, fmt="%.2f", delimiter=",", header="s,east,north,up", comments="")

    @classmethod
    def read(cls, folder: Path) -> "EndedFlight":
        told: dict[str, Any] = json.loads((folder / "flight.json").read_text(encoding="utf-8"))
        track = np.loadtxt(folder / "track.csv", delimiter=",", skiprows=1, ndmin=2)
        ended = math.nan if told["ended_s"] is None else told["ended_s"]
        return cls(tuple(map(tuple, told["modes"])), track, ended, tuple(map(tuple, told["texts"])))


def flight_from(log: Path, home: Geodetic) -> EndedFlight:
    """Read the log of one flight; places count from `home`, heights from the place of arming."""
    return _of_px4(log, home) if log.suffix == ".ulg" else _of_copter(log, home)


def _of_copter(log: Path, home: Geodetic) -> EndedFlight:
    kinds = frozenset({"SIM", "MODE", "EV", "ARM", "MSG"})
    place, modes, texts, armed, ended = [], [], [], math.nan, math.nan
    for kind, record in read_records(log, kinds):
        time = record["TimeUS"] / 1e6
        if kind == "SIM":
            place.append((time, record["Lat"], record["Lng"], record["Alt"]))
        elif kind == "MODE":
            modes.append((time, COPTER_DOES.get(record["ModeNum"], f"mode {record['ModeNum']}")))
        elif kind == "MSG":
            texts.append((time, record["Message"]))
        elif kind == "ARM" and record["ArmState"] and np.isnan(armed):
            armed = time
        elif (kind == "ARM" and not record["ArmState"]) or (kind == "EV" and record["Id"] == 11):
            ended = time if np.isnan(ended) else ended
    return _flight(np.array(place), modes, texts, armed, ended, home)


def _of_px4(log: Path, home: Geodetic) -> EndedFlight:
    read: Any = import_module("pyulog").ULog(str(log), [TRUE_PLACE, "vehicle_status"])
    topics = {topic.name: topic.data for topic in read.data_list}
    status, true = topics["vehicle_status"], topics[TRUE_PLACE]
    at = status["timestamp"] / 1e6
    is_armed = status["arming_state"] == ARMED_STATE
    armed = at[np.argmax(is_armed)]
    later = np.flatnonzero(~is_armed & (at > armed))
    changed = np.flatnonzero(np.diff(status["nav_state"], prepend=-1))
    modes = [(at[n], PX4_DOES.get(int(status["nav_state"][n]), f"mode {status['nav_state'][n]}")) for n in changed]
    places = np.column_stack([true["timestamp"] / 1e6, true["lat"], true["lon"], true["alt"]])
    texts = [(message.timestamp / 1e6, message.message) for message in read.logged_messages]
    return _flight(places, modes, texts, armed, at[later[0]] if len(later) else math.nan, home)


def _flight(
    place: Points,
    modes: list[tuple[float, str]],
    texts: list[tuple[float, str]],
    armed: float,
    ended: float,
    home: Geodetic,
) -> EndedFlight:
    frame = LocalFrame(home)
    place = place[place[:, 0] >= armed]
    thin = np.flatnonzero(np.diff(np.floor(place[:, 0] / TRACK_EVERY), prepend=-1.0))
    place = place[thin]
    local = frame.to_local(place[:, 1], place[:, 2], place[:, 3] - place[0, 3] + home.altitude)
    track = np.column_stack([place[:, 0] - armed, local])
    before = [(armed, does) for time, does in modes if time < armed][-1:]
    modes = before + [(time, does) for time, does in modes if time >= armed]
    return EndedFlight(tuple(_since(modes, armed)), track, float(ended - armed), tuple(_since(texts, armed)))


def _since(told: list[tuple[float, str]], armed: float) -> Iterator[tuple[float, str]]:
    return ((round(float(time - armed), 3), words) for time, words in told if time >= armed)
