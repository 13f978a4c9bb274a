"""Abort missions on a simulated autopilot at random seconds, by command or failsafe, and store how they end.

    python -m tools.fly.endings FOLDER --autopilot ardupilot --out DIR --seed 1 --count 60 --link tcp:127.0.0.1:5760
        --start "COMMAND {latitude} {longitude} {altitude} {folder}" --work DIR [--failsafes 6]

FOLDER has scenarios, NAME.toml, and their planned missions, NAME.plan. `{folder}` is the simulator's log folder,
`{parameters}` a file of NAME,VALUE for its start. Order, mission and time depend on the seed alone. Each order gets its
own simulator. DIR/N-MISSION-ENDING gets `order.json`, `flight.json` and `track.csv` (`ended_flight`), the input of
`tools.fly.endings_judge`.
"""

import argparse
import json
import math
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import FLOWN_TO, Command, Frame, VehicleCommand
from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingencies import Contingencies
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.codec import Target
from ipoa_mission.link.messages import AUTOPILOT_COMPONENT, CommandAck, CommandLong, Heartbeat, Message, ParamSet
from ipoa_mission.link.orders import spelled_parameter
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.scenario import read_scenario
from tools import command_line
from tools.fly.causes import TRIGGERS, Trigger
from tools.fly.ended_flight import flight_from
from tools.fly.simulators import connected, load, newest_log, set_up, simulation

WEIGHTS = {Contingency.RTL: 5, Contingency.LAND: 3, Contingency.SMART_RTL: 2, Contingency.HOLD: 2}
HOLDS_S = 20.0  # watch time of a hold
PATIENCE_S = 500.0  # after the order, by the vehicle's clock
UNHEARD_S = 90.0  # limit of the wait for an effect of silence or a failsafe
INT32, REAL32 = 6, 9  # MAV_PARAM_TYPE
INJECT_FAILURE = 420  # MAV_CMD_INJECT_FAILURE
TRAFFIC_S = 20.0  # duration of the traffic reports, by the vehicle's clock


@dataclass(frozen=True)
class Order:
    """Define an event of a mission at `second` s; of a failsafe with its number in `TRIGGERS`."""

    number: int
    mission: str
    second: float
    ending: str
    trigger: int | None = None

    @property
    def name(self) -> str:
        what = self.ending if self.trigger is None else f"failsafe{self.trigger}"
        return f"{self.number:04d}-{self.mission}-{what}"


class Over(Exception):
    """Raised after enough of a flight that does not end by itself."""


def orders(spans: dict[str, tuple[float, float]], autopilot: Autopilot, given: argparse.Namespace) -> Iterator[Order]:
    """Yield orders by the seed, evenly over the missions."""
    flown = dict(WEIGHTS) if "SMART_RTL" in autopilot.modes.names.values() else WEIGHTS | {Contingency.SMART_RTL: 0}
    names = sorted(spans)
    for number in _numbers(given, len(TRIGGERS[autopilot])):
        chance = random.Random(f"{given.seed}-{number}")
        begin, end = spans[mission := names[number % len(names)]]
        ending = given.ending or chance.choices(list(flown), list(flown.values()))[0]
        second = round(chance.uniform(begin, end), 1)
        fails = given.failsafes > 0 and number % given.failsafes == given.failsafes - 1
        trigger = number // given.failsafes % len(TRIGGERS[autopilot]) if fails else None
        if trigger is not None and TRIGGERS[autopilot][trigger].silent:
            second = round(begin, 1)  # detection takes a minute
        yield Order(number, mission, second, "" if fails else str(ending), trigger)


def _numbers(given: argparse.Namespace, failsafes: int) -> Iterator[int]:
    """Yield the numbers of the orders: in sequence, or those of the given failsafes."""
    if not given.triggers:
        yield from range(given.first, given.first + given.count)
        return
    given.failsafes = 1
    first = failsafes * math.ceil(given.first / failsafes)
    for n in range(given.count):
        yield from (first + n * failsafes + trigger for trigger in given.triggers)


class Breaker:
    """Process all messages of a vehicle, and send an order at one second of its flight."""

    def __init__(self, vehicle: Vehicle, order: Order, trigger: Trigger | None) -> None:
        self.vehicle, self.order, self.trigger = vehicle, order, trigger
        self.clock, self.armed_s, self.done_s = 0.0, math.inf, math.inf
        self.wall_s = 0.0

    def hear(self, message: Message) -> None:
        self.clock = max(self.clock, getattr(message, "time_s", 0.0) or 0.0)
        is_armed = isinstance(message, Heartbeat) and message.armed
        arming = isinstance(message, CommandAck) and message.command == Command.COMPONENT_ARM_DISARM
        if (is_armed or (arming and message.result == 0)) and self.armed_s == math.inf:  # type: ignore[attr-defined]
            self.armed_s = self.clock
        if self.trigger is not None and self.trigger.sticks and self.done_s == math.inf:
            self._say_often(self._sticks)
        if self.trigger is not None and self.trigger.traffic and self.done_s <= self.clock < self.done_s + TRAFFIC_S:
            self._say_often(self._traffic)
        since = self.clock - self.armed_s
        if since >= self.order.second and self.done_s == math.inf:
            self.done_s = self.clock
            self._order()
        elif self.clock - self.done_s > self._patience():
            raise Over

    def _patience(self) -> float:
        holding = self.vehicle.state.custom_mode == self.vehicle.autopilot.modes.hold
        flying_on = self.vehicle.state.custom_mode == self.vehicle.autopilot.modes.mission
        if self.order.ending == Contingency.HOLD:
            return HOLDS_S
        if flying_on or (holding and self.trigger is not None):
            return UNHEARD_S + HOLDS_S
        return PATIENCE_S

    def _order(self) -> None:
        modes, trigger = self.vehicle.autopilot.modes, self.trigger
        if trigger is None:
            own = {name: number for number, name in modes.names.items()}
            mode = {
                Contingency.RTL: modes.returning,
                Contingency.LAND: min(modes.lands),
                Contingency.HOLD: modes.hold,
                Contingency.SMART_RTL: own.get("SMART_RTL", 0),
            }[Contingency(self.order.ending)]
            numbers = (1.0, *map(float, modes.numbers(mode)), 0.0, 0.0, 0.0, 0.0, 0.0)[:7]
            self._say(CommandLong(VehicleCommand.DO_SET_MODE, numbers))  # type: ignore[arg-type]
            return
        if trigger.silent:
            self.vehicle.line._next_heartbeat = math.inf  # type: ignore[attr-defined]
        if trigger.fails is not None:
            fails = (*map(float, trigger.fails), 0.0, 0.0, 0.0, 0.0)
            self._say(CommandLong(INJECT_FAILURE, fails))  # type: ignore[arg-type]
        for name, value in trigger.then.items():
            kind = INT32 if isinstance(value, int) else REAL32
            self._say(ParamSet(name, spelled_parameter(float(value), kind, self.vehicle.autopilot), kind))

    def _say_often(self, made: Callable[[], Any]) -> None:
        if time.monotonic() - self.wall_s > 0.05:
            self.wall_s = time.monotonic()
            self.vehicle.send(made())

    def _sticks(self) -> Any:
        from pymavlink.dialects.v20 import common

        return common.MAVLink_manual_control_message(self.vehicle.system, 0, 0, 500, 0, 0)

    def _traffic(self) -> Any:
        """Return an aircraft north of the vehicle, at its height, flying south."""
        from pymavlink.dialects.v20 import common

        place = self.vehicle.state.position
        assert place is not None
        latitude, longitude = round(1e7 * (place.latitude_deg + 0.002)), round(1e7 * place.longitude_deg)
        return common.MAVLink_adsb_vehicle_message(
            77, latitude, longitude, 1, round(1000 * place.altitude), 18000, 3000, 0, b"TRAFFIC", 1, 1, 31, 1200
        )

    def _say(self, message: Message) -> None:
        self.vehicle.line.send(message, Target(self.vehicle.system, AUTOPILOT_COMPONENT))


def began_with(trigger: Trigger | None, path: Path) -> Path:
    """Write the parameters for the simulator's start, such as those of a receiver."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = (f"{name},{value:g}\n" for name, value in (trigger.before if trigger else {}).items())
    path.write_text("".join(lines), encoding="utf-8")
    return path


def over_terrain(forecast: Forecast) -> Forecast:
    """Return the forecast with waypoints at heights above terrain."""
    mission = forecast.given
    items = tuple(
        replace(item, frame=Frame.GLOBAL_TERRAIN_ALT) if item.command in FLOWN_TO - {Command.NAV_TAKEOFF} else item
        for item in mission.items
    )
    return Forecast(replace(mission, items=items), forecast.scenario)


def fly(order: Order, forecast: Forecast, given: argparse.Namespace) -> dict[str, Any]:
    """Fly one flight; return the order and the vehicle's data."""
    folder = given.work / "sim"
    shutil.rmtree(folder, ignore_errors=True)
    home = forecast.mission.home
    trigger = None if order.trigger is None else TRIGGERS[forecast.mission.autopilot][order.trigger]
    words = given.start.format(
        latitude=home.latitude_deg,
        longitude=home.longitude_deg,
        altitude=home.altitude,
        folder=folder,
        parameters=began_with(trigger, folder.with_suffix(".parm")),
    )
    with simulation(words, folder), connected(given.link) as vehicle:
        breaker = Breaker(vehicle, order, trigger)
        set_up(vehicle, forecast.wind)
        for name, value in forecast.world.vehicle.autopilot_parameters().items():
            vehicle.set_parameter(name, value)
        load(vehicle, over_terrain(forecast) if trigger and trigger.over_terrain else forecast, anyway=True)
        for name, value in (trigger.before if trigger else {}).items():
            vehicle.set_parameter(name, value)
        vehicle.overhearing = breaker.hear
        vehicle.prepare(0, permit=lambda there: None)
        vehicle.start()
        with suppress(Over):
            vehicle.watch()
        time.sleep(0.5)
        told = {**asdict(order), "version": str(vehicle.firmware_version())}
    if trigger:
        told |= {"cause": trigger.cause, "before": dict(trigger.before)}
    told["ordered_s"] = breaker.done_s - breaker.armed_s
    out = given.out / order.name
    out.mkdir(parents=True, exist_ok=True)
    flight_from(newest_log(folder), forecast.mission.home).write(out)
    (out / "order.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
    return told


def main(arguments: list[str]) -> None:
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--autopilot", required=True, choices=["px4", "ardupilot"])
    parser.add_argument("--start", required=True)
    parser.add_argument("--link", required=True)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--work", required=True, type=Path, help="where the simulator runs; emptied for each")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--ending", choices=[str(ending) for ending in WEIGHTS], help="order this one only")
    parser.add_argument("--triggers", type=int, nargs="*", help="these of its failsafes only, `--count` times each")
    parser.add_argument("--failsafes", type=int, default=0, help="every so many orders it is a failsafe")
    given = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that its simulator ends with it
    autopilot = autopilot_named(given.autopilot)
    forecasts: dict[str, Forecast] = {}
    for path in sorted(given.folder.glob("*.plan")):
        scenario = read_scenario(path.with_suffix(".toml"))
        if scenario.vehicle.autopilot is autopilot:
            forecasts[path.stem] = Forecast(read_mission(path, autopilot), scenario)
    spans = {}
    for name, forecast in forecasts.items():
        spans[name] = Contingencies(forecast).in_air
    for order in orders(spans, autopilot, given):
        if (given.out / order.name / "order.json").exists():
            continue
        began = time.monotonic()
        try:
            told = fly(order, forecasts[order.mission], given)
            print(f"{order.name}: ordered at {told['ordered_s']:.1f} s; {time.monotonic() - began:.0f} s", flush=True)
        except (MissionError, OSError, IndexError, KeyError, subprocess.SubprocessError) as error:
            print(f"{order.name}: {type(error).__name__}: {error} {getattr(error, 'hint', '')}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
