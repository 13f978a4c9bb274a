"""Endings ordered at many times of one flight: the ways on which each may be flown, and what they keep.

The times are so near to each other that between two clear ones nothing can be nearer than is required: there no way
moves farther than both have to spare. Ways are straight legs, level or upright but where the vehicle brakes; obstacles
are larger by the tube of the autopilot.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, reduce
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.forecast.deviation.room import with_room
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import rally_places
from ipoa_mission.forecast.return_routes import WHERE, ReturnRoutes
from ipoa_mission.forecast.stopping_points import StoppingPoints, stopping_points_of
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.commands import Command
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.proof import Check, prove_ground
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.returning import ReturnBy
from ipoa_mission.world.airspace import NOTHING_NEAR, ROUNDING, Clearance

EVERY_S = 1.0  # between the times that are looked at first [s]
AT_ONCE = 5_000  # so many of them: what is worked out of each on the way takes room
NEAREST_S = 0.05  # they come no nearer to each other [s]
TIGHT_PLACES = 4.0  # at so many tight places the tube has room on one of these ways
LIFTED = 1.0  # who is lower above where he took off can end his flight by standing still [m]
BACK = (0.0, 0.5, 1.0)  # shares of the way back to where it was told to return, at which it may climb
GOAL_DOUBT = 10.0  # it may be so far from where it is thought to be as it chooses its goal [m]
AROUND = ((0.0, 0.0), (GOAL_DOUBT, 0.0), (-GOAL_DOUBT, 0.0), (0.0, GOAL_DOUBT), (0.0, -GOAL_DOUBT))
SAGITTA = 0.02  # so far a flown bend is beside the chords between the places at which it is looked at [m]
ROUND_EARTH = 0.5  # by so much at most level ways are not straight [m]
SEEN = 8.0  # what is so much farther than required counts as no nearer [m]
BRAKES, TURNS_BACK, CLIMBS, RETURNS, DESCENDS = range(5)  # the legs of a way on which it returns
GROUND = -2  # the number of the ground, beside those of obstacles; -1 is nothing


@dataclass(frozen=True, eq=False)
class ContingencySamples:
    """One ending, ordered at each of `times` (n,) [s after arming].

    Attributes:
        ways: the ways on which it may be flown, (n, k, p, 3) [m].
        taken: which of them may be, (n, k).
        near: what their legs keep of the nearest thing, (n, k, p - 1) [m]; infinite where nothing is near.
        which: the number of that thing, (n, k, p - 1).
        spare: how much more than required is kept, (n,) [m].
    """

    times: Vector
    ways: NDArray[np.float64]
    taken: NDArray[np.bool_]
    near: NDArray[np.float64]
    which: NDArray[np.intp]
    spare: Vector

    @property
    def clear(self) -> NDArray[np.bool_]:
        """Whether everything that is required is kept, (n,)."""
        return np.asarray(self.spare >= 0.0)

    @property
    def same_as_next(self) -> NDArray[np.bool_]:
        """Whether the next one may lead to the same goals, and is as clear, (n - 1,)."""
        taken, clear = self.taken, self.clear
        return np.asarray((taken[1:] == taken[:-1]).all(axis=1) & (clear[1:] == clear[:-1]))

    def gaps(self) -> Vector:
        """The middle of each two times between which something may be missed, or something nearer than is known."""
        places = np.moveaxis(self.ways, 2, 0)  # one after the other: all at once take room
        moved = reduce(np.maximum, (np.linalg.norm(np.diff(place, axis=0), axis=-1) for place in places))
        moved = np.where(self.taken[1:] | self.taken[:-1], moved, 0.0).max(axis=1)
        hidden = self.clear[:-1] & (self.spare[1:] + self.spare[:-1] < moved)
        asked = (hidden | ~self.same_as_next | self._beside_the_nearest()) & (np.diff(self.times) > NEAREST_S)
        return np.asarray((self.times[1:] + self.times[:-1])[asked] / 2)

    def _beside_the_nearest(self) -> NDArray[np.bool_]:
        """Which of the gaps lie beside the time that keeps least of those that are the same, (n - 1,)."""
        beside = np.zeros(len(self.times), dtype=bool)
        for alike in np.split(np.arange(len(self.times)), np.flatnonzero(~self.same_as_next) + 1):
            least = alike[np.argmin(self.spare[alike])]
            beside[max(least - 1, 0) : least + 1] = self.spare[least] < SEEN
        return beside[:-1]

    def all_nearer(self, required: float) -> NDArray[np.bool_]:
        """Whether every way that may be taken comes nearer to something than is required, (n,)."""
        return np.asarray(((self.near.min(axis=2) < required) | ~self.taken).all(axis=1))

    @classmethod
    def following(cls, parts: "Iterable[ContingencySamples]", count: int) -> "ContingencySamples":
        """Parts one after the other, of so many times in all; each is let go of as the next one is looked at."""
        whole, begin = dict[str, NDArray[Any]](), 0
        for part in parts:
            own = {f.name: getattr(part, f.name) for f in fields(cls)}
            whole = whole or {name: np.empty((count, *some.shape[1:]), some.dtype) for name, some in own.items()}
            for name, some in own.items():
                whole[name][begin : begin + len(some)] = some
            begin += len(part.times)
        return cls(**whole)

    @classmethod
    def merged(cls, assessments: "Sequence[ContingencySamples]") -> "ContingencySamples":
        """All of them, in the order of their times."""
        order = np.argsort(np.concatenate([some.times for some in assessments]), kind="stable")
        taken = slice(None) if (np.diff(order) == 1).all() else order  # all of them as they are, or copied
        return cls(
            **{f.name: np.concatenate([getattr(one, f.name) for one in assessments])[taken] for f in fields(cls)}
        )


class ContingencyPaths:
    """Compute contingency paths for a forecast, in the world of its scenario: `forecast.cached(ContingencyPaths)`.

    Times are those of the flight that is sure where it is.
    """

    def __init__(self, forecast: Forecast) -> None:
        self.forecast, self.mission = forecast, forecast.mission
        self.required = forecast.world.limits.obstacle_distance
        self.rally = rally_places(self.mission)
        self.routes = ReturnRoutes(forecast, self.rally)
        self._stops, self._looks = dict[Contingency, StoppingPoints](), dict[Contingency, ContingencySamples]()

    def returning(self, forecast: Forecast) -> "ContingencyPaths":
        """The same of a forecast in this world that differs in its return altitude or rally points only."""
        return forecast.cached(ContingencyPaths, self._of_another)

    def _of_another(self, forecast: Forecast) -> "ContingencyPaths":
        other = ContingencyPaths(forecast)
        other.__dict__["roomy"] = self.roomy
        if not any(item.command == Command.NAV_RETURN_TO_LAUNCH for item in self.mission.items):
            other.__dict__["in_air"], other._stops = self.in_air, self._stops  # it is flown as before
            other._looks = {
                contingency: assessments
                for contingency, assessments in self._looks.items()
                if contingency is not Contingency.RTL
            }
        return other

    @cached_property
    def roomy(self) -> PathTask:
        """The scenario with room for the tube."""
        return with_room(self.forecast.world, TIGHT_PLACES)

    @cached_property
    def as_flown(self) -> "ContingencyPaths":
        """The same with no room for the tube: how near the predicted ways themselves come."""
        other = ContingencyPaths(self.forecast)
        other.__dict__ |= {"roomy": self.forecast.world, "in_air": self.in_air, "routes": self.routes}
        other._stops = self._stops
        return other

    @cached_property
    def in_air(self) -> tuple[float, float]:
        """From when to when it is in the air [s]."""
        track = self.forecast.promise.flight.pieces
        lifted = track.times[track.points[:, 2] > track.points[0, 2] + LIFTED]
        return (float(lifted[0]), float(lifted[-1])) if len(lifted) else (0.0, 0.0)

    def stops(self, contingency: Contingency = Contingency.RTL) -> StoppingPoints:
        """Where it comes to a stand, from every moment at which it is in the air."""
        if contingency not in self._stops:
            self._stops[contingency] = stopping_points_of(self.forecast, *self.in_air, contingency)
        return self._stops[contingency]

    def why_unknown(self) -> str | None:
        """Why it is not known here where a return leads; None where it is."""
        if (why := self.routes.why_unknown) is not None:
            return why
        vehicle, version, parameters = self.mission.autopilot, self.mission.firmware_version, self.routes.parameters
        if self.mission.fence and vehicle.room_to_fences(parameters, version) is not None:
            return "returns round fences are not modeled"
        return None

    def assessments(self, contingency: Contingency, between: tuple[float, float] | None = None) -> ContingencySamples:
        """At an ending from so many times in the air, or between two of these, that nothing is missed."""
        if between is None:
            if contingency not in self._looks:
                self._looks[contingency] = self.assessments(contingency, self.in_air)
            return self._looks[contingency]
        begin, end = between
        assessments = self.at(contingency, np.linspace(begin, end, max(2, round((end - begin) / EVERY_S) + 1)))
        while len(times := assessments.gaps()):
            assessments = ContingencySamples.merged([assessments, self.at(contingency, times)])
        return assessments

    def at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        """At an ending from these times (n,), in their order."""
        some = np.array_split(times, math.ceil(len(times) / AT_ONCE) or 1)
        return ContingencySamples.following((self._at(contingency, part) for part in some), len(times))

    def _at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        places, stands = self.stops(contingency).at(times)
        ways, taken = np.stack([places, stands], axis=1)[:, None], np.ones((len(times), 1), dtype=bool)
        if contingency is Contingency.LAND:
            ways = np.concatenate([ways, self._ground_below(stands)[:, None, None]], axis=2)
        elif contingency is Contingency.RTL:
            ways, taken = self._returns(places, stands, self.stops(contingency).seqs_at(times))
        elif contingency is Contingency.SMART_RTL:
            home = np.broadcast_to(self.forecast.promise.flight.pieces.points[0], (len(times), 1, 1, 3))
            ways = np.concatenate([ways, home], axis=2)
        near, which = self._near(ways)
        if contingency is Contingency.SMART_RTL:
            near[:, 0, 1], which[:, 0, 1] = self._flown_so_far(times)
        if contingency is Contingency.RTL:
            self._note_mission(times, near, which)
        spare = np.where(taken, np.minimum(near.min(axis=2) - self.required, SEEN), SEEN).min(axis=1)
        assessments = ContingencySamples(times, ways, taken, near, which, spare)
        return self._with_ground(assessments, _come_down(contingency))

    def exactly(self, contingency: Contingency, assessments: ContingencySamples, n: int) -> Clearance:
        """What one look keeps of an obstacle, to the millimeter, and of which."""
        if contingency is Contingency.SMART_RTL:
            return self._least_noted(assessments, n)
        least = NOTHING_NEAR
        for way in assessments.ways[n][assessments.taken[n]]:
            found = self.roomy.airspace.obstacle_clearance(way, within=least.distance)
            least = min(least, found, key=lambda clearance: clearance.distance)
        return least

    def lowest(self, contingency: Contingency, assessments: ContingencySamples, n: int) -> Check:
        """What one look keeps of the ground on the ways that may be taken, before it comes down."""
        ways = assessments.ways[n, assessments.taken[n], : _come_down(contingency)]
        checks = (check for way in ways for check in prove_ground(way, self.forecast.world))
        return min(checks, key=lambda check: check.slack)

    def _least_noted(self, assessments: ContingencySamples, n: int) -> Clearance:
        leg = int(np.argmin(assessments.near[n, 0]))
        number, place = int(assessments.which[n, 0, leg]), assessments.ways[n, 0, leg].tolist()
        name = self.roomy.airspace.obstacles[number].name if number >= 0 else "nothing"
        return Clearance(float(assessments.near[n, 0, leg]), (place[0], place[1], place[2]), name, leg)

    def goal(self, contingency: Contingency, assessments: ContingencySamples, n: int) -> str:
        """Where one look leads, in words."""
        if contingency in (Contingency.LAND, Contingency.HOLD):
            return "here"
        names = ["home", *(f"rally point {k}" for k in range(1, len(self.rally) + 1))]
        names += [WHERE[by] for by in self.routes.kinds]
        goals = sorted({int(way) // self._variants for way in np.flatnonzero(assessments.taken[n])})
        return " or ".join(dict.fromkeys(names[goal] for goal in goals))

    def _near(self, ways: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """What the legs of ways (n, k, p, 3) keep of obstacles, and of which; exactly where one brakes on a slant."""
        air, shape = self.roomy.airspace, (*ways.shape[:2], ways.shape[2] - 1)
        starts, ends = ways[:, :, :-1].reshape(-1, 3), ways[:, :, 1:].reshape(-1, 3)
        near, which = air.legs_clearance(starts, ends, self.required + SEEN)
        slanting = (starts[:, 2] != ends[:, 2]) & (starts[:, :2] != ends[:, :2]).any(axis=1)
        is_braking = np.arange(len(starts)) % shape[2] == BRAKES
        slanting &= is_braking | (np.abs(ends[:, 2] - starts[:, 2]) > ROUND_EARTH)
        for leg in np.flatnonzero(slanting & (near < self.required)):
            near[leg], _ = air.obstacles[which[leg]].leg_clearance(starts[leg], ends[leg])
        return near.reshape(shape), which.reshape(shape)

    def _flown_so_far(self, times: Vector, ahead: bool = False) -> tuple[Vector, NDArray[np.intp]]:
        """How near it came to what on its way until each time (n,), or will from then on if all is as planned."""
        near, which = (legs[:, 0, 0] for legs in self._flown)
        turned = slice(None, None, -1) if ahead else slice(None)
        near, which = near[turned], which[turned]
        nearest = np.maximum.accumulate(np.where(near <= np.minimum.accumulate(near), np.arange(len(near)), 0))
        until = np.clip(np.searchsorted(self.stops().times, times) - 1, 0, len(near) - 1)
        until = nearest[len(near) - 1 - until if ahead else until]
        return np.asarray(near[until] - SAGITTA), np.asarray(which[until])

    def _note_mission(self, times: Vector, near: NDArray[np.float64], which: NDArray[np.intp]) -> None:
        """Of returns along the mission also what its own path keeps, whose bends are flown as they are bent there."""
        for n, by in enumerate(self.routes.kinds):
            first = (len(self.rally) + 1 + n) * self._variants
            flown, of = self._flown_so_far(times, by is ReturnBy.AHEAD)
            for k in range(first, first + self._variants):
                nearer = flown < near[:, k, CLIMBS]
                near[nearer, k, CLIMBS], which[nearer, k, CLIMBS] = flown[nearer], of[nearer]

    @cached_property
    def _flown(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        places = self.stops().places
        if len(places) == 1:  # it is in the air for one moment
            places = np.repeat(places, 2, axis=0)
        return self._near(np.stack([places[:-1], places[1:]], axis=1)[:, None])

    def _with_ground(self, assessments: ContingencySamples, end: int) -> ContingencySamples:
        """The looks with what their ways up to place `end` keep of the ground, where that is less."""
        begin, last = self.forecast.promise.flight.way
        near, which, spare = assessments.near.copy(), assessments.which.copy(), assessments.spare.copy()
        on_the_way = np.flatnonzero((assessments.times >= begin) & (assessments.times <= last))
        ways, terrain = assessments.ways[on_the_way, :, :end], self.forecast.world.airspace.terrain
        heights = terrain.legs_height(ways[:, :, :-1].reshape(-1, 3), ways[:, :, 1:].reshape(-1, 3))
        least = heights.reshape(*ways.shape[:2], ways.shape[2] - 1).min(axis=2)
        low = assessments.taken[on_the_way] & (least < self.forecast.world.limits.height_above_ground + ROUNDING)
        for at, k in np.argwhere(low).tolist():
            n = on_the_way[at]
            for check in prove_ground(assessments.ways[n, k, :end], self.forecast.world):
                if check.slack < min(spare[n], 0.0):
                    leg = min(check.nearest.leg, near.shape[2] - 1)
                    near[n, k, leg], which[n, k, leg] = self.required + check.slack, GROUND
                    spare[n] = check.slack
        return replace(assessments, near=near, which=which, spare=spare)

    @property
    def _shares(self) -> tuple[float, ...]:
        return BACK if self.mission.autopilot.guidance.climbs_coming_back else BACK[:1]

    @property
    def _variants(self) -> int:
        """So many ways lead to each goal."""
        return len(self._shares) + len(self.routes.off_terrain)

    def _returns(
        self, places: Points, stands: Points, seqs: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Every way that a return may take from there: to each goal, each begun where it may; and which may be.

        `seqs` (n,): the items that it is bound for.
        """
        to_goals, kinds = self.forecast.returns_from(stands), self.routes.kinds
        back = places - stands
        back[:, 2] = 0.0
        ways, ups = [], (0.0, *(up for _, _, up in self.rally))
        for way, up in zip(to_goals, ups, strict=True):
            over, beyond, ground = way[:, 1], way[:, 2], self._ground_below(way[:, 2])
            ways += [
                np.stack([places, stands, stands + share * back, over + share * back, beyond, ground], axis=1)
                for share in self._shares
            ]
            ways += [self.routes.over_terrain(places, stands, beyond, up, off) for off in self.routes.off_terrain]
        for by, _ in product(kinds, self._shares):
            ways.append(self.routes.ways(by, np.stack([places, stands, stands, stands], axis=1), seqs))
        if len({way.shape[1] for way in ways}) > 1:
            ways = [_padded(way, max(other.shape[1] for other in ways)) for way in ways]
        goals = [self._goals(stand, int(seq)) for stand, seq in zip(stands, seqs, strict=True)]
        chosen = np.array([[goal in some for goal in range(len(to_goals) + len(kinds))] for some in goals])
        taken = np.repeat(chosen, self._variants, axis=1)
        if self.routes.surely_over_terrain:
            taken &= np.arange(taken.shape[1]) % self._variants >= len(self._shares)
        return np.stack(ways, axis=1), taken

    def _goals(self, stand: Vector, seq: int) -> set[int]:
        """The goals of a return from near there: 0 is home, n the rally point n, then those along the mission."""
        if not self.rally and not self.routes.kinds:
            return {0}
        east, north, up = (float(x) for x in stand)
        routes = (self.routes.route((east + e, north + n, up), seq) for e, n in AROUND)
        first = len(self.rally) + 1
        return {
            first + self.routes.kinds.index(by) if by in self.routes.kinds else 0 if rally is None else rally + 1
            for by, rally in ((route.by, route.rally) for route in routes)
        }

    def _ground_below(self, points: Points) -> Points:
        ground = self.roomy.airspace.ground(points)
        return np.column_stack([points[:, :2], np.minimum(ground, points[:, 2])])


def _come_down(contingency: Contingency) -> int:
    """Which place of its ways is the first that is on the ground, or no longer braking."""
    return -1 if contingency is Contingency.RTL else 2


def _padded(ways: NDArray[np.float64], places: int) -> NDArray[np.float64]:
    """Ways (n, p, 3) with so many places: it stays at the last but one."""
    stays = np.repeat(ways[:, -2:-1], places - ways.shape[1], axis=1)
    return np.concatenate([ways[:, :-1], stays, ways[:, -1:]], axis=1)
