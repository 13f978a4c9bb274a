"""Upload and fly; arms only after the page has named the same vehicle, mission and proof."""

import queue
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Literal

from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import ProcedureOptions, Stage, begin_mission, load_mission
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.channel import serial_ports
from ipoa_mission.link.connect import connect, open_line
from ipoa_mission.link.discovery import scan
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress
from ipoa_mission.simulator.fly import board
from ipoa_mission.studio.flight_answers import Heard, HeardLink, Landed, Loaded, State
from ipoa_mission.studio.handed import HandedOver
from ipoa_mission.studio.harness import Answer, Order, work
from ipoa_mission.studio.watch import Watch

LISTEN_S = 1.5  # per link; heartbeats come once a second
USUAL = ("udpin:127.0.0.1:14550", "udpin:127.0.0.1:14540", "tcp:127.0.0.1:5760")


class FlightWorker:
    """Fly one mission at a time; the queue `beside` holds the page's messages."""

    def __init__(self, beside: "queue.SimpleQueue[Order]") -> None:
        self._beside = beside

    def fly(self, order: Order, answer: Answer) -> None:
        while not self._beside.empty():
            self._beside.get()  # left over
        handed, log = HandedOver.take(Path(order["file"])), Path(order["log"])
        try:
            self._fly(handed, order, log, answer)
        except MissionError as error:
            if error.hint and "--" in error.hint:
                error.hint = f"from the command line: {error.hint}"
            raise

    def _fly(self, handed: HandedOver, order: Order, log: Path, answer: Answer) -> None:
        with _vehicle(order, handed.forecast, log) as vehicle:
            forecast = handed.forecast.on(vehicle.firmware_version())
            items = len(forecast.given.items)
            name = f"{'built-in ' if order['link'] is None else ''}{vehicle.autopilot}, system {vehicle.system}"
            tell = lambda words: answer(State(phase="uploading", words=words))  # noqa: E731
            forecast, remarks = _upload(forecast, vehicle, order["set_params"], tell)
            loaded = Loaded(
                revision=order["revision"],
                vehicle=name,
                system=vehicle.system,
                mission=handed.name,
                proof=handed.proof,
                items=items,
                built_in=order["link"] is None,
                remarks=tuple(dict.fromkeys((*handed.remarks, *remarks))),
            )
            answer(loaded)
            answer(State(phase="loaded", words=f"{items} items are on {name}, read back and equal"))
            self._await_start(loaded)
            speedup = order["speedup"] if order["link"] is None else None
            record, ordered = _flown(forecast, vehicle, answer, speedup, self._beside)
        ordered = None if record.completed or record.armed or record.deviations else ordered
        answer(
            Landed(
                completed=record.completed,
                why_not=record.why_not,
                ordered=ordered,
                flown_s=round(record.total_s, 2),
                estimated_s=round(forecast.estimate.total_s, 2),
                log=log.name,
            )
        )
        if record.completed or ordered:
            words = f"landed{'' if ordered is None else ', as ordered'}"
        else:
            words = f"not complete: {record.why_not}"
        answer(State(phase="over", words=words))

    def _await_start(self, loaded: Loaded) -> None:
        """Poll until the page starts this very flight: a thread that waits for ever cannot be cancelled."""
        start: Order | None = None
        while start is None:
            with suppress(queue.Empty):
                start = self._beside.get(timeout=0.1)
        for what in ("vehicle", "mission", "proof"):
            if start.get(what) != getattr(loaded, what):
                words = f"not started: {what}: expected {getattr(loaded, what)!r}, not {start.get(what)!r}"
                raise MissionError(words, hint="upload again", code="upload-again")


@contextmanager
def _vehicle(order: Order, forecast: Forecast, log: Path) -> Iterator[Vehicle]:
    link, system = order["link"], order["system"]
    with board(forecast, log=log) if link is None else connect(link, system=system, log=log) as vehicle:
        yield vehicle


def _upload(
    forecast: Forecast, vehicle: Vehicle, set_params: bool, tell: Callable[[str], None]
) -> tuple[Forecast, tuple[str, ...]]:

    @contextmanager
    def stages(stage: Stage) -> Iterator[Progress]:
        tell(stage)
        yield lambda _, words: tell(words)

    remarks: list[str] = []
    own = load_mission(vehicle, forecast, ProcedureOptions(set_params=set_params, stages=stages, remark=remarks.append))
    return own, tuple(remarks)


def _flown(
    forecast: Forecast, vehicle: Vehicle, answer: Answer, speedup: float | None, beside: "queue.SimpleQueue[Order]"
) -> tuple[FlightRecord, Literal["rtl", "land"] | None]:
    """Fly; also return the order by which it landed. `speedup`: of the built-in autopilot, which has no clock."""

    watching: list[Watch] = []

    @contextmanager
    def stages(stage: Stage) -> Iterator[Progress]:
        if stage is Stage.FLIGHT:
            answer(State(phase="flying", words=Stage.START))
            yield watching[0].look
        else:
            if stage is Stage.START:
                watching.append(Watch(forecast, vehicle, answer, speedup, beside))
                vehicle.overhearing = watching[0].hear
            yield lambda _, words: answer(State(phase="preparing", words=words))

    def remark(words: str) -> None:
        answer(State(phase="preparing", words=words))

    vehicle.conformance.ends_held = False
    record = begin_mission(vehicle, forecast, ProcedureOptions(stages=stages, remark=remark))
    return record, watching[0].obeyed


def listen(order: Order, answer: Answer) -> None:
    links = dict.fromkeys([order["link"], *USUAL, *(f"serial:{port}:57600" for port in serial_ports())])
    answer(Heard(links=tuple(row for link in links if link for row in _heard_on(link))))


def _heard_on(link: str) -> Iterator[HeardLink]:
    try:
        with open_line(link) as line:
            found = scan(line, LISTEN_S)
    except MissionError as error:
        yield HeardLink(link=link, system=None, words=str(error).removeprefix(f"{link}: "))
        return
    for one in found:
        other = "" if one.kind.is_flown else ": it is not flown from here"
        words = f"{one.kind}, system {one.system}{', armed' if one.armed else ''}{other}"
        yield HeardLink(link=link, system=one.system, words=words)
    if not found:
        yield HeardLink(link=link, system=None, words="no vehicle heard")


if __name__ == "__main__":
    work(lambda beside: {"fly": (FlightWorker(beside).fly, "flight"), "listen": (listen, "flight")})
