"""How a flight can end before its mission does, from every second of it: what each way to end it keeps.

A vehicle that is told to end its flight flies on until it has braked. Then it returns (it climbs, flies to home or a
rally point and descends), lands where it stands, goes back along the way that it came, or holds its place. These ways
are looked at from times so near to each other that between two clear ones nothing can be nearer than is required.
Obstacles are larger by the tube of the autopilot.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby, pairwise

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.itinerary import rally_places
from ipoa_mission.forecast.stops import Stops, stops_of
from ipoa_mission.forecast.timing.flight_model import BrokenOff, FlightModel
from ipoa_mission.forecast.tube.room import with_room
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.planning.proof import prove_heights
from ipoa_mission.scenario.budget import flight_energy
from ipoa_mission.vehicles.ending import Ending
from ipoa_mission.vehicles.returning import ReturnBy
from ipoa_mission.world.airspace import NOTHING_NEAR

EVERY_S = 1.0  # between the looks at first [s]
NEAREST_S = 0.05  # looks are no nearer to each other [s]
TIGHT_PLACES = 4.0  # at so many tight places the tube has room on one of these ways
LIFTED = 1.0  # who is lower above where he took off can end his flight by standing still [m]
BACK = (0.0, 0.5, 1.0)  # shares of the way back to where it was told to return, at which it may climb
GOAL_DOUBT = 10.0  # it may be so far from where it is thought to be as it chooses its goal [m]
BEGUN_S = 0.6  # by so much its begin may be early or late: ArduCopter 4.8-dev is early by 0.5 s after its take-off
AROUND = 9  # looks at one time, from where the flight may be then
TIMED = 3  # looks of a row from which the flight is timed


@dataclass(frozen=True)
class EndingRow:
    """From `from_s` to `to_s` [s after arming] an ending leads to the same goal, and is clear or is not.

    `least_m` is what is kept at least of the nearest thing, `to`, once the tube is taken off: a distance, or where `to`
    is the ground a height; infinite where nothing is near, NaN where it is not known where the ending leads, and `to`
    says why. `duration_s` is from the order to the ground at the quickest and at the slowest, `energy_wh` the most that
    it takes; None where nobody can say. `lands`: east and north of home [m], None where it holds, or where the place
    changes all the time.
    """

    ending: Ending
    from_s: float
    to_s: float
    clear: bool
    least_m: float
    required_m: float
    to: str
    goal: str
    lands: tuple[float, float] | None = None
    duration_s: tuple[float, float] | None = None
    energy_wh: float | None = None


@dataclass(frozen=True, eq=False)
class _Look:
    """One ending ordered at one time: the ways on which it may be flown, each (k, 3), and what they keep."""

    time: float
    goal: str
    ways: tuple[Points, ...]
    least: float
    required: float
    to: str

    @property
    def slack(self) -> float:
        return self.least - self.required

    @property
    def is_clear(self) -> bool:
        return self.slack >= 0.0

    @property
    def lands(self) -> tuple[float, float]:
        return float(self.ways[0][-1][0]), float(self.ways[0][-1][1])


class Endings:
    """All ways in which one forecast's flight can end, in the world of its scenario."""

    def __init__(self, forecast: Forecast) -> None:
        self.forecast, self.mission = forecast, forecast.mission
        self.roomy = with_room(forecast.world, TIGHT_PLACES)
        self.required = forecast.world.limits.obstacle_distance
        self.rally = rally_places(self.mission)
        self._stopped: dict[Ending, Stops] = {}

    @cached_property
    def stops(self) -> Stops:
        """For a return, from every moment at which it is in the air."""
        return self.stops_for(Ending.RTL)

    def stops_for(self, ending: Ending) -> Stops:
        """For one ending, which brakes in its own way."""
        if ending not in self._stopped:
            self._stopped[ending] = stops_of(self.forecast, *self.in_air, ending)
        return self._stopped[ending]

    @cached_property
    def in_air(self) -> tuple[float, float]:
        """From when to when it is in the air [s]."""
        track = self.forecast.promise.flight.pieces
        lifted = track.times[track.points[:, 2] > track.points[0, 2] + LIFTED]
        return (float(lifted[0]), float(lifted[-1])) if len(lifted) else (0.0, 0.0)

    def why_unknown(self) -> str | None:
        """Why it is not known here where a return leads; None where it is."""
        vehicle, version = self.mission.autopilot, self.mission.firmware_version
        parameters = vehicle.book.by_old_names(self.mission.parameters)
        end = self.forecast.promise.flight.pieces.points[-1]
        here = (float(end[0]), float(end[1]), float(end[2]))
        by = vehicle.return_route(parameters, here, self.rally, version=version).by
        if by is not ReturnBy.DIRECT:
            return f"returns {by} are not modeled"
        if vehicle.returns_over_terrain(parameters) and not self.forecast.ground.is_level:
            return "returns that keep their height over the ground are not modeled"
        if self.mission.fence and vehicle.room_to_fences(parameters, version) is not None:
            return "returns round fences are not modeled"
        return None

    def looks(self, ending: Ending) -> list[_Look]:
        """At an ending from so many times that nothing is missed between two of them."""
        if ending is Ending.SMART_RTL:
            return list(self._back(self._spread(ending)))
        return list(self._spread(ending))

    def _spread(self, ending: Ending) -> Iterator[_Look]:
        begin, end = self.in_air
        first = np.linspace(begin, end, max(2, round((end - begin) / EVERY_S) + 1))
        looks = [self._look(ending, float(time)) for time in first]
        for pair in pairwise(looks):
            yield from self._between(ending, *pair)
        yield looks[-1]

    def _between(self, ending: Ending, one: _Look, other: _Look) -> Iterator[_Look]:
        """`one`, and as many looks before `other` as are needed."""
        if other.time - one.time > NEAREST_S and (one.goal != other.goal or self._may_hide(one, other)):
            middle = self._look(ending, (one.time + other.time) / 2)
            yield from self._between(ending, one, middle)
            yield from self._between(ending, middle, other)
        else:
            yield one

    @staticmethod
    def _may_hide(one: _Look, other: _Look) -> bool:
        """Whether a way between two clear ones may be nearer than is required, or one of them is not clear."""
        if one.is_clear != other.is_clear:
            return True
        moved = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in zip(one.ways, other.ways, strict=True))
        return one.is_clear and one.slack + other.slack < moved

    def _look(self, ending: Ending, time: float) -> _Look:
        place, stand = self.stops_for(ending).at(time)
        goal, ways = "here", [np.stack((place, stand))]
        if ending is Ending.LAND:
            ways = [np.stack((place, stand, self._ground_below(stand)))]
        elif ending is Ending.RTL:
            goal, ways = self._returns(place, stand)
        near = min((self.roomy.airspace.obstacle_clearance(way) for way in ways), key=lambda found: found.distance)
        look = _Look(time, goal, tuple(ways), near.distance, self.required, near.what)
        begin, end = self.forecast.promise.flight.way
        over_ground = [way[: -1 if ending is Ending.RTL else 2] for way in ways if begin <= time <= end]
        for check in (check for way in over_ground for check in prove_heights(way, self.forecast.world)):
            if check.limit == "ground" and check.slack < min(look.slack, 0.0):
                look = replace(look, least=check.nearest.distance, required=check.required, to="the ground")
        return look

    def _back(self, looks: Iterable[_Look]) -> Iterator[_Look]:
        """The ways back along the path: as near as it came on its way so far, or as it comes where it brakes."""
        flown = self.forecast.promise.flight.pieces
        begun, so_far = 0.0, NOTHING_NEAR
        for look in looks:
            near = self.roomy.airspace.obstacle_clearance(flown.part(begun, look.time).points, within=so_far.distance)
            begun, so_far = look.time, min(so_far, near, key=lambda found: found.distance)
            back = replace(look, goal="home", ways=(np.stack((*look.ways[0], flown.points[0])),))
            yield back if so_far.distance >= look.least else replace(back, least=so_far.distance, to=so_far.what)

    def _returns(self, place: Vector, stand: Vector) -> tuple[str, list[Points]]:
        """Every way that a return may take from there: to each goal that it may choose, each begun where it may."""
        goals = sorted(self._goals(stand))
        ways = self.forecast.returns_from(stand[None])[:, 0]
        back = np.array([*(place - stand)[:2], 0.0])
        shares = BACK if self.mission.autopilot.guidance.climbs_coming_back else BACK[:1]
        return " or ".join(_goal_name(goal) for goal in goals), [
            np.stack((place, stand, stand + share * back, over + share * back, beyond, self._ground_below(beyond)))
            for _, over, beyond in (ways[goal] for goal in goals)
            for share in shares
        ]

    def _goals(self, stand: Vector) -> set[int]:
        """The goals of a return from near there: 0 is home, n the rally point n."""
        parameters = self.mission.autopilot.book.by_old_names(self.mission.parameters)
        around = ((0.0, 0.0), (GOAL_DOUBT, 0.0), (-GOAL_DOUBT, 0.0), (0.0, GOAL_DOUBT), (0.0, -GOAL_DOUBT))
        east, north, up = (float(x) for x in stand)
        near = [(east + e, north + n, up) for e, n in around]
        chosen = (self.mission.autopilot.goal_of_return(parameters, here, self.rally) for here in near)
        return {0 if goal is None else goal + 1 for goal in chosen}

    def _ground_below(self, point: Vector) -> Vector:
        ground = self.roomy.airspace.ground(point[None])[0]
        return np.array([point[0], point[1], min(float(ground), float(point[2]))])

    def rows(self, ending: Ending, timed: bool = True) -> tuple[EndingRow, ...]:
        """One ending, from the first moment in the air to the last; with times and energy if `timed`.

        Raises:
            MissionError: the vehicle has no model of its flight.
        """
        if ending is Ending.RTL and (why := self.why_unknown()) is not None:
            return (EndingRow(ending, *self.in_air, False, math.nan, self.required, why, "unknown"),)
        return self._rows(ending, self.looks(ending), timed)

    def braking(self) -> tuple[EndingRow, ...]:
        """Where a return brakes before it turns home, in the same way; as rows of a hold."""
        return self._rows(Ending.HOLD, list(self._spread(Ending.SMART_RTL)), False)

    def _rows(self, ending: Ending, looks: list[_Look], timed: bool) -> tuple[EndingRow, ...]:
        looks = self._at_any_time(looks)
        runs = [list(run) for _, run in groupby(looks, key=lambda look: (look.is_clear, look.goal))]
        rows = []
        for run, after in zip(runs, [*runs[1:], [looks[-1]]], strict=True):
            rows.append(self._row(ending, run, after[0].time, timed))
        return tuple(rows)

    def _doubt(self, time: float) -> float:
        """By how much the flight may be early or late then [s]."""
        prediction = self.forecast.promise.flight.prediction
        return BEGUN_S + float(np.interp(time, prediction.done, (prediction.high - prediction.low) / 2))

    def _at_any_time(self, looks: list[_Look]) -> list[_Look]:
        """The looks as they are from where the vehicle may be then: what is not clear soon or has just been, is not."""
        unclear = [look for look in looks if not look.is_clear]
        told = []
        for look in looks:
            doubt = self._doubt(look.time)
            near = [one for one in (look, *unclear) if abs(one.time - look.time) <= doubt]
            worst = min(near, key=lambda one: one.slack)
            told.append(replace(look, least=worst.least, required=worst.required, to=worst.to))
        return told

    def at(self, ending: Ending, time: float, timed: bool = True) -> EndingRow:
        """An ending that is ordered at one time in the air [s]; as `rows`, and raises as it does."""
        if ending is Ending.RTL and (why := self.why_unknown()) is not None:
            return EndingRow(ending, time, time, False, math.nan, self.required, why, "unknown")
        begin, end = self.in_air
        around = np.clip(time + self._doubt(time) * np.linspace(-1.0, 1.0, AROUND), begin, end)
        looks = [self._look(ending, float(one)) for one in np.sort(np.append(around, time))]
        if ending is Ending.SMART_RTL:
            looks = list(self._back(looks))
        look = next(one for one in self._at_any_time(looks) if one.time == time)
        return self._row(ending, [look], time, timed)

    def _row(self, ending: Ending, run: list[_Look], until: float, timed: bool) -> EndingRow:
        worst = min(run, key=lambda look: look.slack)
        lands = None if run[0].goal == "here" else run[0].lands
        kept = worst.is_clear, worst.least, worst.required, worst.to
        row = EndingRow(ending, run[0].time, until, *kept, run[0].goal, lands)
        return self._timed(row, run) if timed and ending in (Ending.RTL, Ending.LAND) else row

    def _timed(self, row: EndingRow, run: list[_Look]) -> EndingRow:
        """The row with how long its flights last, as the vehicle's model flies them, and what they take."""
        picked = {round(share * (len(run) - 1)) for share in np.linspace(0.0, 1.0, TIMED)}
        try:
            flown = [self._flown(row.ending, run[n]) for n in sorted(picked)]
        except MissionError:
            return row
        used = [energy for _, energy in flown if energy is not None]
        lasts = min(low for (low, _), _ in flown), max(high for (_, high), _ in flown)
        return replace(row, duration_s=lasts, energy_wh=max(used, default=None))

    def _flown(self, ending: Ending, look: _Look) -> tuple[tuple[float, float], float | None]:
        """The least and the most time that an ending takes from one place [s], and its energy [Wh]."""
        forecast, mission = self.forecast, self.mission
        model, order = mission.autopilot.part(FlightModel), BrokenOff(look.time, ending)
        prediction = model.broken_off(forecast.itinerary, mission, forecast.wind, None, order)
        track = prediction.track
        after = track.times >= look.time
        used = flight_energy(
            forecast.world, track.times[after], track.points[after], track.speeds[after], mission.vehicle
        )
        lasts = float(prediction.low[-1]) - look.time, float(prediction.high[-1]) - look.time
        return lasts, None if used is None else used.energy_wh


def _goal_name(goal: int) -> str:
    return "home" if goal == 0 else f"rally point {goal}"
