"""Compute the paths of contingencies at many times of one flight.

Between two clear times no path moves farther than the slack of both. Obstacles are enlarged by the deviation bound.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import cached_property, reduce
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import STATIONARY_SPEED
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.returning import IN_PLACE, Contingency, ReturnBy
from ipoa_mission.forecast.contingency.return_routes import WHERE, ReturnRoutes
from ipoa_mission.forecast.deviation.clearance_guarantee import PredictedFlight
from ipoa_mission.forecast.deviation.kept_limits import clearance_task, with_margins
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import rally_places
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.path_problem import PathTask
from ipoa_mission.planning.proof import Check, prove_ground
from ipoa_mission.world.airspace import NOTHING_NEAR, ROUNDING, Clearance

Paths: TypeAlias = NDArray[np.float64]  # (n, k, p, 3) [m]
Distances: TypeAlias = NDArray[np.float64]  # of legs (n, k, p - 1) [m]
ObstacleIndices: TypeAlias = NDArray[np.intp]  # nearest to legs, by index (n, k, p - 1)


@dataclass(frozen=True)
class Sampling:
    """The times of an order: each second, and finer where a shortfall may hide."""

    step_s: float = 1.0
    min_step_s: float = 0.05
    batch_size: int = 5_000  # limited by memory
    max_slack: float = 8.0  # greater slack is not distinguished [m]
    position_error: float = 10.0  # of the vehicle as it chooses its goal [m]
    chord_error: float = 0.02  # of the flown path to the lines between its sampled places [m]


class ReturnLeg(IntEnum):
    BRAKES = 0
    TURNS_BACK = 1
    CLIMBS = 2
    RETURNS = 3
    DESCENDS = 4


SAMPLING = Sampling()
GROUND = -2  # among the indices of obstacles; -1 is nothing


@dataclass(frozen=True, eq=False)
class StoppingPoints:
    """Places (n, 3) at `times` (n,) [s] on the way to items `seqs`, and the stopping points `stops`."""

    times: Vector
    places: Points
    stops: Points
    seqs: NDArray[np.intp]

    def seqs_at(self, times: Vector) -> NDArray[np.intp]:
        return np.asarray(self.seqs[np.clip(np.searchsorted(self.times, times), 0, len(self.seqs) - 1)])

    def at(self, times: Vector) -> tuple[Points, Points]:
        places, stops = (
            np.column_stack([np.interp(times, self.times, axis) for axis in points.T])
            for points in (self.places, self.stops)
        )
        return places, stops


@dataclass(frozen=True, eq=False)
class ContingencySamples:
    """One contingency, ordered at each of `times` (n,) [s after arming].

    `possible` (n, k): whether a path may be flown. `near`, `which`: the thing nearest to a leg; infinite, -1 for none.
    `slack` (n,): to the required distance [m]. `spread` (n,): subtracted from distances, for noise [m].
    """

    times: Vector
    paths: Paths
    possible: NDArray[np.bool_]
    near: Distances
    which: ObstacleIndices
    slack: Vector
    spread: Vector

    @property
    def clear(self) -> NDArray[np.bool_]:
        return np.asarray(self.slack >= 0.0)

    @property
    def same_as_next(self) -> NDArray[np.bool_]:
        possible, clear = self.possible, self.clear
        return np.asarray((possible[1:] == possible[:-1]).all(axis=1) & (clear[1:] == clear[:-1]))

    def gaps(self) -> Vector:
        """Return the middle of each interval that may hide a shortfall."""
        places = np.moveaxis(self.paths, 2, 0)  # limits the memory
        moved = reduce(np.maximum, (np.linalg.norm(np.diff(place, axis=0), axis=-1) for place in places))
        moved = np.where(self.possible[1:] | self.possible[:-1], moved, 0.0).max(axis=1)
        hidden = self.clear[:-1] & (self.slack[1:] + self.slack[:-1] < moved)
        asked = (hidden | ~self.same_as_next | self._next_to_nearest()) & (np.diff(self.times) > SAMPLING.min_step_s)
        return np.asarray((self.times[1:] + self.times[:-1])[asked] / 2)

    def _next_to_nearest(self) -> NDArray[np.bool_]:
        near = np.zeros(len(self.times), dtype=bool)
        for equal in np.split(np.arange(len(self.times)), np.flatnonzero(~self.same_as_next) + 1):
            least = equal[np.argmin(self.slack[equal])]
            near[max(least - 1, 0) : least + 1] = self.slack[least] < SAMPLING.max_slack
        return near[:-1]

    @classmethod
    def following(cls, parts: "Iterable[ContingencySamples]", count: int) -> "ContingencySamples":
        whole, begin = dict[str, NDArray[Any]](), 0
        for part in parts:
            own = {f.name: getattr(part, f.name) for f in fields(cls)}
            whole = whole or {name: np.empty((count, *some.shape[1:]), some.dtype) for name, some in own.items()}
            for name, some in own.items():
                whole[name][begin : begin + len(some)] = some
            begin += len(part.times)
        return cls(**whole)

    @classmethod
    def merged(cls, samples: "Sequence[ContingencySamples]") -> "ContingencySamples":
        order = np.argsort(np.concatenate([some.times for some in samples]), kind="stable")
        return cls(**{f.name: np.concatenate([getattr(some, f.name) for some in samples])[order] for f in fields(cls)})


class ContingencyPaths:
    """Compute contingency paths: `forecast.cached(ContingencyPaths)`. Times are of a flight with exact position."""

    def __init__(
        self, forecast: Forecast, enlarged: PathTask | None = None, shared: "ContingencyPaths | None" = None
    ) -> None:
        """Share flight and stopping points of `shared`, of another RTL or world."""
        self.forecast, self.mission, self._enlarged = forecast, forecast.mission, enlarged
        self.required, self.rally = forecast.world.limits.obstacle_distance, rally_places(self.mission)
        self._stops, self._samples = dict[Contingency, StoppingPoints](), dict[Contingency, ContingencySamples]()
        self.routes = ReturnRoutes(forecast, self.rally)
        self._flight = None if shared is None else shared.flight
        if shared is not None:
            self._stops = shared._stops
            if shared.forecast is forecast:
                self.routes = shared.routes
            else:
                self._samples = {by: some for by, some in shared._samples.items() if by is not Contingency.RTL}

    def returning(self, forecast: Forecast) -> "ContingencyPaths":
        """Return the paths of a forecast whose RTL alone differs: all else is taken over."""
        shared = None if any(item.command == Command.NAV_RETURN_TO_LAUNCH for item in self.mission.items) else self
        return forecast.cached(ContingencyPaths, lambda other: ContingencyPaths(other, self.enlarged, shared))

    @cached_property
    def enlarged(self) -> PathTask:
        return self._enlarged or with_margins(clearance_task(self.forecast.world), sharing=4.0)

    @cached_property
    def as_flown(self) -> "ContingencyPaths":
        """Paths without room for the deviation bound."""
        return ContingencyPaths(self.forecast, self.forecast.world, self)

    @property
    def flight(self) -> PredictedFlight:
        return self._flight or self.forecast.guarantee.flight

    @cached_property
    def in_air(self) -> tuple[float, float]:
        track = self.flight.pieces
        lifted = track.times[track.points[:, 2] > track.points[0, 2] + 1.0]  # [m]; lower it can end in place
        return (float(lifted[0]), float(lifted[-1])) if len(lifted) else (0.0, 0.0)

    def stops(self, contingency: Contingency = Contingency.RTL) -> StoppingPoints:
        if contingency not in self._stops:
            self._stops[contingency] = self._stopping_points(contingency)
        return self._stops[contingency]

    def _stopping_points(self, contingency: Contingency) -> StoppingPoints:
        flight, mission, autopilot = self.flight, self.mission, self.mission.autopilot
        (begin, end), step_s = self.in_air, 0.2
        times = np.append(np.arange(begin, end, step_s), end)
        then = np.minimum(times + autopilot.flies_on(contingency), end)
        before, places, at_then, after = map(flight.pieces.at, (then - step_s, times, then, then + step_s))
        velocity = (after - before) / (2 * step_s)
        speed = np.maximum(np.hypot(*velocity[:, :2].T), STATIONARY_SPEED)
        along = velocity[:, :2] / speed[:, None]
        gains = np.gradient(np.hypot(*velocity[:, :2].T), step_s) if len(times) > 1 else np.zeros(1)
        accel = (after[:, :2] + before[:, :2] - 2 * at_then[:, :2]) / step_s**2
        stops = at_then.copy()
        del before, after, at_then
        accel += along * (gains - (accel * along).sum(axis=1))[:, None]
        if not autopilot.guidance.climb_ends_at_once:  # else it stops within 0.5 m
            path = autopilot.braking_distance(mission.parameters, np.hypot(*velocity[:, :2].T), gains)
            stops[:, 2] += velocity[:, 2] * path / speed
        stops[:, :2] += autopilot.stopping_offset(mission.parameters, velocity[:, :2], accel, contingency)
        seqs = np.array([visit.seq for visit in flight.route.visits])
        ahead = np.minimum(np.searchsorted(flight.prediction.done, times), len(seqs) - 1)
        return StoppingPoints(times, places, stops, seqs[ahead])

    def why_unknown(self) -> str | None:
        if self.routes.why_unknown is not None:
            return self.routes.why_unknown
        vehicle, version, parameters = self.mission.autopilot, self.mission.firmware_version, self.routes.parameters
        is_fenced = self.mission.fence and vehicle.fence_margin(parameters, version) is not None
        return "returns round fences are not modeled" if is_fenced else None

    def samples(self, contingency: Contingency, between: tuple[float, float] | None = None) -> ContingencySamples:
        """Return a contingency at times in the air, without a hidden shortfall."""
        if between is None:
            if contingency not in self._samples:
                self._samples[contingency] = self.samples(contingency, self.in_air)
            return self._samples[contingency]
        begin, end = between
        samples = self.at(contingency, np.linspace(begin, end, max(2, round((end - begin) / SAMPLING.step_s) + 1)))
        while len(times := samples.gaps()):
            samples = ContingencySamples.merged([samples, self.at(contingency, times)])
        return samples

    def at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        some = np.array_split(times, math.ceil(len(times) / SAMPLING.batch_size) or 1)
        return ContingencySamples.following((self._at(contingency, part) for part in some), len(times))

    def _at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        places, stops = self.stops(contingency).at(times)
        paths = np.stack([places, stops], axis=1)[:, None]
        possible = np.ones((len(times), 1), dtype=bool)
        if contingency is Contingency.LAND:
            paths = np.concatenate([paths, self._ground_below(stops)[:, None, None]], axis=2)
        elif contingency is Contingency.RTL:
            paths, possible = self._returns(places, stops, self.stops(contingency).seqs_at(times))
        elif contingency is Contingency.SMART_RTL:
            home = np.broadcast_to(self.flight.pieces.points[0], (len(times), 1, 1, 3))
            paths = np.concatenate([paths, home], axis=2)
        near, which = self._near(paths)
        if contingency is Contingency.SMART_RTL:
            near[:, 0, 1], which[:, 0, 1] = self._flown_so_far(times)
        if contingency is Contingency.RTL:
            self._note_mission(times, near, which)
        spread = self._spread(times)
        near -= spread[:, None, None]
        slack = np.where(possible, near.min(axis=2) - self.required, np.inf).min(axis=1).clip(max=SAMPLING.max_slack)
        samples = ContingencySamples(times, paths, possible, near, which, slack, spread)
        return self._with_ground(samples, -1 if contingency is Contingency.RTL else 2)

    def exactly(self, contingency: Contingency, samples: ContingencySamples, n: int) -> Clearance:
        if contingency is Contingency.SMART_RTL:
            leg = int(np.argmin(samples.near[n, 0]))
            number, (x, y, z) = int(samples.which[n, 0, leg]), samples.paths[n, 0, leg].tolist()
            name = self.enlarged.airspace.obstacles[number].name if number >= 0 else "nothing"
            return Clearance(float(samples.near[n, 0, leg]), (x, y, z), name, leg)
        least = NOTHING_NEAR
        for path in samples.paths[n][samples.possible[n]]:
            nearer = self.enlarged.airspace.obstacle_clearance(path, within=least.distance)
            least = min(least, nearer, key=lambda clearance: clearance.distance)
        return least.minus(float(samples.spread[n]))

    def lowest(self, contingency: Contingency, samples: ContingencySamples, n: int) -> Check:
        paths = samples.paths[n, samples.possible[n], : -1 if contingency is Contingency.RTL else 2]
        checks = (check for path in paths for check in prove_ground(path, self.forecast.world))
        lowest = min(checks, key=lambda check: check.slack)
        return replace(lowest, nearest=lowest.nearest.minus(float(samples.spread[n])))

    def _spread(self, times: Vector) -> Vector:
        """Return how far flights spread within a second of `times` (n,) [m], beyond the enlarged obstacles."""
        pieces, within_s = self.flight.pieces, SAMPLING.step_s
        if self.flight.spread is None or self.enlarged is self.forecast.world:
            return np.zeros(len(times))
        spread = np.append(pieces.spread.max(axis=1), 0.0)
        first = np.clip(np.searchsorted(pieces.times, times - within_s) - 1, 0, len(spread) - 2)
        last = np.clip(np.searchsorted(pieces.times, times + within_s), first + 1, len(spread) - 1)
        return np.asarray(np.maximum.reduceat(spread, np.column_stack([first, last]).ravel())[::2])

    def goal(self, contingency: Contingency, samples: ContingencySamples, n: int) -> str:
        if contingency in IN_PLACE:
            return "here"
        names = ["home", *(f"rally point {k}" for k in range(1, len(self.rally) + 1))]
        names += [WHERE[by] for by in self.routes.kinds]
        possible = [name for goal, name in enumerate(names) if samples.possible[n, self._paths_to(goal)].any()]
        return " or ".join(dict.fromkeys(possible))

    def _near(self, paths: Paths) -> tuple[Distances, ObstacleIndices]:
        """Return a lower bound of each leg's distance to the nearest obstacle, and the obstacle's index.

        Slanting legs whose bound is below the required distance get their exact distance to that obstacle.
        """
        air, shape = self.enlarged.airspace, (*paths.shape[:2], paths.shape[2] - 1)
        starts, ends = paths[:, :, :-1].reshape(-1, 3), paths[:, :, 1:].reshape(-1, 3)
        near, which = air.legs_clearance(starts, ends, self.required + SAMPLING.max_slack)
        slanting = (starts[:, 2] != ends[:, 2]) & (starts[:, :2] != ends[:, :2]).any(axis=1)
        is_braking = np.arange(len(starts)) % shape[2] == ReturnLeg.BRAKES
        slanting &= is_braking | (np.abs(ends[:, 2] - starts[:, 2]) > 0.5)  # [m]
        for leg in np.flatnonzero(slanting & (near < self.required)):
            near[leg], _ = air.obstacles[which[leg]].leg_clearance(starts[leg], ends[leg])
        return near.reshape(shape), which.reshape(shape)

    def _flown_so_far(self, times: Vector, ahead: bool = False) -> tuple[Vector, NDArray[np.intp]]:
        """Return the least distance (n,) of the flown path up to each of `times` to an obstacle, and its index.

        `ahead`: of the path from then on.
        """
        near, which = (legs[:: -1 if ahead else 1, 0, 0] for legs in self._flown)
        nearest = np.maximum.accumulate(np.where(near <= np.minimum.accumulate(near), np.arange(len(near)), 0))
        until = np.clip(np.searchsorted(self.stops().times, times) - 1, 0, len(near) - 1)
        until = nearest[len(near) - 1 - until if ahead else until]
        return np.asarray(near[until] - SAMPLING.chord_error), np.asarray(which[until])

    def _note_mission(self, times: Vector, near: Distances, which: ObstacleIndices) -> None:
        """Reduce the distances of returns along the mission, in place, to those of the flown path.

        It passes inside the corners of the waypoints, which `ReturnRoutes.paths` joins by lines.
        """
        for by in self.routes.kinds:
            paths = self._paths_to(self.routes.goal_along(by))
            flown, obstacles = self._flown_so_far(times, ahead=by is ReturnBy.MISSION_FORWARD)
            climbs_near, climbs_which = near[:, paths, ReturnLeg.CLIMBS], which[:, paths, ReturnLeg.CLIMBS]  # views
            is_nearer = flown[:, None] < climbs_near
            np.copyto(climbs_near, flown[:, None], where=is_nearer)
            np.copyto(climbs_which, obstacles[:, None], where=is_nearer)

    @cached_property
    def _flown(self) -> tuple[Distances, ObstacleIndices]:
        places = self.stops().places
        if len(places) == 1:
            places = np.repeat(places, 2, axis=0)
        return self._near(np.stack([places[:-1], places[1:]], axis=1)[:, None])

    def _with_ground(self, samples: ContingencySamples, end: int) -> ContingencySamples:
        begin, last = self.flight.cruise_span
        near = samples.near.copy()
        which = samples.which.copy()
        slack = samples.slack.copy()
        in_cruise = np.flatnonzero((samples.times >= begin) & (samples.times <= last))
        paths, terrain = samples.paths[in_cruise, :, :end], self.forecast.world.airspace.terrain
        heights = terrain.legs_height(paths[:, :, :-1].reshape(-1, 3), paths[:, :, 1:].reshape(-1, 3))
        least = heights.reshape(*paths.shape[:2], paths.shape[2] - 1).min(axis=2)
        least -= samples.spread[in_cruise, None]
        low = samples.possible[in_cruise] & (least < self.forecast.world.limits.height_above_ground + ROUNDING)
        for at, k in np.argwhere(low).tolist():
            n = in_cruise[at]
            for check in prove_ground(samples.paths[n, k, :end], self.forecast.world):
                if (left := check.slack - samples.spread[n]) < min(slack[n], 0.0):
                    leg = min(check.nearest.leg, near.shape[2] - 1)
                    near[n, k, leg] = self.required + left
                    which[n, k, leg] = GROUND
                    slack[n] = left
        return replace(samples, near=near, which=which, slack=slack)

    @property
    def _shares(self) -> tuple[float, ...]:
        """Shares of the way back to the place of the order, at which it climbs."""
        return (0.0, 0.5, 1.0) if self.mission.autopilot.guidance.climbs_coming_back else (0.0,)

    @property
    def _variants(self) -> int:
        """Paths to one goal: of each share, then of each error over terrain."""
        return len(self._shares) + len(self.routes.off_terrain)

    def _paths_to(self, goal: int) -> slice:
        return slice(goal * self._variants, (goal + 1) * self._variants)

    def _returns(self, places: Points, stops: Points, seqs: NDArray[np.intp]) -> tuple[Paths, NDArray[np.bool_]]:
        """Return the paths of returns (`_paths_to` each goal), and which are possible (n, k)."""
        to_goals, paths = self.forecast.returns_from(stops), list[NDArray[np.float64]]()
        back = places - stops
        back[:, 2] = 0.0
        for path, up in zip(to_goals, (0.0, *(up for _, _, up in self.rally)), strict=True):
            over, beyond, ground = path[:, 1], path[:, 2], self._ground_below(path[:, 2])
            for offset in (share * back for share in self._shares):
                paths.append(np.stack([places, stops, stops + offset, over + offset, beyond, ground], axis=1))
            paths += [self.routes.over_terrain(places, stops, beyond, up, off) for off in self.routes.off_terrain]
        for by in self.routes.kinds:
            along = self.routes.paths(by, np.stack([places, stops, stops, stops], axis=1), seqs)
            paths += [along] * self._variants

        n_goals = len(to_goals) + len(self.routes.kinds)
        chosen = np.zeros((len(stops), n_goals), dtype=bool)
        for row, stop, seq in zip(chosen, stops, seqs, strict=True):
            row[list(self.routes.goals(stop, int(seq), SAMPLING.position_error))] = True
        possible = np.repeat(chosen, self._variants, axis=1)
        if self.routes.always_over_terrain:
            is_over_terrain = [False] * len(self._shares) + [True] * len(self.routes.off_terrain)
            possible &= np.tile(is_over_terrain, n_goals)
        most = max(path.shape[1] for path in paths)
        return np.stack([_padded(path, most) for path in paths], axis=1), possible

    def _ground_below(self, points: Points) -> Points:
        ground = self.enlarged.airspace.ground(points)
        return np.column_stack([points[:, :2], np.minimum(ground, points[:, 2])])


def _padded(path: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Repeat the last place but one of paths (n, p, 3), until they have `count` places and end as before."""
    repeated = np.repeat(path[:, -2:-1], count - path.shape[1], axis=1)
    return np.concatenate([path[:, :-1], repeated, path[:, -1:]], axis=1)
