"""Start, set up and stop simulators of real autopilots, and read their logs."""

import os
import shlex
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission import connect
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import ProcedureOptions, load_mission
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.link.conversations import MissionRefused
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.vehicles.arducopter.log import read_records
from ipoa_mission.wind import Wind

BOOTS_S = 60.0
TRANSFERS = 5
EVERYWHERE = 1.0  # SIM_WIND_T: full wind near the ground
LOGS = ("*.BIN", "*.bin", "*.ulg")
TRUE_PLACE = "vehicle_global_position_groundtruth"  # of PX4
ARMED_STATE = 2  # vehicle_status.ARMING_STATE_ARMED
TRACK_EVERY = 0.1  # [s]


@contextmanager
def simulation(words: str, folder: Path) -> Iterator[None]:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder.parent / f"{folder.name}.out").open("w") as out:
        running = subprocess.Popen(shlex.split(words), start_new_session=True, stdout=out, stderr=out)
        try:
            yield
        finally:
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGTERM)
            try:
                running.wait(timeout=10.0)
            except subprocess.TimeoutExpired:
                os.killpg(running.pid, signal.SIGKILL)
                running.wait(timeout=10.0)


def connected(link: str) -> Vehicle:
    until = time.monotonic() + BOOTS_S
    while True:
        try:
            return connect(link)
        except MissionError:
            if time.monotonic() > until:
                raise
            time.sleep(0.3)


def set_up(vehicle: Vehicle, wind: Wind) -> None:
    """Wait for its position, set its wind, and log its arming time."""
    while not ((at := vehicle.home()) and at.latitude_deg):
        time.sleep(0.2)
    if vehicle.autopilot is Autopilot.PX4:
        return
    air = {"SIM_WIND_SPD": wind.speed, "SIM_WIND_DIR": wind.from_deg % 360.0, "SIM_WIND_T": EVERYWHERE}
    for name, value in {"LOG_DISARMED": 1.0, **(air if wind.speed > 0.0 else {})}.items():
        vehicle.set_parameter(name, value)


def load(vehicle: Vehicle, forecast: Forecast, anyway: bool = False) -> None:
    """Upload a mission; a simulator much faster than real time may give up a transfer."""
    options = ProcedureOptions(set_params=True, anyway=anyway, checked=True)
    for _ in range(TRANSFERS - 1):
        with suppress(MissionRefused, NoAnswer):
            load_mission(vehicle, forecast, options)
            return
    load_mission(vehicle, forecast, options)


def newest_log(folder: Path) -> Path:
    logs = [log for kind in LOGS for log in folder.rglob(kind)]
    return max(logs, key=lambda log: log.stat().st_mtime)


def true_track(log: Path) -> Points:
    """Return seconds from arming, latitude, longitude, height above the place of arming, (n, 4)."""
    rows, armed = _of_px4(log) if log.suffix == ".ulg" else _of_copter(log)
    rows = rows[rows[:, 0] >= armed]
    rows = rows[np.diff(np.floor(rows[:, 0] / TRACK_EVERY), prepend=-1.0) != 0]
    return np.asarray(rows - np.array([armed, 0.0, 0.0, rows[0, 3]]))


def _of_copter(log: Path) -> tuple[Points, float]:
    """Return the simulator's own positions, and the time of arming."""
    places, armed = [], np.nan
    for kind, record in read_records(log, frozenset({"SIM", "ARM"})):
        if kind == "SIM":
            places.append((record["TimeUS"] / 1e6, record["Lat"], record["Lng"], record["Alt"]))
        elif record["ArmState"] and np.isnan(armed):
            armed = record["TimeUS"] / 1e6
    return np.array(places), armed


def _of_px4(log: Path) -> tuple[Points, float]:
    read: Any = import_module("pyulog").ULog(str(log), [TRUE_PLACE, "vehicle_status"])
    topics = {topic.name: topic.data for topic in read.data_list}
    status, true = topics["vehicle_status"], topics[TRUE_PLACE]
    armed = status["timestamp"][np.argmax(status["arming_state"] == ARMED_STATE)] / 1e6
    return np.column_stack([true["timestamp"] / 1e6, true["lat"], true["lon"], true["alt"]]), float(armed)
