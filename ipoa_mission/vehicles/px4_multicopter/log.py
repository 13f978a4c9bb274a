"""PX4's own log (`.ulg`), read by pyulog (extra `logs`)."""

from collections.abc import Iterator, Set
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np

from ipoa_mission.autopilot.parameters import REAL32
from ipoa_mission.errors import BadInput, WrongFormat, imported
from ipoa_mission.files import read_bytes
from ipoa_mission.geometry import Matrix, Vector
from ipoa_mission.link.messages import INFO, Current, HomePosition, Message, MissionState, ParamValue, Reached, Text
from ipoa_mission.logs.logged import Battery, Log, LogFormat, Measured, in_order, presence, version_name
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.vehicles.px4_multicopter.vehicle import PX4_MULTICOPTER, Px4Mode

ARMED = 2  # vehicle_status.arming_state
#: vehicle_status.nav_state to HEARTBEAT.custom_mode.
MODES = {3: Px4Mode.AUTO_MISSION, 4: Px4Mode.AUTO_LOITER, 5: Px4Mode.AUTO_RTL, 18: Px4Mode.AUTO_LAND}
POSITION, VELOCITY = "vehicle_global_position", "vehicle_local_position"
BATTERY, ATTITUDE = "battery_status", "vehicle_attitude"
TOPICS = [POSITION, VELOCITY, "vehicle_status", "mission_result", "home_position", BATTERY, ATTITUDE]

HEADER = 16  # bytes before messages; head: size and kind
MESSAGE = Struct("<HB")

Event = tuple[float, Message]


def read_ulog(path: Path) -> Log:
    """Read positions, arming and modes (vehicle_status), items (mission_result), texts, parameters.

    Raises:
        BadInput: the file cannot be read, has no positions or states, or is of no multicopter.
        MissionError: pyulog is not installed.
    """
    log = _open(path)
    try:
        return _log(path, log)
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        raise WrongFormat(f"cannot be read as a PX4 log: {error}", place=path) from error


def _log(path: Path, log: Any) -> Log:
    topics = {topic.name: topic.data for topic in reversed(log.data_list)}
    topics = {name: data for name, data in topics.items() if len(data["timestamp"])}
    if "vehicle_status" not in topics:
        raise BadInput("expected a PX4 log with the topic vehicle_status", code="log-incomplete", place=path)
    if POSITION not in topics:
        raise BadInput(f"expected a PX4 log with the topic {POSITION}", code="log-incomplete", place=path)
    status = topics["vehicle_status"]
    kinds = status.get("vehicle_type", status.get("is_rotary_wing"))  # before 1.9
    rotary_wing = 1
    if kinds is not None and not (np.asarray(kinds) == rotary_wing).all():
        words = "expected the log of a multicopter, not of another kind of vehicle"
        raise BadInput(words, code="other-vehicle", place=path)
    begins = log.start_timestamp / 1e6
    opened_by_arming = log.initial_parameters.get("SDLOG_MODE", 0) == 0
    homes = _records(topics.get("home_position"), "lat", "lon", "alt")
    events = [
        *_parameters(log, begins),
        *((time, HomePosition(*map(float, place))) for time, *place in homes),
        *_states(status, begins if opened_by_arming else None),
        *_items(topics.get("mission_result")),
        *((message.timestamp / 1e6, Text(INFO, message.message)) for message in log.logged_messages),
    ]
    version = version_name(int(log.msg_info_dict.get("ver_sw_release", 0)) & 0xFFFFFFFF)
    batteries = (_battery(topic.data) for topic in log.data_list if topic.name == BATTERY)
    measured = Measured.of(batteries, _attitude(topics.get(ATTITUDE)))
    return Log(
        PX4_MULTICOPTER, _fixes(topics), tuple(events), version, tuple(_remarks(path, log, topics.keys())), measured
    )


def _messages(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield the kind and the end of each message; the last one may end beyond the data."""
    end = HEADER
    while end + MESSAGE.size <= len(data):
        size, kind = MESSAGE.unpack_from(data, end)
        end += MESSAGE.size + size
        yield kind, end


def _remarks(path: Path, log: Any, topics: Set[str]) -> Iterator[str]:
    data = read_bytes(path)
    offset = HEADER
    for kind, end in _messages(data):
        if kind not in b"BFIMPQALCDRSO" or end > len(data):
            break
        offset = end
    if offset < len(data):
        yield f"the log is damaged or truncated from byte {offset} of {len(data)} on"
    elif log.file_corruption:
        yield "the log is damaged"
    if log.dropouts:
        lost_s = sum(dropout.duration for dropout in log.dropouts) / 1e3
        yield f"PX4 lost log data {count_words(len(log.dropouts), 'time')}, {lost_s:.1f} s in all"
    lacking = sorted({"mission_result", "home_position", VELOCITY} - topics)
    if lacking:
        yield f"the log has no topics {', '.join(lacking)}"
    if not log.initial_parameters:
        yield "the log has no parameters"


def _open(path: Path) -> Any:
    pyulog = imported("pyulog", f"{path}: reading PX4's logs needs the package pyulog", "logs")
    _expect_definitions(path)
    try:
        with path.open("rb") as file, redirect_stdout(StringIO()):  # it prints warnings
            return pyulog.ULog(file, TOPICS)
    except Exception as error:  # any, on a damaged file
        raise WrongFormat(f"cannot be read as a PX4 log: {error}", place=path) from error


def _expect_definitions(path: Path) -> None:
    """Refuse damaged definitions, in which pyulog would search forever."""
    for kind, _ in _messages(read_bytes(path)):
        if kind in b"ALC":  # data begins
            return
        if kind not in b"BFIMPQ":
            break
    raise WrongFormat("cannot be read as a PX4 log: its definitions are incomplete", place=path)


def _parameters(log: Any, begins: float) -> Iterator[Event]:
    changed = [(time / 1e6, name, value) for time, name, value in log.changed_parameters]
    for time, name, value in [*((begins, *pair) for pair in log.initial_parameters.items()), *changed]:
        if isinstance(value, int | float):
            yield time, ParamValue(name, float(value), REAL32, 0, 0)


def _records(topic: Any | None, *names: str) -> Iterator[tuple[Any, ...]]:
    """Yield the time [s] and the named fields of each record; none without the topic."""
    columns = [] if topic is None else [topic[name] for name in ("timestamp", *names)]
    for stamp, *values in zip(*columns, strict=True):
        yield float(stamp) / 1e6, *values


def _states(status: Any, opened_by_arming: float | None) -> Iterator[Event]:
    """Return a heartbeat for each change of arming or mode, at PX4's time if logged; arming may open a log."""
    status = {"armed_time": np.zeros(len(status["timestamp"])), **status}
    before: tuple[bool, int] | None = None
    for time, arming, nav_state, armed_time in _records(status, "arming_state", "nav_state", "armed_time"):
        state = (int(arming) == ARMED, MODES.get(int(nav_state), 0))
        if state == before:
            continue
        if state[0] and not (before and before[0]):
            armed_s = float(armed_time) / 1e6 or (time if before else opened_by_arming)
            time = time if armed_s is None else armed_s
            if before is None and armed_s is not None:
                yield time, presence(PX4_MULTICOPTER, False, state[1])
        yield time, presence(PX4_MULTICOPTER, *state)
        before = state


def _battery(data: Any) -> Iterator[Battery]:
    columns = (_column(data, name).tolist() for name in ("timestamp", "voltage_v", "current_a"))
    return ((time / 1e6, volts, amperes) for time, volts, amperes in zip(*columns, strict=True))


def _attitude(data: Any | None) -> Matrix:
    """Return time, roll, pitch, yaw (n, 4) of quaternions from body to north, east, down."""
    if data is None:
        return np.empty((0, 4))
    w, x, y, z = (_column(data, f"q[{n}]") for n in range(4))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x**2 + y**2))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y**2 + z**2))
    return np.column_stack([_column(data, "timestamp") / 1e6, roll, pitch, yaw])


def _items(result: Any | None) -> Iterator[Event]:
    reached = -1
    turned = (-1, False)
    columns = ("seq_reached", "seq_current", "seq_total", "finished")
    for time, seq_reached, seq_current, total, finished in _records(result, *columns):
        if seq_reached != reached and seq_reached >= 0:
            yield time, Reached(int(seq_reached))
        if (seq_current, finished) != turned:
            yield time, Current(int(seq_current), int(total), MissionState.COMPLETE if finished else 0)
        reached = seq_reached
        turned = (seq_current, finished)


def _fixes(topics: dict[str, Any]) -> Matrix:
    rows = np.column_stack([_column(topics[POSITION], name) for name in ("timestamp", "lat", "lon", "alt")])
    times, latitude, longitude, altitude = (in_order(rows) / [1e6, 1.0, 1.0, 1.0]).T
    velocity = np.column_stack([_velocity(topics, axis, times) for axis in ("vx", "vy", "vz")])
    height = altitude - _ground(topics, times, altitude)
    return np.column_stack([times, latitude, longitude, altitude, height, velocity])


def _column(topic: Any, name: str) -> Vector:
    """Return a field (n,); NumPy would warn of signaling NaN."""
    with np.errstate(invalid="ignore"):
        return np.asarray(topic[name], float)


def _ground(topics: dict[str, Any], times: Vector, altitude: Vector) -> Vector:
    """Return home's altitude, which PX4 corrects on the ground and in flight."""
    home = topics.get("home_position")
    if home is None:
        return np.full(len(times), altitude[0] if len(times) else 0.0)
    set_at = _column(home, "timestamp") / 1e6
    return _column(home, "alt")[np.maximum(np.searchsorted(set_at, times, side="right") - 1, 0)]


def _velocity(topics: dict[str, Any], axis: str, times: Vector) -> Vector:
    local = topics.get(VELOCITY)
    if local is None:
        return np.zeros(len(times))
    times_s = _column(local, "timestamp") / 1e6
    speed = _column(local, axis)
    sound = np.isfinite(speed)
    return np.interp(times, times_s[sound], speed[sound]) if sound.any() else np.zeros(len(times))


FORMAT = LogFormat(".ulg", read_ulog, "PX4 logs no mission")
