"""PX4's own log (`.ulg`): where it was, what it did, which item it turned to. Read by pyulog (extra `logs`)."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Vector
from ipoa_mission.link.logbook import COMPLETE
from ipoa_mission.link.logged import Events, Fixes, presence
from ipoa_mission.link.messages import Current, Message, Reached, Text
from ipoa_mission.vehicle import Autopilot

ARMED = 2  # vehicle_status.arming_state
AUTO_MISSION = 3  # vehicle_status.nav_state
INFO = 6
TOPICS = ["vehicle_global_position", "vehicle_local_position", "vehicle_status", "mission_result", "home_position"]


def read_ulog(path: Path) -> tuple[Fixes, Events]:
    """Positions and events of a log: arming and modes (vehicle_status), items (mission_result), words.

    Raises:
        BadInput: the file cannot be read, or holds no positions or no states.
        MissionError: pyulog is not installed.
    """
    log = _open(path)
    topics = {topic.name: topic.data for topic in reversed(log.data_list)}  # the first instance counts
    for name in ("vehicle_global_position", "vehicle_status"):
        if name not in topics or len(topics[name]["timestamp"]) == 0:
            raise BadInput(f"{path}: expected a PX4 log with the topic {name}, which is not in it")
    events = [*_states(topics["vehicle_status"]), *_items(topics.get("mission_result"))]
    events += [(message.timestamp / 1e6, Text(INFO, message.message)) for message in log.logged_messages]
    times, messages = zip(*events, strict=True)
    return _fixes(topics), Events(tuple(times), tuple(messages))


def _open(path: Path) -> Any:
    try:
        pyulog = importlib.import_module("pyulog")
    except ImportError as error:
        raise MissionError(
            f"{path}: reading PX4's logs needs the package pyulog", hint="pip install 'ipoa-mission[logs]'"
        ) from error
    try:
        with path.open("rb") as file:
            return pyulog.ULog(file, TOPICS)
    except Exception as error:  # pyulog raises whatever a broken file makes it stumble over
        raise BadInput(f"{path}: cannot be read as a PX4 log: {error}") from error


def _states(status: Any) -> list[tuple[float, Message]]:
    """A heartbeat at every change of arming or mode."""
    found: list[tuple[float, Message]] = []
    before = None
    for time, arming, mode in zip(status["timestamp"], status["arming_state"], status["nav_state"], strict=True):
        state = (int(arming) == ARMED, int(mode) == AUTO_MISSION)
        if state != before:
            found.append((float(time) / 1e6, presence(Autopilot.PX4, *state)))
            before = state
    return found


def _items(result: Any | None) -> list[tuple[float, Message]]:
    """What PX4 would have sent: an item reached, the item it turned to, the mission complete."""
    found: list[tuple[float, Message]] = []
    if result is None:
        return found
    reached, turned = -1, (-1, False)
    columns = (result[name] for name in ("timestamp", "seq_reached", "seq_current", "seq_total", "finished"))
    for time, seq_reached, seq_current, total, finished in zip(*columns, strict=True):
        at = float(time) / 1e6
        if seq_reached != reached and seq_reached >= 0:
            found.append((at, Reached(int(seq_reached))))
        if (seq_current, finished) != turned:
            found.append((at, Current(int(seq_current), int(total), COMPLETE if finished else 0)))
        reached, turned = seq_reached, (seq_current, finished)
    return found


def _fixes(topics: dict[str, Any]) -> Fixes:
    place = topics["vehicle_global_position"]
    times = np.asarray(place["timestamp"], float) / 1e6
    altitude = np.asarray(place["alt"], float)
    home = topics.get("home_position")
    ground = float(home["alt"][-1]) if home is not None and len(home["alt"]) else float(altitude[0])
    velocity = np.column_stack([_velocity(topics, axis, times) for axis in ("vx", "vy", "vz")])
    return Fixes(
        times, np.asarray(place["lat"], float), np.asarray(place["lon"], float), altitude, altitude - ground, velocity
    )


def _velocity(topics: dict[str, Any], axis: str, times: Vector) -> Vector:
    local = topics.get("vehicle_local_position")
    if local is None or len(local["timestamp"]) == 0:
        return np.zeros(len(times))
    return np.asarray(np.interp(times, np.asarray(local["timestamp"], float) / 1e6, np.asarray(local[axis], float)))
