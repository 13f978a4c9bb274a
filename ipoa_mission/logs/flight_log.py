"""Flights from logs of ground stations (`.tlog`), ArduPilot (`.bin`) and PX4 (`.ulg`)."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, MissionError, WrongSuffix
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import messages as m
from ipoa_mission.link.logbook import Logbook
from ipoa_mission.logs.logged import Begun, Held, Log, Measured, log_format, messages_of
from ipoa_mission.logs.telemetry_log import read_telemetry_log, vehicle_time
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.stored_mission import from_wire, home_item

AIRBORNE_HEIGHT = 1.0  # a rise that counts as flight [m]


@dataclass(frozen=True)
class LoggedFlight:
    """A flight from arming to disarming; `in_mission`: partly in mission mode.

    `mission` and `parameters` are those in the log. `armed_s` is the autopilot's clock at time zero, for `measured`.
    """

    autopilot: Autopilot
    version: str
    armed_s: float
    mission: Mission | None
    parameters: Mapping[str, float]
    in_mission: bool
    messages: tuple[m.Message, ...] = field(repr=False)
    measured: Measured = field(default_factory=Measured, repr=False)

    @property
    def firmware_version(self) -> Version | None:
        with suppress(BadInput):
            return Version.parsed(self.version)
        return None

    def record(self, mission: Mission | None = None) -> FlightRecord:
        logbook = Logbook(() if mission is None else mission.items, self.autopilot)
        for message in self.messages:
            if (vehicle_time(message) or 0.0) > logbook.clock_s + 3.0:  # [s]
                logbook.note_gap()
            logbook.note(message)
        return logbook.record()

    @property
    def tells_items(self) -> bool:
        return any(isinstance(message, m.Current | m.Reached) for message in self.messages)

    @property
    def places(self) -> Iterator[m.Position]:
        return (message for message in self.messages if isinstance(message, m.Position))

    def flown_in_mission(self) -> list[tuple[float, float, float]]:
        """Return latitude, longitude, height above home."""
        places = list[tuple[float, float, float]]()
        is_flying = False
        for message in self.messages:
            if isinstance(message, m.Heartbeat):
                is_flying = message.armed and message.custom_mode == self.autopilot.modes.mission
            elif isinstance(message, m.Position) and is_flying:
                places.append((message.latitude_deg, message.longitude_deg, message.height))
        return places


@dataclass(frozen=True)
class FlightLog:
    autopilot: Autopilot
    version: str
    flights: tuple[LoggedFlight, ...]
    remarks: tuple[str, ...]


def read_flight(path: str | Path, mission: Mission, system: int | None = None) -> FlightRecord:
    """Read the first flight in a log as one of a mission; time zero is the arming.

    Args:
        path: of a `.tlog`, a `.bin` or a `.ulg`.
        mission: the mission that was flown.
        system: the vehicle's system id in a `.tlog` with several; by default the first multicopter.

    Returns:
        The record of the flight, with remarks on the log.

    Raises:
        BadInput: another suffix, or not a log of that kind.
        MissionError: nothing in it was flown in the mission mode, or a package to read it is missing.

    Example:
        >>> from ipoa_mission import fly_built_in, read_flight, read_mission
        >>> mission = read_mission("missions/sitl.plan")
        >>> flown = fly_built_in(mission, log="sitl.tlog")
        >>> abs(read_flight("sitl.tlog", mission).total_s - flown.total_s) < 1.0
        True
    """
    log = read_flights(path, system)
    if log.autopilot is not mission.autopilot:
        words = f"expected a log of {mission.autopilot.firmware_name}, as the mission is for"
        raise MissionError(words, code="other-autopilot", place=path)
    flown = [flight for flight in log.flights if flight.in_mission]
    if not flown:
        raise _nothing_flown(path, log)
    several = (f"the first of {len(flown)} flights in the mission mode",) if len(flown) > 1 else ()
    return replace(flown[0].record(mission), remarks=(*log.remarks, *several))


def read_flights(path: str | Path, system: int | None = None) -> FlightLog:
    """Read the flights in a log: armed in mission mode, or risen.

    Args:
        path: of a log.
        system: as in `read_flight`.

    Returns:
        `flights`, at least one, and `remarks`.

    Raises:
        BadInput, MissionError: as `read_flight`.

    Example:
        >>> from ipoa_mission import read_flights
        >>> len(read_flights("missions/logs/campus-arducopter.tlog").flights)
        1
    """
    path = Path(path)
    if (written := log_format(path.suffix)) is not None:
        if system is not None:
            words = f"expected a .tlog with --system {system}: a log from on board holds one vehicle"
            raise BadInput(words, code="other-vehicle", place=path)
        log = written.read(path)
    elif path.suffix.lower() == ".tlog":
        log = read_telemetry_log(path, system)
    else:
        raise WrongSuffix("expected a log whose name ends in .tlog, .bin or .ulg", place=path)
    stretches = list(_stretches(log))
    remarks = [*log.remarks]
    flights = [stretch for stretch in stretches if stretch.flew_in(log.autopilot.modes.mission) or stretch.rose]
    whole = tuple(stretch.flight(log) for stretch in flights if stretch.is_whole)
    if len(whole) < len(flights):
        remarks.append("the log begins in flight: the time of arming is unknown, and this flight is left out")
    if flights and flights[-1].is_open:
        remarks.append("the log ends in flight: the rest of the flight is unknown")
    remarks += _gaps(log, written is not None)
    if others := len(stretches) - len(flights):
        remarks.append(f"{count_words(others, 'time')} it was armed without flying its mission")
    if any(flight.in_mission and not flight.tells_items for flight in whole):
        remarks.append("the log does not report when an item began or was done")
    flight_log = FlightLog(log.autopilot, log.version, whole, tuple(remarks))
    if not whole:
        raise _nothing_flown(path, flight_log)
    return flight_log


def _gaps(log: Log, is_on_board: bool) -> Iterator[str]:
    times, latitude, longitude, _, height = log.fixes.T[:5]
    most = 20.0 + 100.0 * np.diff(times)  # [m]
    beats = sorted((time, event.armed) for time, event in log.events if isinstance(event, m.Heartbeat))
    if times.size and beats:
        times = np.concatenate([[min(beats[0][0], times[0])], times])  # an arming may open the log
        since = np.array([*(time for time, _ in beats), max(beats[-1][0], times[-1])])
        armed_s = np.concatenate([[0.0], np.cumsum(np.diff(since) * [armed for _, armed in beats])])
        steps = np.diff(np.interp(times, since, armed_s))
        gap_s = 3.0 * np.median(np.diff(times)) if is_on_board else 3.0  # recorded on board: 1.7 steps at most
        gaps = steps[steps > gap_s]
    else:
        gaps = np.empty(0)
    if gaps.size:
        yield f"positions are missing {count_words(gaps.size, 'time')} in flight, for {gaps.max():.1f} s at most"
    degree = np.radians(1.0) * 6.371e6  # [m]
    with np.errstate(invalid="ignore", over="ignore"):
        east = longitude * degree * np.cos(np.radians(latitude))
        places = np.column_stack([latitude * degree, east, height])
        jumps = ~(np.abs(np.diff(places, axis=0)).max(axis=1) <= most)
    if jumps.any():
        yield f"positions jump {count_words(int(jumps.sum()), 'time')}, as no multicopter flies: some are wrong"


def _nothing_flown(path: str | Path, log: FlightLog) -> MissionError:
    words = "; ".join([f"nothing in it was flown in {log.autopilot.firmware_name}'s mission mode", *log.remarks])
    return MissionError(words, hint="check that it is the log of this flight", code="nothing-flown", place=path)


@dataclass
class _Known:
    items: tuple[Item, ...] = ()
    home: Geodetic | None = None
    parameters: dict[str, float] = field(default_factory=dict)

    def note(self, message: m.Message) -> None:
        match message:
            case Held(items):
                self.items = items
            case m.HomePosition(latitude, longitude, altitude):
                self.home = Geodetic(latitude, longitude, altitude)
            case m.ParamValue(name, value):
                self.parameters[name] = value


@dataclass
class _Stretch:
    """Messages from arming to disarming; state `at_arming`, and `later` changes."""

    is_whole: bool
    armed_s: float
    at_arming: _Known
    messages: list[m.Message]
    later: _Known = field(default_factory=_Known)
    begun: dict[int, Begun] = field(default_factory=dict)
    ends_s: float = 0.0
    is_open: bool = True  # no disarming

    def note(self, message: m.Message, now: float) -> None:
        self.messages.append(message)
        self.ends_s = now
        set_by_arming = self.later.home is None and now - self.armed_s < 2.0  # [s]
        if set_by_arming or not isinstance(message, m.HomePosition):
            self.later.note(message)
        if isinstance(message, Begun):
            self.begun[message.seq] = message

    def flew_in(self, mode: int) -> bool:
        beats = (message for message in self.messages if isinstance(message, m.Heartbeat))
        return any(beat.armed and beat.custom_mode == mode for beat in beats)

    @property
    def rose(self) -> bool:
        heights = [message.height for message in self.messages if isinstance(message, m.Position)]
        return bool(heights) and max(heights) - heights[0] > AIRBORNE_HEIGHT

    def flight(self, log: Log) -> LoggedFlight:
        parameters = self.later.parameters | self.at_arming.parameters
        mission = self._mission(log.autopilot)
        flew = self.flew_in(log.autopilot.modes.mission)
        measured = log.measured.between(self.armed_s, self.ends_s)
        messages = tuple(self.messages)
        return LoggedFlight(log.autopilot, log.version, self.armed_s, mission, parameters, flew, messages, measured)

    def _mission(self, autopilot: Autopilot) -> Mission | None:
        first = autopilot.seq_offset
        home = self.later.home or self.at_arming.home
        place = next((message for message in self.messages if isinstance(message, m.Position)), None)
        if home is None and place is not None:
            home = Geodetic(place.latitude_deg, place.longitude_deg, place.altitude - place.height)
        items = self.at_arming.items or self.later.items
        if self.begun:
            total = max(begun.total for begun in self.begun.values())
            begun = self.begun.items()
            if len(items) != total or any(seq >= total or items[seq] != each.item for seq, each in begun):
                flown = [self.begun[seq].item for seq in range(first, total) if seq in self.begun]
                before = (home_item(home),) * first if home else ()
                items = (*before, *flown) if len(flown) == total - first else ()
        return None if len(items) <= first or home is None else from_wire(items, autopilot, home)


def _stretches(log: Log) -> Iterator[_Stretch]:
    known = _Known()
    seen = False
    now = 0.0
    current: m.Current | None = None
    stretch: _Stretch | None = None
    clock: m.Message | None = None
    for message in messages_of(log):
        if isinstance(message, m.Position | m.SystemTime):
            clock = message
            now = message.time_s if isinstance(message, m.Position) else message.boot_s
        if stretch is not None:
            stretch.note(message, now)
        elif isinstance(message, m.Current):
            current = message
        if isinstance(message, m.Heartbeat):
            if message.armed and stretch is None:
                at_arming = _Known(known.items, known.home, dict(known.parameters))
                before = [heard for heard in (current, clock, message) if heard is not None]
                stretch = _Stretch(seen, now, at_arming, before)
            elif not message.armed and stretch is not None:
                stretch.is_open = False
                yield stretch
                stretch = current = None
            seen = True
        known.note(message)
    if stretch is not None:
        yield stretch
