"""What happened on a flight, by the vehicle's own clock, gathered from whatever it says."""

from collections.abc import Callable
from dataclasses import dataclass

from ipoa_mission.link.dialogue import Dialogue, NoAnswer, Pause
from ipoa_mission.link.messages import Current, Heartbeat, Message, Position, Reached, Text
from ipoa_mission.mission.items import Command

#: A vehicle that says nothing for so long is lost.
LOST_S = 10.0
COMPLETE = 5  # MISSION_STATE


@dataclass(frozen=True)
class Sample:
    """Where the vehicle was: seconds since the start, degrees, altitude AMSL, height above home, speed [m/s]."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude: float
    height: float
    speed: float


@dataclass(frozen=True)
class FlightRecord:
    """A flight as it was flown. Time zero: armed, in the mission mode, on the ground.

    `item_reached_s` maps an index into `Mission.items` to the time when that item was done; one that the autopilot
    does not report (PX4: before a DO item) has the time when it turned to the next. An RTL or LAND that ends the
    mission is done when the motors stop, whatever the autopilot says before (PX4 reports RTL as it begins).
    """

    item_reached_s: dict[int, float]
    total_s: float
    path: tuple[Sample, ...]
    messages: tuple[str, ...]
    completed: bool


def brings_down(command: int) -> bool:
    """Whether a mission that ends with this command ends on the ground."""
    return command in (Command.NAV_LAND, Command.NAV_RETURN_TO_LAUNCH)


class Logbook:
    """Hears everything and remembers what belongs to a flight.

    `first` is the sequence number of the first item; `lands`: the last one brings the vehicle to the ground.
    """

    def __init__(self, items: int, first: int, lands: bool) -> None:
        self._items = items
        self._first = first
        self.lands = lands
        self._clock = 0.0
        self._zero = 0.0
        self._reached: dict[int, float] = {}
        self._path: list[Sample] = []
        self._texts: list[str] = []
        self._current = first
        self._state = 0
        self._begun = False
        self.armed = False
        self.disarmed_s: float | None = None

    @property
    def begun(self) -> bool:
        """Whether a flight has begun."""
        return self._begun

    def begin(self) -> None:
        """The flight starts now."""
        self._zero = self._clock
        self._begun = True
        self._reached.clear()
        self._path.clear()
        self._current = self._first

    @property
    def done(self) -> int:
        """How many items are done."""
        return max(self._reached, default=-1) + 1

    @property
    def is_complete(self) -> bool:
        """Whether the vehicle has said that its mission is complete, or reached the last item."""
        at_the_end = self.lands and self.disarmed_s is not None and self._current >= self._first + self._items - 1
        return self._state == COMPLETE or self._items - 1 in self._reached or at_the_end

    def note(self, message: Message) -> None:
        """Something was heard."""
        match message:
            case Position(time_s=time_s, velocity=v):
                self._clock = max(time_s, self._clock)
                if self._begun:
                    speed = (v[0] ** 2 + v[1] ** 2 + v[2] ** 2) ** 0.5
                    at = (message.latitude_deg, message.longitude_deg, message.altitude, message.height, speed)
                    self._path.append(Sample(self._since, *at))
            case Text(_, text):
                self._texts.append(text)
            case Heartbeat():
                if self.armed and not message.armed and self._begun:
                    self.disarmed_s = self._since
                self.armed = message.armed
            case Reached(seq) if self._begun:
                self._turn_to(seq)
                self._reached.setdefault(seq - self._first, self._since)
            case Current(seq, _, state) if self._begun:
                self._turn_to(seq)
                self._state = state

    def _turn_to(self, seq: int) -> None:
        """What lies before item `seq` is done."""
        if self._current < seq < self._first + self._items:
            for index in range(self._current - self._first, seq - self._first):
                self._reached.setdefault(index, self._since)
        self._current = max(self._current, seq)

    def record(self) -> FlightRecord:
        """The flight so far."""
        reached = dict(sorted((index, t) for index, t in self._reached.items() if 0 <= index < self._items))
        final = self._items - 1
        if self.lands:
            reached.pop(final, None)
            if self.is_complete and self.disarmed_s is not None:
                reached[final] = self.disarmed_s
        end = reached.get(final, self.disarmed_s if self.disarmed_s is not None else self._since)
        return FlightRecord(reached, end, tuple(self._path), tuple(self._texts), self.is_complete)

    @property
    def _since(self) -> float:
        return self._clock - self._zero


def watch(logbook: Logbook, progress: Callable[[int], None]) -> Dialogue[FlightRecord]:
    """Listen until the flight is over: disarmed, or, for a mission that does not land, complete.

    The logbook hears the same messages first. `progress` is told how many items are done.

    Raises:
        NoAnswer: the vehicle is not heard any more.
    """
    told = -1
    heard = yield Pause(LOST_S)
    while heard is not None:
        if logbook.done != told:
            told = logbook.done
            progress(told)
        if logbook.disarmed_s is not None or (logbook.is_complete and not logbook.lands):
            return logbook.record()
        heard = yield Pause(LOST_S)
    raise NoAnswer(
        f"the vehicle is not heard any more, after item {told}", hint="the log has what was heard until then"
    )
