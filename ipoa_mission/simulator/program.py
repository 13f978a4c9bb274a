"""The mission's items as the vehicle reads them: heights above home, places in the local frame, jumps counted down."""

import math

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import FLOWN_TO, Command, Frame, plain_frame
from ipoa_mission.items import Item
from ipoa_mission.itinerary.as_flown import is_as_high_as_now
from ipoa_mission.simulator.vehicle import Triple
from ipoa_mission.world.frame import Geodetic, LocalFrame

#: Commands at which a vehicle spends time; all others are done in passing.
NAVIGATED = FLOWN_TO | {Command.NAV_RETURN_TO_LAUNCH, Command.NAV_DELAY}
JUMPS_WITHOUT_END = 10_000  # a loop of nothing but jumps must not hang the simulation


class Program:
    """A mission's items, and how often each of its jumps has been taken."""

    def __init__(self, items: tuple[Item, ...], frame: LocalFrame, autopilot: Autopilot) -> None:
        self.items = items
        self._frame, self._autopilot = frame, autopilot
        self._first = 1 if autopilot is Autopilot.ARDUPILOT else 0  # what a jump calls the first item
        self.jumped: dict[int, int] = {}
        self._places: dict[int, Triple] = {}

    def __len__(self) -> int:
        return len(self.items)

    @property
    def home(self) -> Geodetic:
        """Where heights and places are counted from."""
        return self._frame.home

    def height(self, item: Item, now: float) -> float:
        """Height above home; an item over terrain, without a number, or of PAYLOAD_PLACE keeps the present one."""
        if item.command == Command.NAV_PAYLOAD_PLACE:
            return now
        frame = plain_frame(item.frame)
        if is_as_high_as_now(item, self._autopilot):
            return now
        height = item.altitude - self._frame.home.altitude if frame == Frame.GLOBAL else item.altitude
        return height if math.isfinite(height) else now

    def place(self, index: int, now: Triple) -> Triple:
        """Where item `index` is, east, north, up; what it leaves open is where the vehicle is `now`."""
        item = self.items[index]
        if not item.has_position or not math.isfinite(item.latitude_deg + item.longitude_deg):
            return now[0], now[1], self.height(item, now[2])
        if index not in self._places:
            height = self.height(item, now[2])
            there = Geodetic(item.latitude_deg, item.longitude_deg, self._frame.home.altitude)
            east, north, _ = (float(x) for x in self._frame.local(there))
            self._places[index] = (east, north, height)
        return self._places[index]

    def after(self, index: int, taking: bool) -> int | None:
        """The item that follows `index` once jumps are followed; `taking` a jump counts it, looking ahead does not."""
        counts = self.jumped if taking else dict(self.jumped)
        index += 1
        for _ in range(JUMPS_WITHOUT_END):
            if index >= len(self.items):
                return None
            item = self.items[index]
            if item.command != Command.DO_JUMP:
                return index
            times, target = item.params[1], int(item.params[0]) - self._first
            if (times < 0 or counts.get(index, 0) < times) and 0 <= target < len(self.items):
                counts[index] = counts.get(index, 0) + 1
                index = target
            else:
                index += 1
        return None

    def next_flown(self, index: int) -> int | None:
        """The next item after `index` at which the vehicle spends time."""
        found: int | None = index
        for _ in range(len(self.items) + 1):
            found = self.after(found, taking=False)  # type: ignore[arg-type]
            if found is None or self.items[found].command in NAVIGATED:
                return found
        return None
