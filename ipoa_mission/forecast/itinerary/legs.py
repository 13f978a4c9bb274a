"""The legs that a mission is flown in: the climb after take-off, the legs between waypoints, the way home.

Legs are straight, but to an ArduPilot spline or arc waypoint: those are flown along curves, which chords stand for.

Points are local (east, north, up); heights above home and AMSL become `up` with the Earth's curvature, heights above
terrain by the ground that is handed in. Loops are not unrolled: each jump adds the leg that it makes.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.itinerary.copter_arc import arc_chords, is_arc, turn_of
from ipoa_mission.forecast.itinerary.copter_spline import spline_chords, spline_tangents
from ipoa_mission.forecast.itinerary.jumps import led_to
from ipoa_mission.forecast.itinerary.program import Place, as_flown, onward
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.commands import FLOWN_TO, JUMPS, Command, Frame, plain_frame
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.vehicles.returning import ReturnBy
from ipoa_mission.world.frame import Geodetic, LocalFrame
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.terrain import Flat

CHORD = 0.005  # [m] by which a curve may leave its chords
FOLLOWING_STEP = 5.0  # [m] between the points of a leg that follows the terrain
SHORTEST_CURVE = 1e-3  # [m] below which the way to a spline waypoint is no curve
MOVING = FLOWN_TO | {Command.NAV_RETURN_TO_LAUNCH}
NEARBY = 0.5  # [m] a take-off this near to home is one from home


class Phase(StrEnum):
    """What a leg is for."""

    TAKEOFF = "take-off"
    CRUISE = "cruise"
    RETURN = "return"
    LANDING = "landing"


@dataclass(frozen=True, eq=False)
class Leg:
    """The way to item `seq` (numbered as in mission files): points (k, 3) with straight lines between them [m].

    `alternative`: flown at times only: after a jump, or to a rally point. `over_terrain`: it keeps its height over the
    ground. `stray`: how far the way may be from the lines [m]. `jumped_from`: the item before a jump; -1: no jump.
    """

    seq: int
    phase: Phase
    points: Points
    alternative: bool = False
    over_terrain: bool = False
    stray: float = 0.0
    jumped_from: int = -1


def flown_legs(mission: Mission, frame: LocalFrame, ground: Ground | None = None) -> tuple[Leg, ...]:
    """The legs of a mission in the order of its items, from home on the ground to the ground.

    The mission's parameters say how high it returns. Without `ground` the ground is as high as home. Items with wrong
    positions are the business of `check_positions`; here they are left out.
    """
    return tuple(_LegBuilder(as_flown(mission), frame, ground).legs())


def return_ways(mission: Mission, frame: LocalFrame, places: Points) -> NDArray[np.float64]:
    """On which ways the vehicle returns from places (n, 3): them, over them, over each goal, (goals, n, 3, 3) [m]."""
    return np.array([ways for _, ways in _LegBuilder(as_flown(mission), frame, None).return_ways(places)])


def join(legs: Sequence[Leg]) -> tuple[Points, float]:
    """Legs that follow each other as one way: its points, and how far the flight may be from the lines [m]."""
    points = np.vstack([legs[0].points, *(leg.points[1:] for leg in legs[1:])])
    return points, max(leg.stray for leg in legs)


def item_places(mission: Mission, frame: LocalFrame, ground: Ground) -> list[Vector | None]:
    """Where each item lies, (3,) [m]; None if it names no place or no height."""
    rows = [
        (item.latitude_deg, item.longitude_deg, 0.0 if _follows(item) else mission.altitude_above_home(item))
        if item.has_position and math.isfinite(item.altitude)
        else (math.nan,) * 3
        for item in mission.items
    ]
    latitude, longitude, height = np.array(rows).reshape(-1, 3).T
    named = np.flatnonzero(~np.isnan(height))
    places: list[Vector | None] = [None] * len(rows)
    if len(named):
        local = frame.to_local(latitude[named], longitude[named], mission.home.altitude + height[named])
        for n, place in zip(named.tolist(), local, strict=True):
            if _follows(item := mission.items[n]):
                place[2] = ground(place[None, :])[0] + item.altitude
            places[n] = place
    return places


class _LegBuilder:
    """Where the vehicle is, item after item."""

    def __init__(self, mission: Mission, frame: LocalFrame, ground: Ground | None) -> None:
        self.mission, self.frame = mission, frame
        self.home = frame.local(mission.home)
        self.ground = ground or Ground(Flat(float(self.home[2])))
        self.places = item_places(mission, frame, self.ground)
        known = mission.autopilot.known_parameters(mission.parameters, mission.firmware_version)
        self.parameters = mission.autopilot.book.complete(known)
        self.at = self.home
        self.last = 0
        """The last item that moved it."""
        self.flown_in: Vector | None = None
        """Along what the vehicle arrived where it is, if it flies on without a stop, (3,) [m]."""

    def legs(self) -> Iterator[Leg]:
        for seq, item in enumerate(self.mission.items, start=1):
            match item.command:
                case Command.NAV_TAKEOFF | Command.NAV_VTOL_TAKEOFF:
                    yield from self._takeoff(seq, item)
                case Command.NAV_LAND | Command.NAV_VTOL_LAND:
                    yield from self._landing(seq, item)
                case Command.NAV_PAYLOAD_PLACE:
                    height = float(self.at[2])
                    yield from self._landing(seq, item)
                    yield self._vertical(seq, Phase.LANDING, height)
                case Command.NAV_RETURN_TO_LAUNCH:
                    yield from self.returns(seq)
                case command if command in JUMPS:
                    yield from self._jump(seq)
                case command if command in FLOWN_TO and (target := self.places[seq - 1]) is not None:
                    yield self._onward(seq, item, target)
            if item.command in MOVING:
                self.last = seq

    def _onward(self, seq: int, item: Item, target: Vector) -> Leg:
        """The leg to an item, straight or curved; the next one may begin with its direction."""
        origin, following = self.at, onward(self.mission.items, seq - 1, self.mission.autopilot)
        is_curve = item.command == Command.NAV_SPLINE_WAYPOINT and self.mission.autopilot.guidance.flies_splines
        if is_curve and not _follows(item) and np.linalg.norm(target - origin) > SHORTEST_CURVE:
            leg, arriving = self._curve(seq, target, following)
        elif is_arc(triple(origin), triple(target), turn := turn_of(item)) and not _follows(item):
            points = arc_chords(triple(origin), triple(target), turn, CHORD)
            self.at = target
            leg, arriving = Leg(seq, Phase.CRUISE, points, stray=CHORD), target - origin
        else:
            leg, arriving = self._to(seq, target, _follows(item)), target - origin
        self.flown_in = None if following is None else arriving
        return leg

    def _curve(self, seq: int, target: Vector, following: int | None) -> tuple[Leg, Vector]:
        after = None
        if following is not None and (place := self.places[following]) is not None:
            after = (triple(place), self.mission.items[following].command == Command.NAV_SPLINE_WAYPOINT)
        begin = None if self.flown_in is None else triple(self.flown_in)
        tangents = spline_tangents(triple(self.at), triple(target), begin, after)
        points = spline_chords(triple(self.at), triple(target), tangents, CHORD)
        self.at = target
        return Leg(seq, Phase.CRUISE, points, stray=CHORD), np.array(tangents[1])

    def _to(self, seq: int, target: Vector, follow_terrain: bool) -> Leg:
        points = np.array([self.at, target])
        self.at = target
        if follow_terrain:
            return Leg(seq, Phase.CRUISE, self._following(points), over_terrain=True)
        return Leg(seq, Phase.CRUISE, points)

    def _following(self, ends: Points) -> Points:
        """The leg between two points that keeps its height over the ground, which changes evenly from end to end."""
        steps = max(2, math.ceil(float(np.hypot(*(ends[1] - ends[0])[:2])) / FOLLOWING_STEP) + 1)
        along = np.linspace(0.0, 1.0, steps)
        points = ends[0] + along[:, None] * (ends[1] - ends[0])
        first, last = ends[:, 2] - self.ground(ends)
        points[:, 2] = self.ground(points) + first + along * (last - first)
        return np.asarray(points)

    def _takeoff(self, seq: int, item: Item) -> Iterator[Leg]:
        if not math.isfinite(item.altitude):
            return
        yield self._vertical(seq, Phase.TAKEOFF, self.home[2] + item.height(self.mission.home))
        target = self.places[seq - 1]
        if self.mission.autopilot.guidance.climbs_where_it_stands or target is None:
            return  # ArduCopter climbs where it stands, whatever position the take-off names
        if np.hypot(*(target - self.at)[:2]) > NEARBY:
            yield self._to(seq, target, _follows(item))

    def _landing(self, seq: int, item: Item) -> Iterator[Leg]:
        if item.has_position:
            place = self.frame.local(Geodetic(item.latitude_deg, item.longitude_deg, self.mission.home.altitude))
            yield self._to(seq, np.array([*place[:2], self.at[2]]), follow_terrain=False)
        yield self._vertical(seq, Phase.LANDING, float(self.ground(self.at[None, :])[0]))

    def returns(self, seq: int) -> Iterator[Leg]:
        """Home, or to the rally point that the autopilot chooses; and to all others, to which it may turn as well.

        Or back along the mission, without climbing, where the autopilot returns so.
        """
        places = [triple(place) for place in self._rally_points()]
        chosen = self.mission.autopilot.goal_of_return(self.parameters, triple(self.at), places)
        if self.mission.autopilot.return_route(self.parameters, triple(self.at), places).by is ReturnBy.BACK:
            yield from self._back(seq)
            return
        ways = list(self.return_ways(self.at[None]))
        ways.insert(0, ways.pop(0 if chosen is None else chosen + 1))
        landed = self.at
        for n, (goal, (way,)) in enumerate(ways):
            self.at = way[-1]
            down = self._vertical(seq, Phase.LANDING, float(self.ground(goal[None, :])[0]))
            yield from (replace(leg, alternative=n > 0) for leg in (Leg(seq, Phase.RETURN, way), down))
            landed = self.at if n == 0 else landed
        self.at = landed

    def _back(self, seq: int) -> Iterator[Leg]:
        flown = zip(self.mission.items[: seq - 1], self.places, strict=False)
        places = [place for item, place in flown if item.command in FLOWN_TO and place is not None]
        way = np.array([self.at, *reversed(places)])
        over_home = np.array([self.home[0], self.home[1], way[-1, 2]])
        yield Leg(seq, Phase.RETURN, np.vstack([way, over_home]))
        self.at = over_home
        yield self._vertical(seq, Phase.LANDING, float(self.ground(self.home[None, :])[0]))

    def return_ways(self, places: Points) -> Iterator[tuple[Vector, NDArray[np.float64]]]:
        """Each goal, and the ways to over it from places (n, 3), over them, (n, 3, 3).

        They are so high above home all the way: level is not straight, 10 km away it is 8 m lower.
        """
        amsl, autopilot = self.mission.home.altitude, self.mission.autopilot
        latitude, longitude, altitude = self.frame.to_geodetic(places)
        ups = (0.0, *(place.altitude for place in self.mission.rally))
        for goal, up in zip((self.home, *self._rally_points()), ups, strict=True):
            there = self.frame.geodetic(goal)
            distances = np.hypot(*(goal - places)[:, :2].T)
            both = zip((altitude - amsl).tolist(), distances.tolist(), strict=True)
            heights = np.array([autopilot.return_height(self.parameters, *one, up) for one in both])
            ways = np.stack([places, places, np.tile(goal, (len(places), 1))], axis=1)
            ways[:, 1, 2] = self.frame.to_local(latitude, longitude, amsl + heights)[:, 2]
            beyond = np.full(len(places), there.latitude_deg), np.full(len(places), there.longitude_deg)
            ways[:, 2, 2] = self.frame.to_local(*beyond, amsl + heights)[:, 2]
            yield goal, ways

    def _rally_points(self) -> list[Vector]:
        amsl, local = self.mission.home.altitude, self.frame.local
        return [local(Geodetic(p.latitude_deg, p.longitude_deg, amsl + p.altitude)) for p in self.mission.rally]

    def _jump(self, seq: int) -> Iterator[Leg]:
        """The ways on to where a jump may lead."""
        here, flown_in = self.at, self.flown_in
        for index in led_to(self.mission.items, seq - 1, MOVING):
            item, target = self.mission.items[index], self.places[index]
            legs: Iterable[Leg] = ()
            if item.command == Command.NAV_RETURN_TO_LAUNCH:
                legs = self.returns(index + 1)
            elif item.command == Command.NAV_LAND:
                legs = self._landing(index + 1, item)
            elif target is not None:
                legs = [self._onward(index + 1, item, target)]
            yield from (replace(leg, alternative=True, jumped_from=self.last) for leg in legs)
            self.at, self.flown_in = here, flown_in

    def _vertical(self, seq: int, phase: Phase, up: float) -> Leg:
        points = np.array([self.at, [self.at[0], self.at[1], up]])
        self.flown_in = None
        self.at = points[-1]
        return Leg(seq, phase, points)


def triple(point: Vector) -> Place:
    """A place (3,) as plain numbers."""
    return float(point[0]), float(point[1]), float(point[2])


def _follows(item: Item) -> bool:
    return plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT
