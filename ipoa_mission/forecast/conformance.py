"""Compare a flight with its forecast while it is flown."""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ipoa_mission.autopilot.commands import FLOWN_TO, LANDINGS, TAKEOFFS, Command, Frame, plain_frame
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.deviation.kept_limits import deviation_bound_of
from ipoa_mission.forecast.deviation.law import DeviationLaw
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.track import interpolate, pieces_of
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.geometry import Points, Vector, arc_lengths
from ipoa_mission.mission.flight_record import Deviation, DeviationKind


class ConformanceLimits(NamedTuple):
    """Beyond the deviation bound."""

    margin_factor: float = 2.0  # of the bound, added to it
    min_margin: float = 5.0  # [m]
    takeoff_factor: float = 2.0  # a take-off drifts farther
    late_factor: float = 2.0  # of the longest of nine flights in ten for an item
    min_leg_s: float = 10.0
    lasting_s: float = 1.0
    item_tolerance_s: float = 3.0  # early or late
    overshoot: float = 10.0  # beyond its braking distance, before it turns back to a missed item [m]
    exceeding_share: float = 0.01  # of flights, without a scenario's confidence


LIMITS = ConformanceLimits()
SPACING = 0.5  # of the corridor's points [m]


class _Leg(NamedTuple):
    """`goal`: None where nothing is compared. `excursion`: of the predicted flight away from it [m].

    `comes_back`: beyond it, where the vehicle may turn back [m]. `longest_s`: of nine flights in ten.
    """

    points: Points
    limits: Points
    goal: Vector | None
    excursion: float
    comes_back: float
    longest_s: float
    is_landing: bool
    is_compared: bool


class ConformanceMonitor:
    """Compare samples of one flight, in the order of their times, with its forecast.

    Args:
        forecast: of the flight.
        first: index of the item that it begins at; PX4 climbs to it from the ground as part of it.

    Raises:
        MissionError: its flight is unknown.

    Example:
        >>> import numpy as np
        >>> from ipoa_mission import Forecast, read_mission
        >>> monitor = ConformanceMonitor(Forecast(read_mission("missions/sitl.plan")))
        >>> flown = {0.0: (0.0, 0.0, 5.0), 5.0: (0.0, 40.0, 10.0), 6.0: (0.0, 41.0, 10.0)}
        >>> [str(found.kind) for t, at in flown.items() if (found := monitor.see(t, np.array(at), 0))]
        ['left-corridor']
    """

    def __init__(self, forecast: Forecast, first: int = 0) -> None:
        self._forecast = forecast
        self._first = first
        self._estimate = forecast.estimate
        self._visits = forecast.itinerary.visits
        if not self._visits:
            raise MissionError("the mission has no items", code="empty")
        safety = None if forecast.scenario is None else forecast.scenario.safety.chance
        self._chance = LIMITS.exceeding_share if safety is None else safety
        self._unknown = {item.seq for item in forecast.unknown}
        self._law = forecast.deviation_law
        frames = {plain_frame(item.frame) for item in forecast.mission.items if item.has_position}
        self._counts_from_home = Frame.GLOBAL not in frames
        self._knows_height = not forecast.itinerary.over_terrain
        self._times, self._points, self._bound = self._corridor()
        self._leg = cache(self._leg_to)
        self._visit = 0
        self._begun_s: float | None = None
        self._nearest = math.inf
        self._since: dict[DeviationKind, float] = {}
        self._reported: set[tuple[DeviationKind, int]] = set()
        self._detour: Points | None = None

    def local(self, at: Geodetic, height: float) -> Vector:
        up = self._forecast.mission.home.altitude + height if self._counts_from_home else at.altitude
        return self._forecast.frame.local(Geodetic(at.latitude_deg, at.longitude_deg, up))

    def interrupt(self) -> None:
        self._begun_s = None
        self._since.clear()

    def see(self, time: float, place: Vector, item: int | None) -> Deviation | None:
        """Compare one sample. Return a lasting deviation, the first time for each item and kind.

        Args:
            time: on any clock that does not stop [s].
            place: (3,) [m].
            item: index in `Mission.items`; None: as before.
        """
        self._turn_to(item, time, place)
        leg = self._leg(self._visit)
        if not leg.is_compared:
            return None
        distance = math.inf if leg.goal is None else float(np.linalg.norm(place - leg.goal))
        self._nearest = min(self._nearest, distance)
        beyond = self._beyond(leg, distance, time)
        outside = self._outside(leg, place, distance, time)
        seen = {each.kind: each for each in (self._late(leg, time, place), beyond, outside) if each is not None}
        self._since = {kind: self._since.get(kind, time) for kind in seen}
        for kind, deviation in seen.items():
            if time - self._since[kind] >= LIMITS.lasting_s and (kind, self._visit) not in self._reported:
                self._reported.add((kind, self._visit))
                return deviation
        return None

    def _turn_to(self, item: int | None, time: float, place: Vector) -> None:
        last = self._visit
        if item is not None and self._visits[last].seq != item + 1:
            seqs = [visit.seq for visit in self._visits]
            later = [n for n in (*range(last, len(seqs)), *range(last)) if seqs[n] == item + 1]
            self._visit = later[0] if later else last
        if self._begun_s is None or self._visit != last:
            self._detour = self._direct(place) if self._begun_s is None else None
            self._begun_s = time
            self._nearest = math.inf
            self._since.clear()

    def _late(self, leg: _Leg, time: float, place: Vector) -> Deviation | None:
        assert self._begun_s is not None
        lasted = time - self._begun_s
        allowed = LIMITS.late_factor * leg.longest_s
        if lasted <= allowed or (leg.is_landing and math.dist(place[:2], self._points[-1, :2]) < LIMITS.min_margin):
            return None  # the ground where it lands may be lower than known
        words = f"the vehicle flies to it for {lasted:.0f} s; nine flights in ten take {leg.longest_s:.0f} s"
        return self._deviation(DeviationKind.LATE, time, lasted, allowed, f"{words} at most")

    def _beyond(self, leg: _Leg, distance: float, time: float) -> Deviation | None:
        if leg.goal is None:
            return None
        moved = distance - self._nearest
        allowed = leg.excursion + leg.comes_back
        if moved <= allowed:
            return None
        if self._nearest <= LIMITS.overshoot:
            words = f"the vehicle passed it at {self._nearest:.1f} m without turning, and is {distance:.0f} m beyond it"
            return self._deviation(DeviationKind.PASSED, time, moved, allowed, words)
        words = f"the vehicle moves away from it: it was {self._nearest:.0f} m away, and is {distance:.0f} m"
        return self._deviation(DeviationKind.AWAY, time, moved, allowed, words)

    def _outside(self, leg: _Leg, place: Vector, distance: float, time: float) -> Deviation | None:
        comes_back = self._nearest <= LIMITS.overshoot and distance <= leg.excursion + leg.comes_back
        if comes_back or (leg.goal is None and self._detour is not None):
            return None
        points, limits = leg.points, leg.limits
        if self._detour is not None:
            points = np.vstack([points, self._detour])
            limits = np.vstack([limits, np.tile(limits.max(axis=0), (len(self._detour), 1))])
        lateral = np.hypot(*(place[:2] - points[:, :2]).T)
        higher = place[2] - points[:, 2]
        shares = lateral / limits[:, 0]
        if self._knows_height:
            shares = np.maximum(shares, np.where(higher > 0.0, higher / limits[:, 2], -higher / limits[:, 1]))
        if leg.is_landing:  # the ground where it lands may be lower than known
            shares = np.where(higher < 0.0, lateral / limits[:, 0], shares) if lateral[-1] < limits[-1, 0] else shares
        least = float(shares.min())
        if least <= 1.0:
            return None
        away = np.hypot(lateral, higher) if self._knows_height else lateral
        n = int(away.argmin())
        words = f"the vehicle is {away[n]:.1f} m from the predicted path, {lateral[n]:.1f} m to its side"
        if self._knows_height:
            words += f" and {abs(higher[n]):.1f} m {'above' if higher[n] > 0.0 else 'below'}"
        side, below, above = self._width(self._law)
        most = f"{100.0 * (1.0 - self._chance):g} % of flights stay within {side:.1f} m to the side"
        words += f"; {most}, {above:.1f} m above and {below:.1f} m below"
        return self._deviation(DeviationKind.OUTSIDE, time, float(away[n]), float(away[n]) / least, words)

    def _deviation(self, kind: DeviationKind, time: float, measured: float, allowed: float, words: str) -> Deviation:
        return Deviation(kind, self._visits[self._visit].seq, time, measured, allowed, words)

    def _width(self, law: DeviationLaw) -> Vector:
        bound = deviation_bound_of(law, self._chance)
        return np.array([law.lateral_bound(self._chance), bound.down, bound.up])

    def _corridor(self) -> tuple[Vector, Points, Points]:
        track = self._estimate.track
        flown = arc_lengths(track.points)
        evenly = np.interp(np.arange(0.0, flown[-1], SPACING), flown, track.times)
        times = np.unique(np.concatenate([track.times[:1], evenly, track.times[-1:]]))
        pieces = pieces_of(track)
        lateral_accel = np.interp(times, (pieces.times[:-1] + pieces.times[1:]) / 2, pieces.lateral_accel)
        bound = np.tile(self._width(self._law), (len(times), 1))
        goals = [item.done_s for n, item in enumerate(self._estimate.items) if self._goal(n) is not None]
        bound[times > max(goals, default=math.inf)] = self._width(self._law.after_cruise())
        bound[:, 0] *= self._law.widening(lateral_accel)
        return times, track.at(times), bound

    def _goal(self, visit: int) -> Vector | None:
        command = self._visits[visit].item.command
        if command not in FLOWN_TO - TAKEOFFS - LANDINGS or self._forecast.itinerary.program.leaves_open(visit):
            return None
        return np.array(self._forecast.placed(self._forecast.itinerary.program.places[visit]))

    def _leg_to(self, visit: int) -> _Leg:
        commands = [each.item.command for each in self._visits]
        items = self._estimate.items
        target = next((n for n in range(visit, len(items)) if self._goal(n) is not None), None)
        before = next((n for n in reversed(range(visit)) if commands[n] in FLOWN_TO), None)
        climbed_s = -math.inf
        if before is not None and 0 < self._first == self._visits[before].seq:
            climbed_s = items[before].done_s
            before = None
        begin = 0.0 if before is None else items[before].done_s
        end = math.inf if target is None else items[target].done_s
        first, last = np.searchsorted(self._times, [begin - LIMITS.item_tolerance_s, end + LIMITS.item_tolerance_s])
        span = slice(min(int(first), len(self._times) - 1), int(last) + 1)
        limits = self._bound[span] + np.maximum(LIMITS.margin_factor * self._bound[span], LIMITS.min_margin)
        if commands[visit] in TAKEOFFS:
            climbed_s = math.inf
        limits[self._times[span] <= climbed_s] *= LIMITS.takeoff_factor
        goal = None if target is None else self._goal(target)
        excursion = comes_back = 0.0
        if goal is not None and target is not None:
            excursion = self._excursion(goal, begin, end)
            mission = self._forecast.mission
            speeds = np.array([items[target].peak_speed])
            braking = mission.autopilot.braking_distance(mission.parameters, speeds, 0.0 * speeds)
            comes_back = LIMITS.overshoot + float(braking[0])
        longest = max(items[visit].high_s - begin + items[visit].missed.cost_s, LIMITS.min_leg_s)
        near = range(visit if before is None else before, visit + 1 if target is None else target + 1)
        visits = self._visits[near.start : near.stop]
        waits = any(each.item.command == Command.NAV_DELAY and not each.item.params[0] > 0.0 for each in visits)
        is_compared = not waits and self._unknown.isdisjoint(each.seq for each in visits)
        return _Leg(self._points[span], limits, goal, excursion, comes_back, longest, target is None, is_compared)

    def _excursion(self, goal: Vector, begin: float, end: float) -> float:
        first, last = np.searchsorted(self._times, [begin, end])
        away = np.linalg.norm(self._points[first : max(last, first + 1)] - goal, axis=1)
        return float((away - np.minimum.accumulate(away)).max(initial=0.0))

    def _direct(self, place: Vector) -> Points | None:
        if (goal := self._leg(self._visit).goal) is None:
            return place[None, :]
        over = np.array([place[0], place[1], max(place[2], goal[2])])
        corners = [place, over, goal] if self._visits[self._visit].item.is_takeoff else [place, goal]
        flown = arc_lengths(np.array(corners))
        return interpolate(np.arange(0.0, flown[-1] + SPACING, SPACING), flown, np.array(corners))
