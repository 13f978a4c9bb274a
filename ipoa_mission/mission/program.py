"""Read mission items: their order, their places, and the next item of each.

Places are east, north, up of home [m], over a flat Earth. ArduCopter replaces latitude and longitude 0, and altitude 0,
by those of the item before. PX4 flies to the values; a null place of its take-off and landing is "here".
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import FLOWN_TO, LAST_NAV, TAKEOFF_AND_LAND, Command, Frame, plain_frame
from ipoa_mission.autopilot.guidance_profile import JumpProfile
from ipoa_mission.autopilot.version import Version
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Place, Points
from ipoa_mission.mission.items import Item, Mission, Numbered, item_of, numbered_items

Steps: TypeAlias = list[tuple[list[int], int | None]]  # items done in passing, and the next place
MAX_ACTIONS = 255  # in passing, of ArduPilot


def jump_target(items: Sequence[Item], index: int, first: int = 1) -> int | None:
    """Return the target of the jump at `index`, the first of two with its tag; DO_JUMP counts from `first`."""
    named = items[index].params[0]
    if not math.isfinite(named):
        return None
    if items[index].command == Command.DO_JUMP_TAG:
        return next(items_tagged(items, named), None)
    target = int(named) - first
    return target if 0 <= target < len(items) else None


def items_tagged(items: Sequence[Item], tag: float) -> Iterator[int]:
    tags = (n for n, item in enumerate(items) if item.command == Command.JUMP_TAG)
    return (n for n in tags if math.isfinite(items[n].params[0]) and int(items[n].params[0]) == int(tag))


def repeats(item: Item) -> float:
    return math.inf if not item.params[1] >= 0 else int(item.params[1])


def led_to(items: Sequence[Item], index: int, moving: frozenset[int]) -> Iterator[int]:
    """Yield the items with a `moving` command that a jump may lead to, through other jumps too."""
    ahead = [jump_target(items, index)] if repeats(items[index]) else []
    visited = {index}
    while ahead:
        at = ahead.pop()
        if at is None or at in visited or at >= len(items):
            continue
        visited.add(at)
        if items[at].command in moving:
            yield at
            continue
        ahead.append(at + 1)
        if items[at].is_jump and repeats(items[at]):
            ahead.append(jump_target(items, at))


def as_flown(mission: Mission) -> Mission:
    """Return the mission with a place and a height in each item that is flown to."""
    latitude, longitude = mission.home.latitude_deg, mission.home.longitude_deg
    altitude = 0.0
    frame = int(Frame.GLOBAL_RELATIVE_ALT)
    items: list[Item] = []
    for item in mission.items:
        if item.is_as_high_as_now(mission.autopilot):
            item = replace(item, altitude=altitude, frame=frame)
        if item.is_here(mission.autopilot) and item.command not in TAKEOFF_AND_LAND | {Command.NAV_PAYLOAD_PLACE}:
            item = replace(item, latitude_deg=latitude, longitude_deg=longitude)
        items.append(item)
        if item.has_position and item.command != Command.NAV_TAKEOFF:
            latitude, longitude = item.latitude_deg, item.longitude_deg
        keeps_height = item.command == Command.NAV_LAND or item.frame == Frame.MISSION
        if item.command in FLOWN_TO and math.isfinite(item.altitude) and not keeps_height:
            altitude = item.altitude
            frame = plain_frame(item.frame)
    return replace(mission, items=tuple(items))


def is_passed(item: Item) -> bool:
    return item.command == Command.NAV_ARC_WAYPOINT or (item.is_waypoint and item.params[0] < 1)


def onward(items: Sequence[Item], n: int, autopilot: Autopilot, later: Iterable[int] | None = None) -> int | None:
    """Return the item that the vehicle flies on to from item n; None: it stops."""
    guidance = autopilot.guidance
    next_index = next_navigated(items, n, autopilot, later)
    if next_index is None or items[next_index].command not in guidance.passes_before:
        return None
    if guidance.stops_at_terrain and items[next_index].is_over_terrain != items[n].is_over_terrain:
        return None
    return next_index


def next_navigated(
    items: Sequence[Item], n: int, autopilot: Autopilot, later: Iterable[int] | None = None
) -> int | None:
    """Return the item looked ahead to from item n; None for a hold.

    `later`: the following items in the order of flight, if not of numbers.
    """
    if autopilot.guidance.stops_to_hold and not is_passed(items[n]):
        return None
    following = range(n + 1, len(items)) if later is None else later
    return next((index for index in following if items[index].moves), None)


def stays_at(mission: Mission) -> list[Numbered]:
    """Return the items at which the vehicle waits for an operator."""
    listed = numbered_items(mission)
    last = max((at.seq for at in listed if at.item.command <= LAST_NAV), default=0)
    ignored = not mission.firmware.keeps_autocontinue
    without_end = (at for at in listed if at.item.command == Command.NAV_LOITER_UNLIM and at.seq < last)
    held = (at for at in listed if not (at.item.autocontinue or at.item.is_jump or ignored))
    return [*without_end, *held]


def behind_landing(mission: Mission) -> tuple[Numbered, Numbered] | None:
    """Return the landing that ends the mission, and the item behind it in the order of flight."""
    flies_on = mission.autopilot.command_effects.flies_on
    steps, _ = program_of(mission, mission.items).followed()
    flown = (item_of(mission, n + 1) for _, n in steps if n is not None)
    moving = [at for at in flown if at.item.command <= LAST_NAV and at.item.command != Command.NAV_DELAY]
    for at, after in pairwise(moving):
        if not flies_on(at.item.command, after.item.is_takeoff, mission.complete_parameters):
            return at, after
    return None


@dataclass
class Program:
    """Items with the count of each jump; indices from 0.

    `first` is the number of the first item for a jump: 1 in a mission file, 0 in the store of PX4.
    """

    items: tuple[Item, ...]
    frame: LocalFrame
    autopilot: Autopilot
    first: int = 1
    jumping: JumpProfile | None = None
    """The rules of jumps; None: those of the firmware's version."""
    version: Version | None = None
    """The firmware's version; None: the newest measured."""
    jumped: dict[int, int] = field(default_factory=dict)
    ground_at_home: float = 0.0
    """Above home; heights over terrain count from it [m]."""
    stuck_at: int | None = None
    """The item from which the firmware found no next item."""

    @cached_property
    def places(self) -> Points:
        items = self.items
        home = self.frame.home
        rows = [(item.latitude_deg, item.longitude_deg, self._height(item)) for item in items]
        latitude, longitude, up = np.array(rows).reshape(-1, 3).T
        flat = self.frame.to_local(latitude, longitude, np.full(len(items), home.altitude)).reshape(-1, 3)
        placed = np.array([item.has_position for item in items], dtype=bool) & np.isfinite(flat).all(axis=1)
        kept = np.array([item.is_as_high_as_now(self.autopilot) for item in items], dtype=bool)
        up = np.where(kept | ~np.isfinite(up), math.nan, up)
        return np.column_stack([np.where(placed[:, None], flat[:, :2], math.nan), up])

    @cached_property
    def _numbers(self) -> list[list[float]]:
        return self.places.tolist()  # type: ignore[no-any-return]

    def leaves_open(self, index: int) -> bool:
        return any(map(math.isnan, self._numbers[index]))

    def place(self, index: int, here: Place) -> Place:
        east, north, up = (now if math.isnan(x) else x for x, now in zip(self._numbers[index], here, strict=True))
        return east, north, up

    def place_of(self, item: Item) -> Place:
        home = self.frame.home
        flat = self.frame.local(Geodetic(item.latitude_deg, item.longitude_deg, home.altitude))
        return float(flat[0]), float(flat[1]), self._height(item)

    def _height(self, item: Item) -> float:
        return item.height(self.frame.home) + (self.ground_at_home if item.is_over_terrain else 0.0)

    def after(self, index: int, taking: bool = True) -> int | None:
        """Return the item after `index`, jumps followed; `taking` counts them."""
        index += 1
        for jumps in range(self.jump_profile.at_once + 1):
            if index >= len(self.items):
                return None
            if not self.items[index].is_jump:
                return index
            target = self._targets[index]
            if target is None or jumps == self.jump_profile.at_once:
                break
            index = target if self._jumps(index, taking) else index + 1
        if taking:
            self.stuck_at = index
        return None

    @cached_property
    def jump_profile(self) -> JumpProfile:
        return self.jumping or self.autopilot.firmware(self.version).jumps

    @cached_property
    def _targets(self) -> dict[int, int | None]:
        jumps = (n for n, item in enumerate(self.items) if item.is_jump)
        return {n: jump_target(self.items, n, self.first) for n in jumps}

    def _jumps(self, index: int, taking: bool) -> bool:
        times = repeats(self.items[index])
        has_counter = index in self.jumped or len(self.jumped) < self.jump_profile.most
        if not has_counter:
            return times == math.inf
        jumps = self.jumped.setdefault(index, 0) < times
        if taking and jumps:
            self.jumped[index] += 1
        elif taking and self.jump_profile.resets:
            self.jumped[index] = 0
        return jumps

    def advance(self, index: int) -> tuple[list[int], int | None]:
        """Return the items done in passing after `index`, and the next flown one."""
        passed: list[int] = []
        at = self.after(index)
        while at is not None and not self.items[at].moves:
            if len(passed) == MAX_ACTIONS:
                self.stuck_at = at
                at = None
                break
            passed.append(at)
            at = self.after(at)
        if not passed or not self.jump_profile.queues_actions:
            return passed, at
        done = passed[:1]
        action = self.after(done[0], taking=False) if at is not None else None
        while action is not None and action not in done and not self.items[action].moves:
            done.append(action)
            action = self.after(action, taking=False)
        return done, at

    def followed(self) -> tuple[Steps, dict[int, int]]:
        """Return the items passed and the next one by step, and wrong next items."""
        steps = Steps()
        elsewhere = dict[int, int]()
        at: int | None = -1
        while at is not None and len(steps) < 5_000:
            instead = self.mistaken(at) if at >= 0 else None
            if instead is not None:
                elsewhere.setdefault(at, instead)
            steps.append(self.advance(at))
            at = steps[-1][1]
        return steps, elsewhere

    def mistaken(self, index: int) -> int | None:
        """Return the item flown to instead of the next one, by ArduCopter's look-ahead; None if correct."""
        if not self.jump_profile.looks_past_jumps or not is_passed(self.items[index]):
            return None
        tried = (self.after(n, taking=False) for n in range(index, len(self.items) - 1))
        ahead = next((n for n in tried if n is None or self.items[n].moves), None)
        follows = next((n for n in self.ahead(index) if self.items[n].moves), None)
        flies_on = self.autopilot.guidance.passes_before
        wrong = ahead is not None and ahead != follows and self.items[ahead].command in flies_on
        return ahead if wrong else None

    def ahead(self, index: int) -> Iterator[int]:
        next_index = self.after(index, taking=False)
        for _ in self.items:
            if next_index is None:
                return
            yield next_index
            next_index = self.after(next_index, taking=False)

    def onward(self, index: int) -> int | None:
        return onward(self.items, index, self.autopilot, self.ahead(index))

    def shaped_by(self, index: int) -> int | None:
        return next_navigated(self.items, index, self.autopilot, self.ahead(index))


def program_of(mission: Mission, items: tuple[Item, ...]) -> Program:
    rules = mission.firmware.jumps
    if mission.autopilot.parameter_table.has_bit(mission.parameters, rules.kept_by):
        rules = replace(rules, resets=False)
    return Program(items, mission.frame, mission.autopilot, jumping=rules, version=mission.firmware_version)
