"""Compute the legs of a mission: take-off, waypoints, curves, jumps, returns and landings.

Heights become local `up` with the Earth's curvature. Loops are not unrolled: each jump adds its leg.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import ipoa_mission.forecast.itinerary.copter_curves as curves
from ipoa_mission.autopilot.commands import FLOWN_TO, JUMPS, Command
from ipoa_mission.autopilot.failsafe import FlightStage
from ipoa_mission.autopilot.returning import ReturnBy, ReturnOrder
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.geometry import Place, Points, Vector, arc_lengths, as_place
from ipoa_mission.ground import Ground
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.program import as_flown, led_to, next_navigated, onward
from ipoa_mission.world.terrain import Flat

CHORD_TOLERANCE = 0.005  # of a curve to its chords [m]
FOLLOWING_STEP = 5.0  # [m]
HORIZONTAL_SPEEDS = (0.0, 1.0)  # param1 of DO_CHANGE_SPEED
MOVING = FLOWN_TO | {Command.NAV_RETURN_TO_LAUNCH}
HOME_RADIUS = 0.5  # of a take-off at home [m]


@dataclass(frozen=True, eq=False)
class Leg:
    """The path to item `seq`: points (k, 3) [m].

    `alternative`: flown after a jump or to a rally point only. `chord_error`: greatest distance of path to lines [m].
    `jumped_from`: the item before a jump; -1: none.
    """

    seq: int
    stage: FlightStage
    points: Points
    alternative: bool = False
    over_terrain: bool = False
    chord_error: float = 0.0
    jumped_from: int = -1

    @property
    def name(self) -> str:
        names = {
            FlightStage.ROUTE: "the leg to it",
            FlightStage.RETURN: "the way home",
            FlightStage.TAKEOFF: "the climb",
        }
        name = names.get(self.stage, "the descent")
        if self.jumped_from < 0:
            return name
        return f"{name} from {f'item {self.jumped_from}' if self.jumped_from else 'home'}, after a jump"


def flown_legs(mission: Mission, frame: LocalFrame, ground: Ground | None = None) -> tuple[Leg, ...]:
    """Return a mission's legs from ground to ground, level at home's height by default; positions must be valid."""
    return tuple(_LegBuilder(as_flown(mission), frame, ground).legs())


def trace_returns(mission: Mission, frame: LocalFrame, places: Points) -> NDArray[np.float64]:
    """Return paths of returns from places (n, 3), (goals, n, 3, 3) [m]."""
    return np.array([paths for _, paths in _LegBuilder(as_flown(mission), frame, None).trace_returns(places)])


def join(legs: Sequence[Leg]) -> tuple[Points, float]:
    """Return joined points, and the greatest distance to their lines [m]."""
    points = np.vstack([legs[0].points, *(leg.points[1:] for leg in legs[1:])])
    return points, max(leg.chord_error for leg in legs)


def item_places(mission: Mission, frame: LocalFrame, ground: Ground) -> list[Vector | None]:
    rows = [
        (item.latitude_deg, item.longitude_deg, 0.0 if item.is_over_terrain else mission.altitude_above_home(item))
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
            if mission.items[n].is_over_terrain:
                place[2] = ground(place[None, :])[0] + mission.items[n].altitude
            places[n] = place
    return places


class _LegBuilder:
    def __init__(self, mission: Mission, frame: LocalFrame, ground: Ground | None) -> None:
        self.mission = mission
        self.frame = frame
        self.home = frame.local(mission.home)
        self.ground = ground or Ground(Flat(float(self.home[2])))
        self.places = item_places(mission, frame, self.ground)
        self.parameters = mission.complete_parameters
        self.at = self.home
        self.last = 0  # the last item that moved the vehicle
        self.flown_in: Vector | None = None  # direction of arrival, if it flies on without a stop, (3,) [m]
        #: The spline that led here: its item, its begin, and the direction of arrival there.
        self.curve: tuple[int, Vector, Vector | None] | None = None
        self.circles = Command.NAV_LOITER_TURNS in mission.autopilot.command_effects.flown
        self.speed: float | None = None  # of DO_CHANGE_SPEED [m/s]
        self.heading = 0.0  # clockwise from north [rad]

    def legs(self) -> Iterator[Leg]:
        for seq, item in enumerate(self.mission.items, start=1):
            yield from self._jump(seq) if item.command in JUMPS else self._legs_to(seq, item)
            if item.command in MOVING:
                self.last = seq

    def _legs_to(self, seq: int, item: Item) -> Iterator[Leg]:
        match item.command:
            case Command.NAV_TAKEOFF | Command.NAV_VTOL_TAKEOFF:
                yield from self._takeoff(seq, item)
            case Command.NAV_LAND | Command.NAV_VTOL_LAND:
                yield from self._landing_legs(seq, item)
            case Command.NAV_PAYLOAD_PLACE:
                yield from self._payload(seq, item)
            case Command.NAV_LOITER_TURNS if self.circles:
                yield from self._circle(seq, item)
            case Command.DO_CHANGE_SPEED if item.params[0] in HORIZONTAL_SPEEDS and item.params[1] > 0:
                self.speed = item.params[1]
            case Command.NAV_RETURN_TO_LAUNCH:
                yield from self._returns(seq)
            case command if command in FLOWN_TO and (target := self.places[seq - 1]) is not None:
                yield self._onward(seq, item, target)

    def _onward(self, seq: int, item: Item, target: Vector) -> Leg:
        origin = self.at
        next_index = onward(self.mission.items, seq - 1, self.mission.autopilot)
        is_curve = item.command == Command.NAV_SPLINE_WAYPOINT and self.mission.autopilot.guidance.flies_splines
        if is_curve and np.linalg.norm(target - origin) > 1e-3:  # [m]
            self.curve = seq, origin, self.flown_in
            return self._curve(seq, item, target, next_navigated(self.mission.items, seq - 1, self.mission.autopilot))
        turn = 0.0 if self.flown_in is None or self.curve else curves.turn_of(item)
        if curves.is_arc(as_place(origin), as_place(target), turn):
            ends = self._over(item, origin), self._over(item, target)
            leg = self._bent(seq, item, curves.arc_chords(*ends, turn, CHORD_TOLERANCE))
        else:
            leg = self._to(seq, target, item.is_over_terrain)
        self.flown_in = None if next_index is None else target - origin
        self.curve = None
        return leg

    def _curve(self, seq: int, item: Item, target: Vector, next_index: int | None) -> Leg:
        begin, end = self._over(item, self.at), self._over(item, target)
        after = None
        if next_index is not None:
            next_item = self.mission.items[next_index]
            after = curves.place_after(item, next_item, end, self._named(next_item))
        flown_in = None if self.flown_in is None else as_place(self.flown_in)
        tangents = curves.spline_tangents(begin, end, flown_in, after)
        self.flown_in = np.array(tangents[1]) if any(tangents[1]) else None
        return self._bent(seq, item, curves.spline_chords(begin, end, tangents, CHORD_TOLERANCE))

    def _named(self, item: Item) -> Place:
        height = item.altitude if item.is_over_terrain else self.mission.altitude_above_home(item)
        place = Geodetic(item.latitude_deg, item.longitude_deg, self.mission.home.altitude + height)
        east, north, up = as_place(self.frame.local(place))
        return east, north, item.altitude if item.is_over_terrain else up

    def _over(self, item: Item, place: Vector) -> Place:
        east, north, up = as_place(place)
        return east, north, up - float(self.ground(place[None, :])[0]) if item.is_over_terrain else up

    def _bent(self, seq: int, item: Item, points: Points) -> Leg:
        follows = item.is_over_terrain
        if follows:
            traveled = arc_lengths(points)
            steps = np.union1d(traveled, np.arange(0.0, traveled[-1], FOLLOWING_STEP))
            points = np.column_stack([np.interp(steps, traveled, axis) for axis in points.T])
            points[:, 2] += self.ground(points)
        self.at = points[-1]
        return Leg(seq, FlightStage.ROUTE, points, over_terrain=follows, chord_error=CHORD_TOLERANCE)

    def _circle(self, seq: int, item: Item) -> Iterator[Leg]:
        if (center := self.places[seq - 1]) is None:
            return
        radius = curves.circle_radius(item)
        edge, apart = curves.circle_entry(as_place(self.at), as_place(center), radius, self.heading)
        if radius <= 0.0:
            yield self._to(seq, np.array([center[0], center[1], self.at[2]]), follow_terrain=False)
        elif apart > curves.NEAR_CIRCLE:
            yield self._to(seq, np.array(edge), item.is_over_terrain)
        self.flown_in = self.curve = None
        turn = curves.circle_turn(item)
        if radius > 0.0 and turn != 0.0:
            version = self.mission.firmware_version
            flown = self.mission.autopilot.circle(self.parameters, radius, turn, self.speed, version)
            assert flown is not None, "it flies circles"
            turn = curves.circle_turn(item, flown.sense)
            begin = self._over(item, self.at)
            yield self._bent(seq, item, curves.circle_chords(begin, as_place(center), flown, turn, CHORD_TOLERANCE))

    def _to(self, seq: int, target: Vector, follow_terrain: bool) -> Leg:
        points = np.array([self.at, target])
        if np.hypot(*(target - self.at)[:2]) > HOME_RADIUS:
            self.heading = math.atan2(*(target - self.at)[:2])
        self.at = target
        path = self._over_ground(points) if follow_terrain else points
        return Leg(seq, FlightStage.ROUTE, path, over_terrain=follow_terrain)

    def _over_ground(self, ends: Points) -> Points:
        steps = max(2, math.ceil(float(np.hypot(*(ends[1] - ends[0])[:2])) / FOLLOWING_STEP) + 1)
        along = np.linspace(0.0, 1.0, steps)
        points = ends[0] + along[:, None] * (ends[1] - ends[0])
        first, last = ends[:, 2] - self.ground(ends)
        points[:, 2] = self.ground(points) + first + along * (last - first)
        return np.asarray(points)

    def _takeoff(self, seq: int, item: Item) -> Iterator[Leg]:
        if not math.isfinite(item.altitude):
            return
        yield self._vertical(seq, FlightStage.TAKEOFF, self.home[2] + item.height(self.mission.home))
        target = self.places[seq - 1]
        if self.mission.autopilot.guidance.climbs_where_it_stands or target is None:
            return  # ArduCopter climbs in place, whatever the take-off's position
        if np.hypot(*(target - self.at)[:2]) > HOME_RADIUS:
            yield self._to(seq, target, item.is_over_terrain)

    def _landing_legs(self, seq: int, item: Item) -> Iterator[Leg]:
        if item.has_position:
            place = self.frame.local(Geodetic(item.latitude_deg, item.longitude_deg, self.mission.home.altitude))
            yield self._to(seq, np.array([*place[:2], self.at[2]]), follow_terrain=False)
        yield self._vertical(seq, FlightStage.LANDING, float(self.ground(self.at[None, :])[0]))

    def _payload(self, seq: int, item: Item) -> Iterator[Leg]:
        target = self.places[seq - 1]
        if target is not None:
            up = target[2] if self.flown_in is not None else self.at[2]
            yield self._to(seq, np.array([target[0], target[1], up]), follow_terrain=False)
        top = float(self.at[2])
        ground = float(self.ground(self.at[None, :])[0])
        deepest = item.params[0] if item.params[0] > 0.0 else math.inf
        yield self._vertical(seq, FlightStage.LANDING, max(top - deepest, ground))
        yield self._vertical(seq, FlightStage.LANDING, top)

    def _returns(self, seq: int) -> Iterator[Leg]:
        places = [as_place(place) for place in self._rally_points()]
        order = ReturnOrder(as_place(self.at), places, version=self.mission.firmware_version)
        route = self.mission.autopilot.return_route(self.parameters, order)
        if route.by is ReturnBy.MISSION_REVERSED:
            yield from self._back(seq)
            return
        paths = list(self.trace_returns(self.at[None]))
        paths.insert(0, paths.pop(0 if route.rally is None else route.rally + 1))
        landed = self.at
        for n, (goal, (path,)) in enumerate(paths):
            self.at = path[-1]
            down = self._vertical(seq, FlightStage.LANDING, float(self.ground(goal[None, :])[0]))
            yield from (replace(leg, alternative=n > 0) for leg in (Leg(seq, FlightStage.RETURN, path), down))
            landed = self.at if n == 0 else landed
        self.at = landed

    def _back(self, seq: int) -> Iterator[Leg]:
        flown = zip(self.mission.items[: seq - 1], self.places, strict=False)
        places = [place for item, place in flown if item.command in FLOWN_TO and place is not None]
        path = np.array([self.at, *reversed(places)])
        over_home = np.array([self.home[0], self.home[1], path[-1, 2]])
        yield Leg(seq, FlightStage.RETURN, np.vstack([path, over_home]))
        self.at = over_home
        yield self._vertical(seq, FlightStage.LANDING, float(self.ground(self.home[None, :])[0]))

    def trace_returns(self, places: Points) -> Iterator[tuple[Vector, NDArray[np.float64]]]:
        """Return each goal, and the paths from places (n, 3) to over it, (n, 3, 3)."""
        amsl = self.mission.home.altitude
        autopilot = self.mission.autopilot
        latitude, longitude, altitude = self.frame.to_geodetic(places)
        ups = (0.0, *(place.altitude for place in self.mission.rally))
        for goal, up in zip((self.home, *self._rally_points()), ups, strict=True):
            there = self.frame.geodetic(goal)
            distances = np.hypot(*(goal - places)[:, :2].T)
            both = zip((altitude - amsl).tolist(), distances.tolist(), strict=True)
            heights = np.array([autopilot.return_height(self.parameters, *pair, up) for pair in both])
            paths = np.stack([places, places, np.tile(goal, (len(places), 1))], axis=1)
            paths[:, 1, 2] = self.frame.to_local(latitude, longitude, amsl + heights)[:, 2]
            beyond = np.full(len(places), there.latitude_deg), np.full(len(places), there.longitude_deg)
            paths[:, 2, 2] = self.frame.to_local(*beyond, amsl + heights)[:, 2]
            yield goal, paths

    def _rally_points(self) -> list[Vector]:
        amsl = self.mission.home.altitude
        places = (Geodetic(at.latitude_deg, at.longitude_deg, amsl + at.altitude) for at in self.mission.rally)
        return [self.frame.local(place) for place in places]

    def _jump(self, seq: int) -> Iterator[Leg]:
        here, flown_in, curve = self.at, self.flown_in, self.curve
        for index in led_to(self.mission.items, seq - 1, MOVING):
            if curve is not None and (goal := self.places[curve[0] - 1]) is not None:
                self.at, self.flown_in = curve[1:]
                yield replace(self._curve(curve[0], self.mission.items[curve[0] - 1], goal, index), alternative=True)
            for leg in self._legs_to(index + 1, self.mission.items[index]):
                yield replace(leg, alternative=True, jumped_from=self.last)
            self.at, self.flown_in, self.curve = here, flown_in, curve

    def _vertical(self, seq: int, stage: FlightStage, up: float) -> Leg:
        points = np.array([self.at, [self.at[0], self.at[1], up]])
        self.flown_in = self.curve = None
        self.at = points[-1]
        return Leg(seq, stage, points)
