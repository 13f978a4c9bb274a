"""Obstacles are enlarged by the deviation bound."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.autopilot import STATIONARY_SPEED
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import IN_PLACE, Contingency
from ipoa_mission.autopilot.returning import HOME, ReturnBy
from ipoa_mission.forecast.contingency.contingency_samples import (
    GROUND,
    SAMPLING,
    ContingencySamples,
    Distances,
    ObstacleIndices,
    Paths,
    ReturnLeg,
    StoppingPoints,
)
from ipoa_mission.forecast.contingency.enlarged_airspace import EnlargedAirspace
from ipoa_mission.forecast.contingency.return_routes import WHERE, ReturnRoutes
from ipoa_mission.forecast.deviation.clearance_guarantee import PredictedFlight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import interpolate
from ipoa_mission.geometry import Matrix, Points, Vector, as_place
from ipoa_mission.planning.proof import Check, prove_ground
from ipoa_mission.world.airspace import NOTHING_NEAR, ROUNDING, Clearance


class ContingencyPaths:
    """Paths and clearances of contingencies; times are of a flight with exact position."""

    def __init__(
        self, forecast: Forecast, enlarged: EnlargedAirspace | None = None, shared: "ContingencyPaths | None" = None
    ) -> None:
        """Share flight and stopping points of `shared`, of another RTL or world."""
        self.forecast = forecast
        self.mission = forecast.mission
        self.required = forecast.world.limits.obstacle_distance
        self.routes = ReturnRoutes(forecast)
        self._enlarged = enlarged
        self._flight: PredictedFlight | None = None
        self._stops = dict[Contingency, StoppingPoints]()
        self._samples = dict[Contingency, ContingencySamples]()
        if shared is not None:
            self._flight = shared.flight
            self._stops = shared._stops
            if shared.forecast is forecast:
                self.routes = shared.routes
            else:  # hold and LAND do not depend on the parameters of a return
                self._samples = {by: samples for by, samples in shared._samples.items() if by is not Contingency.RTL}

    def returning(self, forecast: Forecast) -> "ContingencyPaths":
        """Return the paths of a forecast whose RTL alone differs."""
        has_return_item = any(item.command == Command.NAV_RETURN_TO_LAUNCH for item in self.mission.items)
        shared = None if has_return_item else self
        return forecast.cached(ContingencyPaths, lambda other: ContingencyPaths(other, self.enlarged, shared))

    @cached_property
    def enlarged(self) -> EnlargedAirspace:
        return self._enlarged or self.forecast.world.cached(EnlargedAirspace.of)

    @cached_property
    def as_flown(self) -> "ContingencyPaths":
        """Paths without room for the deviation bound."""
        airspace = self.forecast.world.airspace
        return ContingencyPaths(self.forecast, EnlargedAirspace(airspace, airspace), self)

    @property
    def flight(self) -> PredictedFlight:
        return self._flight or self.forecast.guarantee.flight

    @cached_property
    def in_air(self) -> tuple[float, float]:
        """Return the first and the last time above 1 m [s]."""
        pieces = self.flight.pieces
        lifted = pieces.times[pieces.points[:, 2] > pieces.points[0, 2] + 1.0]
        return (float(lifted[0]), float(lifted[-1])) if len(lifted) else (0.0, 0.0)

    def stops(self, contingency: Contingency = Contingency.RTL) -> StoppingPoints:
        if contingency not in self._stops:
            self._stops[contingency] = self._stopping_points(contingency)
        return self._stops[contingency]

    def _stopping_points(self, contingency: Contingency) -> StoppingPoints:
        """Return places 0.2 s apart, and stops by velocity and acceleration where the vehicle begins to brake."""
        autopilot, parameters = self.mission.autopilot, self.mission.parameters
        pieces = self.flight.pieces
        begin, end = self.in_air
        step_s = 0.2
        times = np.append(np.arange(begin, end, step_s), end)
        obeyed = np.minimum(times + autopilot.braking_delay_s(contingency), end)
        before = pieces.at(obeyed - step_s)
        begins = pieces.at(obeyed)
        after = pieces.at(obeyed + step_s)
        velocity = (after - before) / (2 * step_s)
        horizontal_speed = np.hypot(*velocity[:, :2].T)
        speed = np.maximum(horizontal_speed, STATIONARY_SPEED)
        along = velocity[:, :2] / speed[:, None]
        speed_rate = np.gradient(horizontal_speed, step_s) if len(times) > 1 else np.zeros(1)
        accel = (after + before - 2 * begins) / step_s**2
        del before, after  # large
        accel[:, :2] += along * (speed_rate - (accel[:, :2] * along).sum(axis=1))[:, None]
        stops = begins + autopilot.stopping_displacement(parameters, velocity, accel, contingency)
        seqs = np.array([visit.seq for visit in self.flight.itinerary.visits])
        ahead = np.minimum(np.searchsorted(self.flight.prediction.done, times), len(seqs) - 1)
        farthest = stops
        if contingency is Contingency.LAND:
            farthest = begins + autopilot.farthest_landing(parameters, velocity)
            farthest[:, 2] = np.minimum(farthest[:, 2], stops[:, 2])
        return StoppingPoints(times, pieces.at(times), stops, seqs[ahead], farthest)

    def why_unknown(self) -> str | None:
        if self.routes.why_unknown is not None:
            return self.routes.why_unknown
        margin = self.mission.autopilot.fence_margin(self.forecast.itinerary.parameters, self.mission.firmware_version)
        return "returns round fences are not modeled" if self.mission.fence and margin is not None else None

    def samples(self, contingency: Contingency) -> ContingencySamples:
        """Return a contingency in the air, without a hidden shortfall."""
        if contingency not in self._samples:
            begin, end = self.in_air
            samples = self.at(contingency, np.linspace(begin, end, max(2, round((end - begin) / SAMPLING.step_s) + 1)))
            while len(times := samples.gaps()):
                samples = ContingencySamples.merge([samples, self.at(contingency, times)])
            self._samples[contingency] = samples
        return self._samples[contingency]

    def at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        """Return a contingency at increasing `times` (n,) [s]."""
        batches = np.array_split(times, math.ceil(len(times) / SAMPLING.batch_size) or 1)
        return ContingencySamples.merge([self._at(contingency, batch) for batch in batches])

    def _at(self, contingency: Contingency, times: Vector) -> ContingencySamples:
        """Return paths at `times` (n,), the distances of their legs less the excess deviation, and their slack."""
        places, stops = self.stops(contingency).at(times)
        if contingency is Contingency.RTL:
            paths, possible = self.returns(places, stops, self.stops(contingency).seqs_at(times))
        elif contingency is Contingency.SMART_RTL:
            home = np.broadcast_to(self.flight.pieces.points[0], (len(times), 3))
            paths = np.stack([places, stops, home], axis=1)[:, None]
            possible = np.ones((len(times), 1), dtype=bool)
        else:
            farthest = interpolate(times, self.stops(contingency).times, self.stops(contingency).farthest)
            paths = self.in_place(contingency, places, stops, farthest)
            possible = np.ones(paths.shape[:2], dtype=bool)

        excess = self._excess(times)
        near = np.empty((*possible.shape, paths.shape[2] - 1))
        which = np.empty(near.shape, dtype=np.intp)
        for height in np.unique(excess[:, 1]).tolist():
            rows = excess[:, 1] == height
            near[rows], which[rows] = self._near(paths[rows], possible[rows], excess[rows])
        if contingency is Contingency.SMART_RTL:
            near[:, 0, 1], which[:, 0, 1] = self._flown_so_far(times)
        if contingency is Contingency.RTL:
            self._reduce_to_flown_path(times, near, which)
        slack = np.where(possible, near.min(axis=2) - self.required, np.inf).min(axis=1).clip(max=SAMPLING.max_slack)
        slack -= excess[:, 0]
        near -= excess[:, :1, None]
        return self._with_ground(contingency, ContingencySamples(times, paths, possible, near, which, slack, excess))

    def exact_clearance(self, contingency: Contingency, samples: ContingencySamples, n: int) -> Clearance:
        if contingency is Contingency.SMART_RTL:
            braking = self.enlarged.obstacle_clearance(samples.paths[n, 0, :2])
            number = int(samples.which[n, 0, 1])
            name = self.enlarged.whole.obstacles[number].name if number >= 0 else "nothing"
            flown = Clearance(float(samples.near[n, 0, 1]), as_place(samples.paths[n, 0, 1]), name, 1)
            return min(braking, flown, key=lambda clearance: clearance.distance)
        return self.nearest(samples.paths[n][samples.possible[n]], *samples.excess[n].tolist())

    def nearest(self, paths: Iterable[Points], aside: float, height: float) -> Clearance:
        clearances = map(self.enlarged.taller(height).obstacle_clearance, paths)
        return min(clearances, key=lambda clearance: clearance.distance, default=NOTHING_NEAR).minus(aside)

    def lowest_height(self, contingency: Contingency, samples: ContingencySamples, n: int) -> Check:
        paths = samples.paths[n, samples.possible[n], : _end_of_flight(contingency)]
        return self.lowest(paths[:1] if contingency is Contingency.LAND else paths, float(samples.excess[n].max()))

    def lowest(self, paths: Iterable[Points], excess: float) -> Check:
        checks = (check for path in paths for check in prove_ground(path, self.forecast.world))
        lowest = min(checks, key=lambda check: check.slack)
        return replace(lowest, nearest=lowest.nearest.minus(excess))

    def _excess(self, times: Vector) -> Matrix:
        """Return the excess deviation within a second of `times` (n,), (n, 2) [m]; heights rounded up."""
        if self.flight.excess is None or self.enlarged.whole is self.forecast.world.airspace:
            return np.zeros((len(times), 2))
        pieces = self.flight.pieces
        height = np.ceil(2.0 * pieces.excess[:, 1:].max(axis=1)) / 2.0  # [m]
        excess = np.vstack([np.column_stack([pieces.excess[:, 0], height]), np.zeros(2)])
        first = np.clip(np.searchsorted(pieces.times, times - 1.0) - 1, 0, len(excess) - 2)
        last = np.clip(np.searchsorted(pieces.times, times + 1.0), first + 1, len(excess) - 1)
        alternating = np.maximum.reduceat(excess, np.column_stack([first, last]).ravel(), axis=0)
        return np.asarray(alternating[::2])  # maximum over each [first, last)

    def goal_names(self, contingency: Contingency, samples: ContingencySamples, n: int) -> str:
        """Return the possible goals, like "home or rally point 1"."""
        if contingency in IN_PLACE:
            return "here"
        if contingency is Contingency.SMART_RTL:
            return "home"
        names = ["home", *(f"rally point {k}" for k in range(1, len(self.forecast.itinerary.rally) + 1))]
        names += [WHERE[by] for by in self.routes.kinds]
        goals = self._goals[samples.possible[n]]
        return " or ".join(dict.fromkeys(names[goal] for goal in np.unique(goals)))

    def _near(self, paths: Paths, possible: NDArray[np.bool_], excess: Matrix) -> tuple[Distances, ObstacleIndices]:
        """Bound each possible leg's distance to an obstacle, exactly if slanting and too near; also its index."""
        enlarged = self.enlarged.taller(float(excess[0, 1]))  # of all rows
        within = self.required + SAMPLING.max_slack
        parts = paths.shape[2] - 1
        required = self.required + np.repeat(excess[np.nonzero(possible)[0], 0], parts)
        flown = paths[possible]
        starts = flown[:, :-1].reshape(-1, 3)
        ends = flown[:, 1:].reshape(-1, 3)
        near, which = enlarged.whole.legs_clearance(starts, ends, within)

        slanting = (starts[:, 2] != ends[:, 2]) & (starts[:, :2] != ends[:, :2]).any(axis=1)
        is_braking = np.arange(len(starts)) % parts == ReturnLeg.BRAKES
        slanting &= is_braking | (np.abs(ends[:, 2] - starts[:, 2]) > 0.5)  # [m]
        for leg in np.flatnonzero(slanting & (near < required)):
            near[leg], _ = enlarged.whole.obstacles[which[leg]].leg_clearance(starts[leg], ends[leg])
        for leg in np.flatnonzero((near < required) & enlarged.at_tight_place(starts, ends)):
            near[leg], which[leg] = enlarged.leg_clearance(starts[leg], ends[leg], within)
        distances = np.full((*possible.shape, parts), np.inf)
        distances[possible] = near.reshape(-1, parts)
        obstacles = np.full(distances.shape, -1)
        obstacles[possible] = which.reshape(-1, parts)
        return distances, obstacles

    def _flown_so_far(self, times: Vector, ahead: bool = False) -> tuple[Vector, NDArray[np.intp]]:
        """Return least distances (n,) of the path flown until `times`, or `ahead` after them, and obstacles."""
        distances, obstacles = self._flown
        legs = np.arange(len(distances))
        current = np.clip(np.searchsorted(self.stops().times, times) - 1, 0, legs[-1])
        if ahead:  # the same, on the path flown back
            distances = distances[::-1]
            obstacles = obstacles[::-1]
            current = legs[-1] - current
        is_nearest = distances <= np.minimum.accumulate(distances)
        nearest = np.maximum.accumulate(np.where(is_nearest, legs, 0))[current]  # of the legs up to the current one
        return distances[nearest] - SAMPLING.chord_error, obstacles[nearest]

    def _reduce_to_flown_path(self, times: Vector, near: Distances, which: ObstacleIndices) -> None:
        """Reduce distances of returns along the mission, in place, to the flown path's."""
        for path, by in enumerate(self.routes.kinds, start=-len(self.routes.kinds)):  # the last paths
            flown, obstacles = self._flown_so_far(times, ahead=by is ReturnBy.MISSION_FORWARD)
            is_nearer = flown < near[:, path, ReturnLeg.CLIMBS]
            near[is_nearer, path, ReturnLeg.CLIMBS] = flown[is_nearer]
            which[is_nearer, path, ReturnLeg.CLIMBS] = obstacles[is_nearer]

    @cached_property
    def _flown(self) -> tuple[Vector, NDArray[np.intp]]:
        """Return the distance of each leg between two places of `stops`, and its obstacle, (n,)."""
        places = self.stops().places
        places = places if len(places) > 1 else np.repeat(places, 2, axis=0)
        legs = np.stack([places[:-1], places[1:]], axis=1)[:, None]
        distances, obstacles = self._near(legs, np.full((len(legs), 1), True), np.zeros((len(legs), 2)))
        return distances[:, 0, 0], obstacles[:, 0, 0]

    def _with_ground(self, contingency: Contingency, samples: ContingencySamples) -> ContingencySamples:
        world = self.forecast.world
        end = _end_of_flight(contingency)
        begin_s, end_s = self.flight.cruise_span
        in_cruise = np.flatnonzero((samples.times >= begin_s) & (samples.times <= end_s))
        possible = samples.possible[in_cruise]
        possible[:, 1:] &= contingency is not Contingency.LAND  # the second path sinks
        rows, numbers = np.nonzero(possible)
        rows = in_cruise[rows]
        paths = samples.paths[rows, numbers, :end]
        excess = samples.excess.max(axis=1)
        enough = world.limits.height_above_ground + ROUNDING + float(excess.max(initial=0.0))
        legs = paths[:, :-1].reshape(-1, 3), paths[:, 1:].reshape(-1, 3)
        heights = world.airspace.terrain.legs_height(*legs, enough).reshape(-1, paths.shape[1] - 1)
        is_low = heights.min(axis=1) - excess[rows] < world.limits.height_above_ground + ROUNDING

        near, which, slack = samples.near.copy(), samples.which.copy(), samples.slack.copy()
        for n, k in zip(rows[is_low].tolist(), numbers[is_low].tolist(), strict=True):
            for check in prove_ground(samples.paths[n, k, :end], world):
                left = check.slack - excess[n]
                if left < min(slack[n], 0.0):
                    leg = min(check.nearest.leg, near.shape[2] - 1)
                    near[n, k, leg] = self.required + left
                    which[n, k, leg] = GROUND
                    slack[n] = left
        return replace(samples, near=near, which=which, slack=slack)

    @cached_property
    def _shares(self) -> tuple[float, ...]:
        return (0.0, 0.5, 1.0) if self.mission.autopilot.guidance.climbs_coming_back else (0.0,)

    @cached_property
    def _goals(self) -> NDArray[np.intp]:
        """The goal of each path of a return, (k,): those to home and rally points, then those along the mission."""
        direct = 1 + len(self.forecast.itinerary.rally)
        each = len(self._shares) + len(self.routes.off_terrain)
        return np.concatenate([np.repeat(np.arange(direct), each), direct + np.arange(len(self.routes.kinds))])

    def returns(self, places: Points, stops: Points, seqs: NDArray[np.intp]) -> tuple[Paths, NDArray[np.bool_]]:
        """Return paths (n, k, p, 3) to `_goals` (k,), p: ends of `ReturnLeg`; which are possible (n, k).

        To home and each rally point: one for each share, then one for each error over terrain.
        """
        begins = (places if self.mission.autopilot.guidance.climbs_coming_back else stops).copy()
        begins[:, 2] = places[:, 2]  # heights of a return count from that of the order
        ups = self.forecast.placed(np.array([HOME, *self.forecast.itinerary.rally]))[:, 2].tolist()
        paths = list[NDArray[np.float64]]()
        follows_terrain = list[bool]()
        for path, up in zip(self.forecast.returns_from(begins), ups, strict=True):
            paths += self._at_return_height(places, stops, path)
            for off in self.routes.off_terrain:
                paths.append(self.routes.over_terrain(places, path[:, 0], path[:, 2], up, off))
            follows_terrain += [False] * len(self._shares) + [True] * len(self.routes.off_terrain)
        starts = np.stack([places, stops, stops, stops], axis=1)
        paths += [self.routes.paths(by, starts, seqs) for by in self.routes.kinds]
        follows_terrain += [True] * len(self.routes.kinds)
        most = max(path.shape[1] for path in paths)
        for k, path in enumerate(paths):
            repeated = np.repeat(path[:, -2:-1], most - path.shape[1], axis=1)  # the last but one
            paths[k] = np.concatenate([path[:, :-1], repeated, path[:, -1:]], axis=1)
        possible = np.zeros((len(begins), len(paths)), dtype=bool)
        for row, begin, seq in zip(possible, begins, seqs.tolist(), strict=True):
            row[:] = np.isin(self._goals, list(self.routes.goals(begin, seq, SAMPLING.position_error)))
        if self.routes.always_over_terrain:
            possible &= follows_terrain
        return np.stack(paths, axis=1), possible

    def _at_return_height(
        self, places: Points, stops: Points, path: NDArray[np.float64]
    ) -> Iterator[NDArray[np.float64]]:
        begins, over, beyond = (path[:, n].copy() for n in range(3))
        ground = self._ground_below(beyond)
        for share in self._shares:
            begins[:, :2] = stops[:, :2] + share * (places - stops)[:, :2]
            over[:, :2] = begins[:, :2]
            yield np.stack([places, stops, begins, over, beyond, ground], axis=1)

    def in_place(self, contingency: Contingency, places: Points, stops: Points, farthest: Points) -> Paths:
        """Return paths of a hold (n, 1, p, 3), or of LAND (n, 2, 4, 3): down at `stops`, and sinking to `farthest`."""
        if contingency is Contingency.HOLD:
            corners = [places, stops]
            if self.mission.autopilot.guidance.holds_at_order:
                corners.append(np.column_stack([stops[:, :2], places[:, 2]]))
            return np.stack(corners, axis=1)[:, None]
        ground = self._ground_below(farthest)
        sunk = np.column_stack([farthest[:, :2], np.maximum(farthest[:, 2], ground[:, 2])])
        middle = places + (sunk - places) * [0.75, 0.75, 0.5]  # lower than flown
        level = np.stack([places, stops, stops, self._ground_below(stops)], axis=1)
        return np.stack([level, np.stack([places, middle, sunk, ground], axis=1)], axis=1)

    def _ground_below(self, points: Points) -> Points:
        return np.column_stack([points[:, :2], np.minimum(self.enlarged.whole.ground(points), points[:, 2])])


def _end_of_flight(contingency: Contingency) -> int | None:
    return {Contingency.RTL: -1, Contingency.HOLD: None}.get(contingency, 2)
