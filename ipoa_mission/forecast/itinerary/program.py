"""The one reader of mission items: in which order they come up, where each is done, what is flown on to after it.

Places are east, north, up of home [m]; `up` is the height above home as the autopilot keeps it (a flat Earth), not the
height over home's tangent plane. ArduCopter takes latitude and longitude 0 for the place, and altitude 0 for the
height, of the item before (ArduPilot's ModeAuto, since 2014). PX4 flies to what it is given; a null place of its
take-off and landing is "here".
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ipoa_mission.forecast.itinerary.jump_targets import jump_target, repeats
from ipoa_mission.geometry import Points
from ipoa_mission.mission.commands import (
    ALSO_MOVE,
    FLOWN_TO,
    JUMPS,
    LAST_NAV,
    TO_THE_GROUND,
    WAYPOINTS,
    Command,
    Frame,
    plain_frame,
)
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.vehicles.autopilot import Autopilot
from ipoa_mission.vehicles.jump_profile import JumpProfile
from ipoa_mission.vehicles.version import Version
from ipoa_mission.world.frame import Geodetic, LocalFrame

Place: TypeAlias = tuple[float, float, float]  # east, north, up [m]

Steps: TypeAlias = list[tuple[list[int], int | None]]  # what is done in passing, and then flown to

MOST_STEPS = 5_000  # that are followed
MOST_ACTIONS = 255  # between two items that move it; a loop without such an item must not hang


def as_flown(mission: Mission) -> Mission:
    """The mission with a place and a height in every item that is flown to, items taken in their order.

    >>> from ipoa_mission.mission.items import takeoff, waypoint
    >>> from ipoa_mission.world.frame import Geodetic
    >>> home, there = Geodetic(47.397742, 8.545594, 488.0), Geodetic(47.398642, 8.545594)
    >>> items = (takeoff(home, 15.0), waypoint(there, 0.0))
    >>> as_flown(Mission(home, items, Autopilot.ARDUPILOT)).items[1].altitude
    15.0
    """
    latitude, longitude = mission.home.latitude_deg, mission.home.longitude_deg
    altitude, frame = 0.0, int(Frame.GLOBAL_RELATIVE_ALT)
    items: list[Item] = []
    for item in mission.items:
        if item.is_as_high_as_now(mission.autopilot):
            item = replace(item, altitude=altitude, frame=frame)
        if item.is_here(mission.autopilot) and item.command not in TO_THE_GROUND | {Command.NAV_PAYLOAD_PLACE}:
            item = replace(item, latitude_deg=latitude, longitude_deg=longitude)
        items.append(item)
        if item.has_position and item.command != Command.NAV_TAKEOFF:  # that climbs where the vehicle stands
            latitude, longitude = item.latitude_deg, item.longitude_deg
        keeps_height = item.command == Command.NAV_LAND or item.frame == Frame.MISSION
        if item.command in FLOWN_TO and math.isfinite(item.altitude) and not keeps_height:
            altitude, frame = item.altitude, plain_frame(item.frame)
    return replace(mission, items=tuple(items))


def over_terrain(item: Item) -> bool:
    """Whether its altitude is one over terrain."""
    return plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT


def is_passed(item: Item) -> bool:
    """Whether it is to have been at this waypoint, and not to stay there, as ArduCopter holds for whole seconds."""
    if item.command == Command.NAV_ARC_WAYPOINT:  # whose param1 is an angle
        return True
    return item.command in WAYPOINTS and item.params[0] < 1


def onward(items: Sequence[Item], n: int, autopilot: Autopilot, later: Iterable[int] | None = None) -> int | None:
    """The item that is flown on to without stopping at item n; those that do not move the vehicle are no hindrance."""
    following, guidance = next_navigated(items, n, autopilot, later), autopilot.guidance
    if following is None or items[following].command not in guidance.flown_on_into:
        return None
    if guidance.stops_at_terrain and over_terrain(items[following]) != over_terrain(items[n]):
        return None
    return following


def next_navigated(
    items: Sequence[Item], n: int, autopilot: Autopilot, later: Iterable[int] | None = None
) -> int | None:
    """The item that the autopilot looks ahead to as it flies to item n; None where it holds there, or there is none.

    `later` are the items that follow in the order in which they come up; without it, in the order of their numbers.
    """
    if autopilot.guidance.stops_to_hold and not is_passed(items[n]):
        return None
    for index in range(n + 1, len(items)) if later is None else later:
        if items[index].command <= LAST_NAV or items[index].command in ALSO_MOVE:
            return index
    return None


@dataclass
class Program:
    """Items in the frame of their home, and how often each jump has been taken; indices count from 0.

    `first` is what a jump calls the first item: 1 in a mission file, 0 in the store of PX4.
    """

    items: tuple[Item, ...]
    frame: LocalFrame
    autopilot: Autopilot
    first: int = 1
    jumping: JumpProfile | None = None
    """How jumps are followed; None: as by the version of the firmware."""
    version: Version | None = None
    """Of the firmware; None: the newest measured."""
    jumped: dict[int, int] = field(default_factory=dict)
    stuck_at: int | None = None
    """The item at which the firmware found no way on."""

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def places(self) -> Points:
        """Where each item lies, (n, 3) [m]; NaN for what it leaves open. A height over terrain counts as over home."""
        items, home = self.items, self.frame.home
        rows = [(item.latitude_deg, item.longitude_deg, item.height(home)) for item in items]
        latitude, longitude, up = np.array(rows).reshape(-1, 3).T
        flat = self.frame.to_local(latitude, longitude, np.full(len(items), home.altitude)).reshape(-1, 3)
        placed = np.array([item.has_position for item in items], dtype=bool) & np.isfinite(flat).all(axis=1)
        kept = [i.is_as_high_as_now(self.autopilot) for i in items]
        up = np.where(np.array(kept, dtype=bool) | ~np.isfinite(up), math.nan, up)
        return np.column_stack([np.where(placed[:, None], flat[:, :2], math.nan), up])

    @cached_property
    def _numbers(self) -> list[list[float]]:
        """The same, quicker to look up one by one."""
        return self.places.tolist()  # type: ignore[no-any-return]

    def leaves_open(self, index: int) -> bool:
        """Whether item `index` names no place, or no height."""
        return any(map(math.isnan, self._numbers[index]))

    def place(self, index: int, here: Place) -> Place:
        """Where item `index` is; what it leaves open is that of `here`."""
        east, north, up = self._numbers[index]
        return (
            here[0] if math.isnan(east) else east,
            here[1] if math.isnan(north) else north,
            here[2] if math.isnan(up) else up,
        )

    def place_of(self, item: Item) -> Place:
        """Where the latitude, longitude and altitude of an item are."""
        home = self.frame.home
        flat = self.frame.local(Geodetic(item.latitude_deg, item.longitude_deg, home.altitude))
        return float(flat[0]), float(flat[1]), item.height(home)

    def after(self, index: int, taking: bool = True) -> int | None:
        """The item that follows `index` once jumps are followed; `taking` a jump counts it, looking ahead does not."""
        index += 1
        for jumps in range(self.habits.at_once + 1):
            if index >= len(self.items):
                return None
            if self.items[index].command not in JUMPS:
                return index
            target = self._targets[index]
            if target is None or jumps == self.habits.at_once:
                break
            index = target if self._jumps(index, taking) else index + 1
        if taking:
            self.stuck_at = index
        return None

    @cached_property
    def habits(self) -> JumpProfile:
        """How jumps are followed."""
        return self.jumping or self.autopilot.firmware(self.version).jumps

    @cached_property
    def _targets(self) -> dict[int, int | None]:
        jumps = (n for n, item in enumerate(self.items) if item.command in JUMPS)
        return {n: jump_target(self.items, n, self.first) for n in jumps}

    def _jumps(self, index: int, taking: bool) -> bool:
        """Whether the jump at `index` is taken now."""
        times, has_counter = repeats(self.items[index]), index in self.jumped or len(self.jumped) < self.habits.most
        done = self.jumped.get(index, 0) if has_counter else math.inf
        jumps = times == math.inf or done < times
        if has_counter:
            over = 0 if self.habits.resets else done
            self.jumped[index] = int((done + 1 if jumps else over) if taking else done)
        return jumps

    def advance(self, index: int) -> tuple[list[int], int | None]:
        """What is done in passing after item `index`, in its order, and the item that moves the vehicle then.

        Counts the jumps that are taken.
        """
        passed: list[int] = []
        at = self.after(index)
        while at is not None and not self._moves(at):
            if len(passed) == MOST_ACTIONS:
                self.stuck_at, at = at, None
                break
            passed.append(at)
            at = self.after(at)
        if not passed or not self.habits.queues_actions:
            return passed, at
        done = passed[:1]
        action = self.after(done[0], taking=False) if at is not None else None
        while action is not None and action not in done and not self._moves(action):
            done.append(action)
            action = self.after(action, taking=False)
        return done, at

    def followed(self) -> tuple[Steps, dict[int, int]]:
        """What is done in passing and then flown to, step by step; and whither it flies on by mistake, by item."""
        steps: Steps = []
        elsewhere: dict[int, int] = {}
        at: int | None = -1
        while at is not None and len(steps) < MOST_STEPS:
            if at >= 0 and (instead := self.mistaken(at)) is not None:
                elsewhere.setdefault(at, instead)
            steps.append(self.advance(at))
            at = steps[-1][1]
        return steps, elsewhere

    def mistaken(self, index: int) -> int | None:
        """The item to which it flies on from item `index` by mistake, instead of the one that follows; else None.

        ArduCopter keeps the leg that it laid while it looked ahead, wherever the next item lies.
        """
        if not self.habits.looks_past_jumps or not is_passed(self.items[index]):
            return None
        tried = (self.after(n, taking=False) for n in range(index, len(self.items) - 1))
        ahead = next((n for n in tried if n is None or self._moves(n)), None)
        follows = next((n for n in self.ahead(index) if self._moves(n)), None)
        flies_on = self.autopilot.guidance.flown_on_into
        wrong = ahead is not None and ahead != follows and self.items[ahead].command in flies_on
        return ahead if wrong else None

    def _moves(self, index: int) -> bool:
        return self.items[index].command <= LAST_NAV or self.items[index].command in ALSO_MOVE

    def ahead(self, index: int) -> Iterator[int]:
        """The items that will come up after `index`, as many as there are items."""
        for _ in self.items:
            following = self.after(index, taking=False)
            if following is None:
                return
            yield (index := following)

    def onward(self, index: int) -> int | None:
        """The item that is flown on to without stopping at item `index`, jumps followed."""
        return onward(self.items, index, self.autopilot, self.ahead(index))

    def shaped_by(self, index: int) -> int | None:
        """The item that gives a spline to item `index` its end, jumps followed."""
        return next_navigated(self.items, index, self.autopilot, self.ahead(index))


def program_of(mission: Mission, items: tuple[Item, ...]) -> Program:
    """Items of the mission, in the way in which its firmware and parameters follow jumps."""
    habits = mission.autopilot.firmware(mission.firmware_version).jumps
    name, bit = habits.kept_by
    options = mission.autopilot.book.by_old_names(mission.parameters).get(name, 0.0)
    habits = replace(habits, resets=habits.resets and not int(options) >> bit & 1)
    frame, version = LocalFrame(mission.home), mission.firmware_version
    return Program(items, frame, mission.autopilot, jumping=habits, version=version)
