"""Unroll a mission into visits, its jumps followed; find how a return from them is flown, and where it is unknown."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, takewhile
from typing import NamedTuple

from ipoa_mission.autopilot.commands import FLOWN_TO, LAST_NAV, Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import HOME, MissionLanding, ReturnBy, ReturnOrder, ReturnRoute
from ipoa_mission.errors import BadInput, EndlessFlight, NotModeled
from ipoa_mission.forecast.itinerary.copter_curves import WITH_PLACE, circle_radius, entry_is_unsure, reads_as_here
from ipoa_mission.forecast.itinerary.flown_legs import HORIZONTAL_SPEEDS
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Place, Vector
from ipoa_mission.ground import FLAT_GROUND, Ground
from ipoa_mission.mission.items import LEFT_OUT, Item, Mission, Numbered
from ipoa_mission.mission.program import Program, as_flown, is_passed, jump_target, next_navigated, program_of, repeats

# Above LAST_NAV, but not instant.
UNTIMED = frozenset({Command.NAV_SCRIPT_TIME, Command.NAV_ATTITUDE_TIME, Command.CONDITION_GATE})
LONGEST_HOLD = 86_400.0  # [s], of all holds of a flight; a guard: the models compute each step of a hold
# They delay the commands after them; the models run these at once.
CONDITIONS = frozenset({Command.CONDITION_DELAY, Command.CONDITION_DISTANCE})
MAX_TURN_DEG = 150.0  # limit of the forecast's accuracy: docs/lab/flight-time.md
NO_PLACE = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class Itinerary:
    """A mission's items in the order flown, numbered as in the mission; `over_terrain`: numbers of such items."""

    mission: Mission
    visits: tuple[Numbered, ...]
    program: Program
    over_terrain: tuple[int, ...]
    ground: Ground

    @cached_property
    def start_height(self) -> float | None:
        """Return the first height [m] of a mission without a take-off."""
        for (_, item), place in zip(self.visits, self.program.places, strict=True):
            if item.command <= LAST_NAV and item.command != Command.NAV_DELAY:
                return None if item.is_takeoff or math.isnan(place[0]) else max(0.0, float(place[2]))
        return None

    @cached_property
    def parameters(self) -> Parameters:
        """Parameters of the mission over the version's defaults, under the names of `parameter_table`."""
        return self.mission.autopilot.known_parameters(self.mission.parameters, self.mission.firmware_version)

    @cached_property
    def rally(self) -> tuple[Place, ...]:
        return rally_places(self.mission)

    def goal_of_return(self, here: Place) -> Place:
        rally = self.route_of_return(here).rally
        return HOME if rally is None else self.rally[rally]

    def route_of_return(self, here: Place, landing: MissionLanding | None = None) -> ReturnRoute:
        order = ReturnOrder(here, self.rally, landing, self.mission.firmware_version)
        return self.mission.autopilot.return_route(self.parameters, order)

    def _visited_landing(self, n: int, here: Place) -> MissionLanding | None:
        lands = next((k for k, visit in enumerate(self.visits) if visit.item.command == Command.NAV_LAND), None)
        return None if lands is None else MissionLanding(self.program.place(lands, here), 0, n)

    @property
    def returns_by(self) -> ReturnBy:
        """Return how RTL returns when ordered over the mission's landing."""
        landing = self._visited_landing(0, HOME)
        return self.route_of_return(HOME if landing is None else landing.place, landing).by

    def places_of_return(self, n: int, here: Place) -> tuple[Place, ...] | None:
        """Return a return's places along the mission; None: straight. Raise MissionError for a landing of its own."""
        by = self.route_of_return(here, self._visited_landing(n, here)).by
        if by is ReturnBy.DIRECT:
            return None
        if by is not ReturnBy.MISSION_REVERSED:
            raise NotModeled(f"the time of returns {by} is not modeled")
        visited = [k for k, visit in enumerate(self.visits[:n]) if visit.item.command in FLOWN_TO]
        places = [self.program.place(k, here) for k in reversed(visited)] or [here]
        return (*places, (0.0, 0.0, places[-1][2]))


def itinerary(mission: Mission, ground: Ground = FLAT_GROUND, ground_at_home: float = 0.0) -> Itinerary:
    """Unroll the mission's jumps and convert its items to meters around home.

    Heights over terrain count from `ground_at_home` [m above home]; `over_terrain` lists them.

    Raises:
        BadInput: a jump leads nowhere or never ends, or the flight holds for more than a day.
    """
    order = _unrolled(mission)
    _expect_short_holds(mission, order)
    items = as_flown(replace(mission, items=tuple(mission.items[n] for n in order))).items
    visits = tuple(Numbered(n + 1, item) for n, item in zip(order, items, strict=True))
    over_terrain = sorted({seq for seq, item in visits if item.is_over_terrain and item.has_position})
    version = mission.firmware_version
    program = Program(items, mission.frame, mission.autopilot, version=version, ground_at_home=ground_at_home)
    return Itinerary(mission, visits, program, tuple(over_terrain), ground)


def _expect_short_holds(mission: Mission, order: Sequence[int]) -> None:
    wait = mission.autopilot.parameter_table.by_meaning.get("wait before landing")
    holds = [(f"item {n + 1}: param1", mission.items[n].hold_s) for n in order]
    if wait is not None:
        holds.insert(0, (wait.name, wait.si(mission.complete_parameters[wait.name])))
    for (place, _), held_s in zip(holds, accumulate(hold_s for _, hold_s in holds), strict=True):
        if held_s > LONGEST_HOLD:
            words = f"expected a flight that holds for at most {LONGEST_HOLD:.0f} s in all, not {held_s:g} s"
            raise EndlessFlight(words, place=place)


def rally_places(mission: Mission) -> tuple[Place, ...]:
    frame, altitude = mission.frame, mission.home.altitude
    places = (frame.local(Geodetic(at.latitude_deg, at.longitude_deg, altitude)) for at in mission.rally)
    return tuple((float(p[0]), float(p[1]), at.altitude) for p, at in zip(places, mission.rally, strict=True))


def _unrolled(mission: Mission) -> list[int]:
    count = len(mission.items)
    for n, item in enumerate(mission.items):
        if item.is_jump and jump_target(mission.items, n) is None:
            expected = "the tag of a JUMP_TAG" if item.command == Command.DO_JUMP_TAG else f"an item from 1 to {count}"
            raise BadInput(f"expected {expected} to jump to, not {item.params[0]:g}", place=f"item {n + 1}: param1")
        if item.is_jump and repeats(item) == math.inf:
            raise EndlessFlight("the jump never ends, so the flight has no time", place=f"item {n + 1}: param2")
    program = program_of(mission, mission.items)
    order = list[int]()
    most = 20_000  # ArduPilot's limit of a mission's size
    index: int | None = -1
    while index is not None:
        if len(order) > most:
            raise EndlessFlight(f"the mission's jumps make more than {most} visits", place=f"item {index + 1}")
        passed, index = program.advance(index)
        order += passed if index is None else [*passed, index]
    if program.stuck_at is not None:
        raise EndlessFlight(f"{mission.autopilot.model} finds no next item", place=f"item {program.stuck_at + 1}")
    return order


class Unknown(NamedTuple):
    seq: int
    why: str
    hint: str
    code: str = "way-unknown"


def find_unknown(mission: Mission) -> Iterator[Unknown]:
    autopilot, items = mission.autopilot, as_flown(mission).items
    program = Program(items, mission.frame, autopilot, version=mission.firmware_version)
    circles = Command.NAV_LOITER_TURNS in autopilot.command_effects.flown
    splines = autopilot.guidance.flies_splines
    yield from past_jumps(mission)
    here: Place | None = None
    braking = _braking_lengths(mission) if splines else []
    for n, item in enumerate(items):
        if item is not LEFT_OUT and (why := autopilot.command_effects.why_unknown(item.command, item.params)):
            yield Unknown(n + 1, why, "leave it out, or fly it without a forecast (--anyway)")
        elif item.command in CONDITIONS and item is not LEFT_OUT and _delays_speed(items, n):
            why = "it delays a change of speed, which is left out if the next place is reached before"
            yield Unknown(n + 1, why, "change the speed without a condition")
        place = program.place(n, here or NO_PLACE)
        before = here
        if circles and item.command == Command.NAV_LOITER_TURNS:
            if circle_radius(item) > 150.0:
                why = "circles beyond 150 m are flown up to 1.0 m off their forecast"
                yield Unknown(n + 1, why, "fly it as waypoints")
            if here is not None and entry_is_unsure(here, place, circle_radius(item)):
                why = "it begins near the circle's center: the side of its entry is random"
                yield Unknown(n + 1, why, "begin it farther from the center")
            here = None
        elif item.is_takeoff:
            here = (*(here or HOME)[:2], place[2])
        elif item.command in FLOWN_TO:
            here = place
        if splines and item.command == Command.NAV_SPLINE_WAYPOINT:
            yield from _after_a_spline(program, n)
            length = math.inf if before is None else math.dist(before, place)
            if length < 0.95 * braking[n] and _stops(program, n, place):
                why = f"it stops on a spline of less than {braking[n]:.1f} m: it flies up to 2.0 m beyond its forecast"
                yield Unknown(n + 1, why, "stop at a waypoint, fly slower, or leave the spline more length")
            if before is not None and _turns_back(program, n, before, place):
                why = f"it turns by more than {MAX_TURN_DEG:g} degrees: flown up to 1.6 m off its forecast"
                yield Unknown(n + 1, why, "turn at two waypoints")
        elif item.is_waypoint and (next_index := program.onward(n)) is not None:
            yield from _payload_elsewhere(mission, program, n, next_index)


def _delays_speed(items: Sequence[Item], n: int) -> bool:
    actions = takewhile(lambda item: item.command > LAST_NAV, items[n:])
    return any(item.command == Command.DO_CHANGE_SPEED for item in actions)


def past_jumps(mission: Mission) -> Iterator[Unknown]:
    items = mission.items
    if not any(item.is_jump for item in items):
        return
    for n, instead in sorted(program_of(mission, items).followed()[1].items()):
        jump = next((later + 1 for later in range(n, len(items)) if items[later].is_jump), 0)
        why = (
            f"{mission.autopilot.model} flies on from here to item {instead + 1}, not to the target of the jump at "
            f"item {jump}, because that target is no place"
        )
        hint = "let DO_JUMP name the waypoint itself, or hold here for a second"
        yield Unknown(n + 1, why, hint, "jump-flown-elsewhere")


def _after_a_spline(program: Program, n: int) -> Iterator[Unknown]:
    items = program.items
    for after in {next_navigated(items, n, program.autopilot), program.shaped_by(n)} - {None}:
        assert after is not None
        if items[after].command not in WITH_PLACE and not reads_as_here(items[after]):
            name = items[after].name
            why = f"params of {name} after a spline are read as a place far away or up: it may dive into the ground"
            yield Unknown(n + 1, why, "put a waypoint between them", "never-reached")


def _braking_lengths(mission: Mission) -> list[float]:
    """Return each item's braking length on a spline [m]; 0 from a stop."""
    autopilot, items = mission.autopilot, mission.items
    table = autopilot.parameter_table
    values = mission.complete_parameters
    speed = table.meant("cruise speed", values)
    accel = table.meant("acceleration", values)
    changed = (n for n, item in enumerate(items) if item.command == Command.DO_CHANGE_SPEED)
    changes = {
        n: items[n].params[1] for n in changed if items[n].params[0] in HORIZONTAL_SPEEDS and items[n].params[1] > 0
    }
    if any(item.is_jump for item in items):
        return [max([speed, *changes.values()]) ** 2 / accel] * len(items)
    lengths = list[float]()
    is_at_rest = True
    for n, item in enumerate(items):
        speed = changes.get(n, speed)
        lengths.append(0.0 if is_at_rest else speed**2 / accel)
        if item.command in FLOWN_TO:
            is_at_rest = item.is_takeoff or not is_passed(item)
    return lengths


def _stops(program: Program, n: int, place: Place) -> bool:
    after = program.shaped_by(n)
    if after is None or program.items[after].command not in WITH_PLACE or reads_as_here(program.items[after]):
        return True
    return math.dist(program.place(after, place)[:2], place[:2]) < 0.01


def _turns_back(program: Program, n: int, before: Place, place: Place) -> bool:
    after = program.shaped_by(n)
    if after is None or program.items[after].command not in program.autopilot.guidance.passes_before:
        return False
    return turn_deg(before, place, program.place(after, place)) > MAX_TURN_DEG


def turn_deg(before: Place | Vector, at: Place | Vector, after: Place | Vector) -> float:
    """Return the turn at a place, 0 to 180; NaN where unknown."""
    east = at[0] - before[0]
    north = at[1] - before[1]
    on_east = after[0] - at[0]
    on_north = after[1] - at[1]
    return math.degrees(math.atan2(abs(east * on_north - north * on_east), east * on_east + north * on_north))


def _payload_elsewhere(mission: Mission, program: Program, n: int, next_index: int) -> Iterator[Unknown]:
    autopilot, item = mission.autopilot, program.items[next_index]
    if item.command != Command.NAV_PAYLOAD_PLACE or not item.has_position:
        return
    acceptance = autopilot.parameter_table.meant("acceptance radius", mission.complete_parameters)
    climb = abs(program.place(next_index, NO_PLACE)[2] - program.place(n, NO_PLACE)[2])
    if climb > acceptance:
        why = "it waits at this height for that of the waypoint before, and never places the payload"
        yield Unknown(next_index + 1, why, "give it the height of the waypoint before, or 0", "never-reached")
