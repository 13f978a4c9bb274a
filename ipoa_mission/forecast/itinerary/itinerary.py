"""Unroll a mission into visits, its jumps followed, and find how a return from them is flown."""

import math
from dataclasses import dataclass, field, replace

from ipoa_mission.autopilot.commands import FLOWN_TO, JUMPS, LAST_NAV, TAKEOFFS, Command, Frame, plain_frame
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import HOME, MissionLanding, ReturnBy, ReturnOrder, ReturnRoute
from ipoa_mission.errors import BadInput, EndlessFlight, NotModeled
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Place
from ipoa_mission.ground import LEVEL, Ground
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.program import Program, as_flown, jump_target, program_of, repeats

# Above LAST_NAV, but not instant.
UNTIMED = frozenset({Command.NAV_SCRIPT_TIME, Command.NAV_ATTITUDE_TIME, Command.CONDITION_GATE})
# They delay the commands after them; the models run these at once.
CONDITIONS = frozenset({Command.CONDITION_DELAY, Command.CONDITION_DISTANCE})


@dataclass(frozen=True)
class Visit:
    seq: int
    item: Item


@dataclass(frozen=True)
class Itinerary:
    visits: tuple[Visit, ...]
    program: Program
    over_terrain: tuple[int, ...]
    ground: Ground = LEVEL
    rally: tuple[Place, ...] = ()
    parameters: Parameters = field(default_factory=dict)

    def goal_of_return(self, here: Place) -> Place:
        rally = self._route_of_return(here).rally
        return HOME if rally is None else self.rally[rally]

    def _route_of_return(self, here: Place, landing: MissionLanding | None = None) -> ReturnRoute:
        program = self.program
        return program.autopilot.return_route(self.parameters, ReturnOrder(here, self.rally, landing, program.version))

    def _visited_landing(self, n: int, here: Place) -> MissionLanding | None:
        lands = next((k for k, visit in enumerate(self.visits) if visit.item.command == Command.NAV_LAND), None)
        return None if lands is None else MissionLanding(self.program.place(lands, here), 0, n)

    @property
    def returns_by(self) -> ReturnBy:
        """Return how RTL returns when ordered over the mission's landing."""
        landing = self._visited_landing(0, HOME)
        return self._route_of_return(HOME if landing is None else landing.place, landing).by

    def places_of_return(self, n: int, here: Place) -> tuple[Place, ...] | None:
        """Return the places of a return back along the mission to over home; None: straight.

        Raises:
            MissionError: it returns to a landing of its own, which is not modeled.
        """
        by = self._route_of_return(here, self._visited_landing(n, here)).by
        if by is ReturnBy.DIRECT:
            return None
        if by is not ReturnBy.MISSION_REVERSED:
            raise NotModeled(f"the time of returns {by} is not modeled")
        visited = [k for k, visit in enumerate(self.visits[:n]) if visit.item.command in FLOWN_TO]
        places = [self.program.place(k, here) for k in reversed(visited)] or [here]
        return (*places, (0.0, 0.0, places[-1][2]))


def itinerary(mission: Mission, ground: Ground = LEVEL) -> Itinerary:
    """Unroll the mission's jumps and convert its items to meters around home.

    Heights over terrain count as over home; `over_terrain` lists them.

    Raises:
        BadInput: a jump leads nowhere or never ends.
    """
    order = _unrolled(mission)
    items = as_flown(replace(mission, items=tuple(mission.items[n] for n in order))).items
    over_terrain = (
        n + 1
        for n, item in sorted(dict(zip(order, items, strict=True)).items())
        if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT and item.has_position
    )
    visits = tuple(Visit(n + 1, item) for n, item in zip(order, items, strict=True))
    version = mission.firmware_version
    program = Program(items, LocalFrame(mission.home), mission.autopilot, version=version)
    by_names = mission.autopilot.known_parameters(mission.parameters, version)
    return Itinerary(visits, program, tuple(over_terrain), ground, rally_places(mission), by_names)


def rally_places(mission: Mission) -> tuple[Place, ...]:
    if not mission.rally:
        return ()
    frame, home = LocalFrame(mission.home), mission.home
    places = (frame.local(Geodetic(at.latitude_deg, at.longitude_deg, home.altitude)) for at in mission.rally)
    return tuple((float(p[0]), float(p[1]), at.altitude) for p, at in zip(places, mission.rally, strict=True))


def flying_already(route: Itinerary) -> float | None:
    """Return the first height [m] of a mission without a take-off."""
    for visit, place in zip(route.visits, route.program.places, strict=True):
        command = visit.item.command
        if command <= LAST_NAV and command != Command.NAV_DELAY:
            return None if command in TAKEOFFS or math.isnan(place[0]) else max(0.0, float(place[2]))
    return None


def _unrolled(mission: Mission) -> list[int]:
    count = len(mission.items)
    for n, item in enumerate(mission.items):
        if item.command in JUMPS and jump_target(mission.items, n) is None:
            asked = item.params[0]
            expected = "the tag of a JUMP_TAG" if item.command == Command.DO_JUMP_TAG else f"an item from 1 to {count}"
            raise BadInput(f"expected {expected} to jump to, not {asked:g}", place=f"item {n + 1}: param1")
        if item.command in JUMPS and repeats(item) == math.inf:
            raise EndlessFlight("the jump never ends, so the flight has no time", place=f"item {n + 1}: param2")
    program, order = program_of(mission, mission.items), list[int]()
    most = 20_000  # ArduPilot's limit of a mission's size
    at: int | None = -1
    while at is not None:
        if len(order) > most:
            raise EndlessFlight(f"the mission's jumps make more than {most} visits", place=f"item {at + 1}")
        passed, at = program.advance(at)
        order += passed if at is None else [*passed, at]
    if program.stuck_at is not None:
        raise EndlessFlight(f"{mission.autopilot.model} finds no next item", place=f"item {program.stuck_at + 1}")
    return order
