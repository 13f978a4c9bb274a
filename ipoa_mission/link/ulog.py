"""PX4's own log (`.ulg`): where it was, what it did, which item it turned to, how it was set. Read by pyulog (extra
`logs`). Which items the mission has it does not tell.
"""

import importlib
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.autopilots.modes import px4_mode
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.geometry import Vector
from ipoa_mission.link.logbook import COMPLETE
from ipoa_mission.link.logged import Fixes, Log, presence, version_name
from ipoa_mission.link.messages import Current, Message, ParamValue, Reached, Text
from ipoa_mission.link.telemetry import HomePosition

ARMED = 2  # vehicle_status.arming_state
#: vehicle_status.nav_state, as HEARTBEAT.custom_mode has it: main and sub mode.
MODES = {3: px4_mode(4, 4), 4: px4_mode(4, 3), 5: px4_mode(4, 5), 18: px4_mode(4, 6)}
ROTARY_WING = 1  # vehicle_status.vehicle_type
FLOAT, INFO = 9, 6  # MAV_PARAM_TYPE_REAL32, MAV_SEVERITY_INFO
TOPICS = ["vehicle_global_position", "vehicle_local_position", "vehicle_status", "mission_result", "home_position"]

Event = tuple[float, Message]


def read_ulog(path: Path) -> Log:
    """Positions and events of a log: arming and modes (vehicle_status), items (mission_result), words, parameters.

    Raises:
        BadInput: the file cannot be read, holds no positions or no states, or is not of a multicopter.
        MissionError: pyulog is not installed.
    """
    log = _open(path)
    topics = {topic.name: topic.data for topic in reversed(log.data_list)}  # the first instance counts
    for name in ("vehicle_global_position", "vehicle_status"):
        if name not in topics or len(topics[name]["timestamp"]) == 0:
            raise BadInput(f"{path}: expected a PX4 log with the topic {name}, which is not in it")
    status = topics["vehicle_status"]
    if "vehicle_type" in status and not (np.asarray(status["vehicle_type"]) == ROTARY_WING).all():
        raise BadInput(f"{path}: expected the log of a multicopter, not of another kind of vehicle")
    begins = log.start_timestamp / 1e6
    opened_by_arming = log.initial_parameters.get("SDLOG_MODE", 0) == 0
    events = [
        *_parameters(log, begins),
        *_homes(topics.get("home_position")),
        *_states(status, begins if opened_by_arming else None),
        *_items(topics.get("mission_result")),
        *((message.timestamp / 1e6, Text(INFO, message.message)) for message in log.logged_messages),
    ]
    version = version_name(int(log.msg_info_dict.get("ver_sw_release", 0)) & 0xFFFFFFFF)
    return Log(Autopilot.PX4, _fixes(topics), tuple(events), version)


def _open(path: Path) -> Any:
    try:
        pyulog = importlib.import_module("pyulog")
    except ImportError as error:
        raise MissionError(
            f"{path}: reading PX4's logs needs the package pyulog", hint="pip install 'ipoa-mission[logs]'"
        ) from error
    try:
        with path.open("rb") as file, redirect_stdout(StringIO()):  # it prints what it thinks of a broken file
            return pyulog.ULog(file, TOPICS)
    except Exception as error:  # pyulog raises whatever a broken file makes it stumble over
        raise BadInput(f"{path}: cannot be read as a PX4 log: {error}") from error


def _parameters(log: Any, begins: float) -> Iterator[Event]:
    changed = [(time / 1e6, name, value) for time, name, value in log.changed_parameters]
    for time, name, value in [*((begins, *pair) for pair in log.initial_parameters.items()), *changed]:
        yield time, ParamValue(name, float(value), FLOAT, 0, 0)


def _homes(home: Any | None) -> Iterator[Event]:
    if home is not None:
        for time, latitude, longitude, altitude in zip(
            home["timestamp"], home["lat"], home["lon"], home["alt"], strict=True
        ):
            yield float(time) / 1e6, HomePosition(float(latitude), float(longitude), float(altitude))


def _states(status: Any, opened_by_arming: float | None) -> Iterator[Event]:
    """A heartbeat at every change of arming or mode; the time of arming is PX4's own where the log has it.

    A log that begins armed was opened by the arming, where the logger is set so: at the time given.
    """
    armed_times = status.get("armed_time", np.zeros(len(status["timestamp"])))
    before: tuple[bool, int] | None = None
    columns = (status["timestamp"], status["arming_state"], status["nav_state"], armed_times)
    for stamp, arming, nav_state, armed_time in zip(*columns, strict=True):
        state = (int(arming) == ARMED, MODES.get(int(nav_state), 0))
        time = float(stamp) / 1e6
        if state == before:
            continue
        if state[0] and not (before and before[0]):
            armed_s = float(armed_time) / 1e6 or (time if before else opened_by_arming)
            time = time if armed_s is None else armed_s
            if before is None and armed_s is not None:
                yield time, presence(Autopilot.PX4, False, state[1])
        yield time, presence(Autopilot.PX4, *state)
        before = state


def _items(result: Any | None) -> Iterator[Event]:
    """What PX4 would have sent: an item reached, the item it turned to, the mission complete."""
    if result is None:
        return
    reached, turned = -1, (-1, False)
    columns = (result[name] for name in ("timestamp", "seq_reached", "seq_current", "seq_total", "finished"))
    for time, seq_reached, seq_current, total, finished in zip(*columns, strict=True):
        at = float(time) / 1e6
        if seq_reached != reached and seq_reached >= 0:
            yield at, Reached(int(seq_reached))
        if (seq_current, finished) != turned:
            yield at, Current(int(seq_current), int(total), COMPLETE if finished else 0)
        reached, turned = seq_reached, (seq_current, finished)


def _fixes(topics: dict[str, Any]) -> Fixes:
    place = topics["vehicle_global_position"]
    times, kept = np.unique(np.asarray(place["timestamp"], float) / 1e6, return_index=True)
    latitude, longitude, altitude = (np.asarray(place[name], float)[kept] for name in ("lat", "lon", "alt"))
    velocity = np.column_stack([_velocity(topics, axis, times) for axis in ("vx", "vy", "vz")])
    return Fixes(times, latitude, longitude, altitude, altitude - _ground(topics, times, altitude), velocity)


def _ground(topics: dict[str, Any], times: Vector, altitude: Vector) -> Vector:
    """The altitude of home at each time: PX4 corrects it on the ground, and in flight where its estimate drifts."""
    home = topics.get("home_position")
    if home is None or not len(home["alt"]):
        return np.full(len(times), altitude[0])
    set_at, to = np.asarray(home["timestamp"], float) / 1e6, np.asarray(home["alt"], float)
    return to[np.maximum(np.searchsorted(set_at, times, side="right") - 1, 0)]


def _velocity(topics: dict[str, Any], axis: str, times: Vector) -> Vector:
    local = topics.get("vehicle_local_position")
    if local is None or len(local["timestamp"]) == 0:
        return np.zeros(len(times))
    return np.asarray(np.interp(times, np.asarray(local["timestamp"], float) / 1e6, np.asarray(local[axis], float)))
