"""Returns along the mission, and over terrain. The kind of return may change on the way."""

import math
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.commands import FLOWN_TO, Command
from ipoa_mission.autopilot.returning import HOME, MissionLanding, OverTerrain, ReturnBy, ReturnRoute
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places
from ipoa_mission.geometry import Place, Points, Vector, as_place
from ipoa_mission.mission.program import as_flown

WHERE = {ReturnBy.MISSION_FORWARD: "the landing along the mission", ReturnBy.MISSION_REVERSED: "home"}


class ReturnRoutes:
    def __init__(self, forecast: Forecast) -> None:
        self.forecast = forecast
        self.mission = forecast.mission

    def route(self, here: Place, seq: int) -> ReturnRoute:
        return self.forecast.itinerary.route_of_return(here, self._landing_after(seq))

    def goals(self, stop: Vector, seq: int, error: float) -> set[int]:
        """Return the goals possible with a position error [m]: 0 is home, the rally points follow, then `kinds`."""
        if not self.forecast.itinerary.rally and not self.kinds:
            return {0}
        east, north, up = as_place(self.mission.frame.moved(stop, self.forecast.frame))
        offsets = ((0.0, 0.0), (error, 0.0), (-error, 0.0), (0.0, error), (0.0, -error))
        return {self._goal_of(self.route((east + e, north + n, up), seq)) for e, n in offsets}

    def _goal_of(self, route: ReturnRoute) -> int:
        if route.by in self.kinds:
            return 1 + len(self.forecast.itinerary.rally) + self.kinds.index(route.by)
        return 0 if route.rally is None else 1 + route.rally

    @cached_property
    def kinds(self) -> tuple[ReturnBy, ...]:
        return tuple(by for by in WHERE if by in self._all_kinds)

    @cached_property
    def why_unknown(self) -> str | None:
        for by in (ReturnBy.LANDING, ReturnBy.LAND_IN_PLACE):
            if by in self._all_kinds:
                sinks = ", which begin during the landing," if by is ReturnBy.LANDING else ""
                return f"returns {by}{sinks} are not modeled"
        return None

    @cached_property
    def _all_kinds(self) -> frozenset[ReturnBy]:
        starts = [(HOME, 1), *((as_place(place), seq) for seq, place in self._places)]
        return frozenset(self.route(here, seq).by for here, seq in starts)

    def paths(self, by: ReturnBy, starts: NDArray[np.float64], seqs: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the paths (n, p, 3) from starts (n, k, 3)."""
        most = len(self._places) + 2
        paths = []
        for start, seq in zip(starts, seqs.tolist(), strict=True):
            begin = self.mission.frame.moved(start[-1], self.forecast.frame)
            nodes = self.forecast.placed(np.array(list(self._nodes(by, begin, seq))))
            paths.append([*start, *[start[-1]] * (most - len(nodes)), *nodes])
        return np.array(paths)

    @cached_property
    def off_terrain(self) -> tuple[float, ...]:
        """Return the possible errors of the followed height [m], close enough for the required distance."""
        if (over := self._over_terrain) is None:
            return ()
        many = math.ceil(over.margin / self.forecast.world.limits.obstacle_distance) + 1
        return tuple(np.linspace(-over.margin, over.margin, max(2, many)).tolist())

    @property
    def _over_terrain(self) -> OverTerrain | None:
        if self.forecast.ground.is_flat:
            return None
        return self.mission.autopilot.over_terrain(self.forecast.itinerary.parameters)

    @property
    def always_over_terrain(self) -> bool:
        return self._over_terrain is not None and self._over_terrain.always_over_terrain

    def over_terrain(self, places: Points, stops: Points, beyond: Points, up: float, off: float) -> NDArray[np.float64]:
        """Return the paths (n, p, 3) from places over `stops` straight to beyond, following the ground.

        `up`: height of the goal; `off`: error of the height over the ground [m].
        """
        ground = self.forecast.world.airspace.ground
        lower = self.forecast.world.airspace.ground(beyond)
        under = ground(stops)
        far = np.hypot(*(beyond - stops)[:, :2].T)
        return_height = partial(self.mission.autopilot.return_height, self.mission.complete_parameters)
        above = list(map(return_height, (stops[:, 2] - under).tolist(), far.tolist(), (up - lower).tolist()))
        along = np.linspace(0.0, 1.0, 61)[None, :, None]  # 60 legs
        paths = stops[:, None] + along * (beyond - stops)[:, None]
        paths[..., 2] = ground(paths.reshape(-1, 3)).reshape(paths.shape[:2]) + (np.array(above) + off)[:, None]
        down = np.column_stack([beyond[:, :2], np.minimum(lower, paths[:, -1, 2])])
        return np.concatenate([np.stack([places, stops, stops], axis=1), paths, down[:, None]], axis=1)

    def _nodes(self, by: ReturnBy, at: Vector, seq: int) -> Iterator[Vector]:
        if by is ReturnBy.MISSION_REVERSED:
            before = [place for number, place in reversed(self._places) if number < seq] or [self._places[0][1]]
            last, down = before[-1], np.zeros(3)
            yield from before
        else:
            *ahead, down = [place for number, place in self._places if number >= seq] or [self._places[-1][1]]
            last = ahead[-1] if ahead else at
            yield from ahead
        over = np.array([down[0], down[1], last[2]])
        yield over
        yield np.array([down[0], down[1], min(float(self.forecast.ground(over[None])[0]), last[2])])

    @cached_property
    def _places(self) -> list[tuple[int, Vector]]:
        places = item_places(as_flown(self.mission), self.mission.frame, self.forecast.ground)
        targets: list[tuple[int, Vector]] = []
        for seq, (item, place) in enumerate(zip(self.mission.items, places, strict=True), start=1):
            if item.command in FLOWN_TO and place is not None:
                targets.append((seq, place))
            if item.command == Command.NAV_LAND:
                break
        return targets

    def _landing_after(self, seq: int) -> MissionLanding | None:
        if not self._places or self.mission.items[self._places[-1][0] - 1].command != Command.NAV_LAND:
            return None
        starts = (n for n, item in enumerate(self.mission.items, 1) if item.command == Command.DO_LAND_START)
        return MissionLanding(as_place(self._places[-1][1]), next(starts, self._places[-1][0]) - seq, seq - 1)
