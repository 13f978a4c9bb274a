r"""Fly crossing pairs on two simulators of real autopilots at once, and record both true tracks.

    python -m tools.fly.fly_pairs --count 10 --seed 1 --out DIR --speed 2 \
        --vehicle px4 "START {latitude} {longitude} {altitude} {speed}" udpin:127.0.0.1:14542 FOLDER_OF_LOGS \
        --vehicle ardupilot "..." tcp:127.0.0.1:5780 FOLDER_OF_LOGS [--repaired]

Both vehicles are flown by `ipoa-mission fly`. `--repaired` flies them by the timetable of `deconflict`. DIR has
N.json: missions, departures as planned and as flown, and tracks of seconds after arming, latitude, longitude, height.
A pair that DIR has is not flown again.
"""

import json
import math
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ipoa_mission import Forecast, read_mission, write_mission
from ipoa_mission.fleet.encounters import Encounters, PlannedDeparture
from ipoa_mission.fleet.fleet import timed_flight
from ipoa_mission.wind import CALM
from tools import command_line
from tools.fly.crossing_pairs import FRAME, CrossingPair, crossing_pairs
from tools.fly.simulators import connected, newest_log, set_up, simulation, true_track

SEPARATION = 10.0  # [m]
READY_S = 25.0  # until ArduCopter can be armed, beyond its first message
PREPARED_S = 40.0  # until both are prepared


class SimulatedVehicle(NamedTuple):
    autopilot: str
    start: str
    link: str
    logs: str


def program(*words: str) -> list[str]:
    return [sys.executable, "-m", "ipoa_mission", *words]


def timetable(files: list[Path], folder: Path, most_delay_s: float) -> list[dict[str, Any]]:
    out = folder / "repaired"
    words = program("deconflict", *map(str, files), "--separation", f"{SEPARATION:g}", "--json", "--out", str(out))
    words += ["--most-delay", f"{most_delay_s:g}", "--force"]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    slots: list[dict[str, Any]] = json.loads(ended.stdout)["timetable"]
    return slots


def meeting_departures(pair: CrossingPair) -> tuple[float, float]:
    """Return the departures at which a loss of separation is most probable [s]."""
    a, b = (
        PlannedDeparture(timed_flight(str(n), Forecast(mission), FRAME), 0.0) for n, mission in enumerate(pair.missions)
    )
    delays = np.arange(-30.0, 31.0)
    delay = float(delays[np.argmax(Encounters(SEPARATION).probabilities(a, b, delays))])
    return max(-delay, 0.0), max(delay, 0.0)


def begun(link: str) -> None:
    with connected(link) as vehicle:
        set_up(vehicle, CALM)


def armed_at(log: Path) -> float:
    """Return the wall time of the first armed heartbeat in a .tlog [s]; NaN: none."""
    armed_flag = 128
    read: Any = import_module("pymavlink.mavutil").mavlink_connection(str(log))
    while (message := read.recv_match(type="HEARTBEAT")) is not None:
        if message.get_srcComponent() == 1 and message.base_mode & armed_flag:
            return float(message._timestamp)
    return math.nan


def fly_pair(n: int, files: list[Path], slots: list[dict[str, Any]], options: Any, folder: Path) -> dict[str, Any]:
    """Fly both missions, each from its departure, and return what was planned and flown."""
    vehicles = [SimulatedVehicle(*words) for words in options.vehicle]
    logs = [folder / f"{file.stem}.tlog" for file in files]
    with ExitStack() as running:
        for vehicle, file in zip(vehicles, files, strict=True):
            home = read_mission(file).home
            place = {"latitude": home.latitude_deg, "longitude": home.longitude_deg, "altitude": home.altitude}
            start = vehicle.start.format(**place, speed=f"{options.speed:g}")
            running.enter_context(simulation(start, folder / file.stem))
        for vehicle in vehicles:
            begun(vehicle.link)
        time.sleep(READY_S)
        began = time.time() + PREPARED_S

        def fly(index: int) -> tuple[int, str]:
            departure = datetime.fromtimestamp(began + slots[index]["departs_s"] / options.speed, UTC)
            words = program("fly", slots[index]["file"], "--link", vehicles[index].link, "--set-params")
            words += ["--log", str(logs[index]), "--depart-at", departure.isoformat()]
            ended = subprocess.run(words, capture_output=True, text=True, check=False, timeout=600)
            return ended.returncode, ended.stdout + ended.stderr

        with ThreadPoolExecutor(2) as pool:
            ended = list(pool.map(fly, range(2)))
        took = time.time() - began
    tracks = [true_track(newest_log(Path(vehicle.logs))).round(7).tolist() for vehicle in vehicles]
    return {
        "pair": n,
        "files": [slot["file"] for slot in slots],
        "departs_s": [slot["departs_s"] for slot in slots],
        "change": [slot["change"] for slot in slots],
        "ended": ended,
        "took_s": round(took, 1),
        "armed_s": [round((armed_at(log) - began) * options.speed, 2) for log in logs],
        "tracks": tracks,
    }


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--repaired", action="store_true")
    parser.add_argument("--most-delay", type=float, default=600.0, help="of a timetable; 0: holds and heights only [s]")
    parser.add_argument("--meet", action="store_true", help="depart so that a loss of separation is most probable")
    parser.add_argument("--vehicle", nargs=4, action="append", required=True, metavar=SimulatedVehicle._fields)
    options = parser.parse_args()
    first, second = (words[0] for words in options.vehicle)
    for n, pair in enumerate(crossing_pairs(options.first + options.count, options.seed, (first, second))):
        folder = options.out / str(n)
        record = folder.with_suffix(".json")
        if n < options.first or record.exists():
            continue
        folder.mkdir(parents=True, exist_ok=True)
        files = [folder / f"{place}-{name}.plan" for place, name in enumerate((first, second), 1)]
        for mission, file in zip(pair.missions, files, strict=True):
            write_mission(mission, file)
        slots = timetable(files, folder, options.most_delay)
        if not options.repaired:
            departs_s = meeting_departures(pair) if options.meet else (0.0, 0.0)
            slots = [
                {"file": str(file), "departs_s": second, "change": ""}
                for file, second in zip(files, departs_s, strict=True)
            ]
        flown = fly_pair(n, files, slots, options, folder) | {"seed": options.seed}
        record.write_text(json.dumps(flown), encoding="utf-8")
        print(n, slots, [code for code, _ in flown["ended"]], flown["armed_s"], flown["took_s"], flush=True)


if __name__ == "__main__":
    main()
