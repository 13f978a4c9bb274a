"""The process that uploads and flies for the studio: `python -m ipoa_mission.studio.pilot`.

Nothing is armed before the page has named vehicle, mission and proof as they are here.
"""

import pickle
import queue
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ipoa_mission.errors import MissionError
from ipoa_mission.flight.flight import Flight
from ipoa_mission.flight.procedure import Stage, begin_mission, load_mission
from ipoa_mission.forecast.endings_now import EndingsNow
from ipoa_mission.link.connect import connect
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.messages import Message
from ipoa_mission.link.telemetry import Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress, silent
from ipoa_mission.simulator.fly import board
from ipoa_mission.studio.flight_answers import EndingThen, Landed, Loaded, Seen, State
from ipoa_mission.studio.harness import Answer, Order, work
from ipoa_mission.studio.listening import listen
from ipoa_mission.vehicles.ending import Ending
from ipoa_mission.world.frame import Geodetic

SEEN_EVERY_S = 0.2  # the vehicle's place is told no more often than this, by its own clock
THEN_EVERY_S = 1.0  # what an ending would do, no more often than this
LOOK_S = 0.1


class FlightWorker:
    """Flies one mission at a time; `beside` holds what the page says meanwhile."""

    def __init__(self, beside: "queue.SimpleQueue[Order]") -> None:
        self._beside = beside

    def fly(self, order: Order, answer: Answer) -> None:
        """Upload, wait for the second step, fly, and tell what is seen."""
        while not self._beside.empty():
            self._beside.get()  # said of an earlier flight
        flight, proof = _handed_over(Path(order["file"]))
        log = Path(order["log"])
        with _vehicle(order, flight, log) as vehicle:
            name = f"{'built-in ' if order['link'] is None else ''}{vehicle.autopilot}, system {vehicle.system}"
            remarks = _upload(flight, vehicle, lambda words: answer(State(phase="uploading", words=words)))
            loaded = Loaded(
                revision=order["revision"],
                vehicle=name,
                mission=flight.name,
                proof=proof,
                items=len(flight.mission.items),
                built_in=order["link"] is None,
                remarks=remarks,
            )
            answer(loaded)
            answer(State(phase="loaded", words=f"{len(flight.mission.items)} items are on {name}, read back and equal"))
            self._await_start(loaded)
            record = _flown(flight, vehicle, answer, order["speedup"] if order["link"] is None else None, self._beside)
        answer(
            Landed(
                completed=record.completed,
                why_not=record.why_not,
                flown_s=round(record.total_s, 2),
                estimated_s=round(flight.estimate.total_s, 2),
                log=log.name,
            )
        )
        answer(State(phase="over", words="landed" if record.completed else f"not complete: {record.why_not}"))

    def _await_start(self, loaded: Loaded) -> None:
        """Wait until the page starts this very flight; often, since nothing cancels a thread that waits for ever."""
        start: Order | None = None
        while start is None:
            with suppress(queue.Empty):
                start = self._beside.get(timeout=LOOK_S)
        for what in ("vehicle", "mission", "proof"):
            if start.get(what) != getattr(loaded, what):
                raise MissionError(
                    f"not started: you named {what} {start.get(what)!r}, and it is {getattr(loaded, what)!r}",
                    hint="upload again",
                )


def _handed_over(file: Path) -> tuple[Flight, str]:
    """The flight and its proof's digest, from the planner's process; the file is in a folder of this user's alone."""
    flight, proof = pickle.loads(file.read_bytes())
    file.unlink()
    return flight, proof


@contextmanager
def _vehicle(order: Order, flight: Flight, log: Path) -> Iterator[Vehicle]:
    """The built-in autopilot, or the vehicle on a link."""
    link, system = order["link"], order["system"]
    with board(flight.forecast, log=log) if link is None else connect(link, system=system, log=log) as vehicle:
        yield vehicle


def _upload(flight: Flight, vehicle: Vehicle, tell: Callable[[str], None]) -> tuple[str, ...]:
    """The mission on the vehicle, each stage told; what the user should know of it."""

    @contextmanager
    def stages(stage: Stage) -> Iterator[Progress]:
        tell(stage)
        yield lambda _, words: tell(words)

    remarks: list[str] = []
    load_mission(vehicle, flight.forecast, stages=stages, remark=remarks.append)
    return tuple(remarks)


def _flown(
    flight: Flight, vehicle: Vehicle, answer: Answer, speedup: float | None, beside: "queue.SimpleQueue[Order]"
) -> FlightRecord:
    """The flight from here to its end; the built-in autopilot, which knows no clock, so many times as fast as real.

    `beside` holds how the page would end it.
    """

    @contextmanager
    def stages(stage: Stage) -> Iterator[Progress]:
        if stage is Stage.FLIGHT:
            answer(State(phase="flying", words=Stage.START))
            yield silent
        else:
            if stage is Stage.START:
                vehicle.overhearing = Watch(flight, vehicle, answer, speedup, beside).hear
            yield lambda _, words: answer(State(phase="preparing", words=words))

    def remark(words: str) -> None:
        answer(State(phase="preparing", words=words))

    return begin_mission(vehicle, flight.forecast, stages=stages, remark=remark)


class Watch:
    """Tells where the vehicle is, how it stands against the estimate, what an ending would do now; orders it one."""

    def __init__(
        self,
        flight: Flight,
        vehicle: Vehicle,
        answer: Answer,
        speedup: float | None,
        beside: "queue.SimpleQueue[Order]",
    ) -> None:
        self._endings, self._frame, self._beside = EndingsNow(flight.forecast), flight.forecast.frame, beside
        self._then: tuple[EndingThen, ...] = ()
        self._then_s = -THEN_EVERY_S
        self._expected = {item.seq - 1: item.done_s for item in flight.estimate.items}
        self._home = flight.mission.home.altitude
        self._vehicle = vehicle
        self._answer = answer
        self._speedup = speedup
        self._told = -SEEN_EVERY_S
        self._warned = ""
        self._begun: tuple[float, float] | None = None

    def hear(self, message: Message) -> None:
        """One message of the vehicle; one that does not say where it is may have to land all the sooner."""
        with suppress(queue.Empty):
            self._end(self._beside.get_nowait()["ending"])
        vehicle = self._vehicle
        if (warning := vehicle.changed or vehicle.ending.words or vehicle.interrupted) != self._warned:
            self._warned = warning
            self._answer(State(phase="flying", words=warning or Stage.START))
        if not isinstance(message, Position) or not vehicle.state.armed:
            return
        if message.time_s - self._told >= SEEN_EVERY_S:
            self._told = message.time_s
            self._keep_pace(message.time_s)
            record = self._vehicle.record()
            if record.path:
                self._answer(self._seen(message, record))

    def _seen(self, at: Position, record: FlightRecord) -> Seen:
        reached = record.item_reached_s
        last = max(reached, default=None)
        return Seen(
            time_s=round(record.path[-1].time_s, 2),
            place=(at.longitude_deg, at.latitude_deg),
            up=round(at.height, 2),
            speed=round(record.path[-1].speed, 2),
            done=0 if last is None else last + 1,
            flown_s=None if last is None else round(reached[last], 2),
            expected_s=None if last is None else round(self._expected.get(last, reached[last]), 2),
            endings=self._endings_then(at, record.path[-1].time_s),
        )

    def _endings_then(self, at: Position, time_s: float) -> tuple[EndingThen, ...]:
        if not self._vehicle.state.in_air or self._vehicle.interrupted:
            return ()
        if time_s - self._then_s >= THEN_EVERY_S:
            self._then_s = time_s
            place = self._frame.local(Geodetic(at.latitude_deg, at.longitude_deg, at.altitude))
            self._then = tuple(
                EndingThen(
                    ending="rtl" if row.ending is Ending.RTL else "land",
                    clear=row.clear,
                    words=f"{row.leads}: {row.keeps}",
                    seconds=None if seconds is None else round(seconds, 1),
                )
                for row, seconds in self._endings.at(place, time_s)
            )
        return self._then

    def _end(self, ending: str) -> None:
        """Order it; that the vehicle took it is told as its leaving of the mission."""
        modes = self._vehicle.autopilot.modes
        self._vehicle.ending.give(modes.returning if ending == Ending.RTL else min(modes.lands))

    def _keep_pace(self, now_s: float) -> None:
        if self._speedup is None:
            return
        if self._begun is None:
            self._begun = (now_s, time.monotonic())
        first_s, begun = self._begun
        ahead = (now_s - first_s) / self._speedup - (time.monotonic() - begun)
        if ahead > 0:
            time.sleep(ahead)


if __name__ == "__main__":
    work(lambda beside: {"fly": (FlightWorker(beside).fly, "flight"), "listen": (listen, "flight")})
