"""How a flight can end before its mission does, from every second of it: what each way to end it keeps.

A vehicle that is told to end its flight flies on until it has braked. Then it returns (it climbs, flies to home or a
rally point and descends), lands where it stands, goes back along the way that it came, or holds its place.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.centimeters import down, up
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.contingency_paths import GROUND, ContingencyPaths, ContingencySamples
from ipoa_mission.forecast.energy_budget import Taken, flown_from
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.grades import Grade, clear_at_any_time, graded, share_nearer
from ipoa_mission.forecast.stopping_points import StoppingPoints
from ipoa_mission.geometry import Vector
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.failsafe import Failsafe
from ipoa_mission.world.airspace import Clearance

BEGUN_S = 0.6  # by so much its begin may be early or late: ArduCopter 4.8-dev is early by 0.5 s after its take-off
NEAREST_FEW = 6  # so many looks of a row are measured to the millimeter
ON_GROUND, UNKNOWN = "the ground", "unknown"  # a thing and a goal
LONG = 1e6  # past the last item both clocks go on alike for so long [s]
TIMED = 3  # looks of a row from which the flight is timed
WEIGHED_S = 0.25  # between the times that are weighed for how likely it is that one is not clear [s]
#: What is looked at; the others go on, fall, or lead to where nobody knows.
LOOKED_AT = (Contingency.RTL, Contingency.LAND, Contingency.SMART_RTL, Contingency.HOLD)
OF_ANY_VEHICLE = frozenset({Contingency.RTL, Contingency.LAND, Contingency.HOLD})  # of whose failsafes nothing is known


def failsafes_of(forecast: Forecast) -> tuple[Failsafe, ...]:
    """What the vehicle does by itself, by the parameters of this mission; none where nothing is known of it."""
    mission = forecast.mission
    return mission.autopilot.failsafes(mission.parameters, mission.firmware_version)


def lands_by_choice(forecast: Forecast) -> tuple[Failsafe, ...]:
    """Its failsafes that land where it is, though with another value of their parameter they would return."""
    return tuple(one for one in failsafes_of(forecast) if one.lands_by_choice)


def who_lands(forecast: Forecast) -> str:
    """These failsafes in words: "critical battery (BATT_FS_CRT_ACT = 1)"."""
    return " and ".join(f"{one.cause} ({one.parameter} = {one.value:g})" for one in lands_by_choice(forecast))


def to_return_instead(forecast: Forecast) -> str:
    """What makes the same ones return, in words: "BATT_FS_CRT_ACT = 2 returns"."""
    values = {one.parameter: one.returns_at for one in lands_by_choice(forecast)}
    words = " and ".join(f"{name} = {value}" for name, value in values.items())
    return f"{words} return{'s' if len(values) == 1 else ''} instead, in the vehicle and under [vehicle.parameters]"


def contingencies_of(forecast: Forecast) -> tuple[Contingency, ...]:
    """The endings that the vehicle has, of those that are looked at: what a failsafe or a pilot's order leads to."""
    failsafes = failsafes_of(forecast)
    actions = [action for one in failsafes for action in (one.route, *one.differs.values())]
    had = {ending for action in actions for ending in (action.ending, *action.otherwise)}
    return tuple(ending for ending in LOOKED_AT if ending in (had if failsafes else OF_ANY_VEHICLE))


@dataclass(frozen=True)
class ContingencyRow:
    """From `from_s` to `to_s` [s after arming] an ending leads to the same goal, and its `grade` stays the same.

    `least_m` is what is kept at least of the nearest thing, `to`, once the tube is taken off: a distance, or where `to`
    is the ground a height; infinite where nothing is near, NaN where it is not known where the ending leads, and `to`
    says why. From the order it stands on the ground after `touches_s`, and has disarmed after `duration_s`, each at the
    quickest and at the slowest; `energy_wh` is the least and the most that it takes; None where nobody can say.
    `lands`: east and north of home [m], None where it holds, or where the place changes all the time.
    """

    ending: Contingency
    from_s: float
    to_s: float
    grade: Grade
    least_m: float
    required_m: float
    to: str
    goal: str
    lands: tuple[float, float] | None = None
    touches_s: tuple[float, float] | None = None
    duration_s: tuple[float, float] | None = None
    energy_wh: tuple[float, float] | None = None

    @property
    def clear(self) -> bool:
        """Whether nothing that the flight may do comes nearer than is required."""
        return self.grade is Grade.CLEAR

    @property
    def leads(self) -> str:
        """Where it leads: "here", "to home", "to home or rally point 1"; where nobody knows, that."""
        return {"here": "here", UNKNOWN: "nobody knows where"}.get(self.goal, f"to {self.goal}")

    @property
    def keeps(self) -> str:
        """Whether it is clear, and what is nearest: "not clear, 0.81 m inside mast"."""
        is_short = not self.clear and math.isfinite(self.least_m) and down(self.least_m) >= 0.0
        return f"{self._nearest}{self._required if is_short else ''}"

    @property
    def in_full(self) -> str:
        """All of it but the times: "to home: clear, 4.10 m from mast, 2.50 m required"."""
        return f"{self.leads}: {self._nearest}{self._required if math.isfinite(self.least_m) else ''}"

    @property
    def _nearest(self) -> str:
        if math.isnan(self.least_m):
            return f"not clear: {self.to}"
        if not math.isfinite(self.least_m):
            return f"{self.grade}, nothing near"
        least, is_ground = down(self.least_m), self.to == ON_GROUND
        beside = ("below" if is_ground else "inside") if least < 0.0 else "above" if is_ground else "from"
        return f"{self.grade}, {abs(least):.2f} m {beside} {self.to}"

    @property
    def _required(self) -> str:
        return f", {up(self.required_m):.2f} m required"

    def __str__(self) -> str:
        return f"{self.ending} {self.from_s:.1f} to {self.to_s:.1f} s, {self.leads}: {self.keeps}"


class ContingencyBar(NamedTuple):
    """What a strip shows of one ending: its rows in the order of their times, and to where they lead."""

    ending: Contingency
    leads: str
    rows: tuple[ContingencyRow, ...]


def bars_of(rows: Iterable[ContingencyRow]) -> tuple[ContingencyBar, ...]:
    """The rows ending by ending."""
    own: dict[Contingency, list[ContingencyRow]] = {}
    for row in rows:
        own.setdefault(row.ending, []).append(row)
    return tuple(
        ContingencyBar(ending, ", ".join(dict.fromkeys(row.leads for row in mine)), tuple(mine))
        for ending, mine in own.items()
    )


class Contingencies:
    """All ways in which one forecast's flight can end, in the world of its scenario: `forecast.cached(Contingencies)`.

    Times are those of the mean of all its flights, of which some come late to a waypoint, and none early; those of
    `ways` are of the flight that is sure where it is.
    """

    def __init__(self, forecast: Forecast) -> None:
        self.forecast, self.mission = forecast, forecast.mission
        self.ways = forecast.cached(ContingencyPaths)
        self._rows = dict[Contingency, list[tuple[ContingencyRow, range]]]()

    @cached_property
    def _clocks(self) -> tuple[Vector, Vector]:
        """The times of its items if it is sure where it is, and in the mean, each (n,) [s]."""
        sure, mean = self.forecast.promise.flight.prediction.done, self.forecast.expected.done
        return np.concatenate([[0.0], sure, sure[-1:] + LONG]), np.concatenate([[0.0], mean, mean[-1:] + LONG])

    def _in_mean(self, times: Vector) -> Vector:
        return np.asarray(np.interp(times, *self._clocks))

    def _if_sure(self, times: Vector) -> Vector:
        sure, mean = self._clocks
        return np.asarray(np.interp(times, mean, sure))

    @property
    def in_air(self) -> tuple[float, float]:
        """From when to when it is in the air [s]."""
        begin, end = self._in_mean(np.array(self.ways.in_air))
        return float(begin), float(end)

    def stops(self, ending: Contingency = Contingency.RTL) -> StoppingPoints:
        """As those of `ways`."""
        stops = self.ways.stops(ending)
        return replace(stops, times=self._in_mean(stops.times))

    def looks(self, ending: Contingency, between: tuple[float, float] | None = None) -> ContingencySamples:
        """As those of `ways`."""
        looks = self.ways.looks(ending, None if between is None else tuple(self._if_sure(np.array(between)).tolist()))
        return replace(looks, times=self._in_mean(looks.times))

    def all_rows(self, timed: bool = True) -> tuple[ContingencyRow, ...]:
        """Every ending that the vehicle has, one after the other; as `rows`, and raises as it does."""
        return tuple(row for ending in contingencies_of(self.forecast) for row in self.rows(ending, timed))

    def rows(self, ending: Contingency, timed: bool = True) -> tuple[ContingencyRow, ...]:
        """One ending, from the first moment in the air to the last; with times and energy if `timed`.

        Raises:
            MissionError: the vehicle has no model of its flight.
        """
        if ending is Contingency.RTL and (why := self.ways.why_unknown()) is not None:
            return (ContingencyRow(ending, *self.in_air, Grade.UNKNOWN, math.nan, self.ways.required, why, UNKNOWN),)
        looks = self.looks(ending)
        if ending not in self._rows:
            grades = self._grades(ending, looks)
            runs = _runs(looks.taken, grades)
            self._rows[ending] = [(self._row(ending, looks, run, grades[run.start]), run) for run in runs]
        return tuple(self._timed(row, looks, run) if timed else row for row, run in self._rows[ending])

    def at(self, ending: Contingency, time: float, timed: bool = True) -> ContingencyRow:
        """An ending that is ordered at one time in the air [s]; as `rows`, and raises as it does."""
        if ending is Contingency.RTL and (why := self.ways.why_unknown()) is not None:
            return ContingencyRow(ending, time, time, Grade.UNKNOWN, math.nan, self.ways.required, why, UNKNOWN)
        doubt = float(self._doubts(np.array([time]))[0])
        begin, end = np.clip([time - doubt, time + doubt], *self.in_air)
        now = self.ways.at(ending, self._if_sure(np.clip([time], begin, end)))
        both = [self.looks(ending, (begin, end)), replace(now, times=np.clip([time], begin, end))]
        looks = ContingencySamples.merged(both)
        middle = int(np.searchsorted(looks.times, np.clip(time, begin, end)))
        row = self._row(ending, looks, range(len(looks.times)), self._grades(ending, looks)[middle])
        row = replace(row, from_s=time, to_s=time, goal=self.ways.goal(ending, looks, middle))
        return self._timed(row, looks, range(middle, middle + 1)) if timed else row

    def _doubts(self, times: Vector) -> Vector:
        """By how much the flight may be early or late at each of these times (n,) [s]."""
        prediction = self.forecast.expected
        return BEGUN_S + np.interp(times, prediction.done, (prediction.high - prediction.low) / 2)

    def _grades(self, ending: Contingency, looks: ContingencySamples) -> list[Grade]:
        """Of each look (n,), from wherever the vehicle may be then."""
        times, doubts = looks.times, self._doubts(looks.times)
        clear, shares = clear_at_any_time(times, looks.clear, doubts), np.zeros(len(times))
        if not clear.all():
            evenly, nearer = self._nearer(ending, looks)
            shares[~clear] = share_nearer(times[~clear], doubts[~clear], evenly, nearer)
        return graded(clear, shares)

    def _nearer(self, ending: Contingency, looks: ContingencySamples) -> tuple[Vector, NDArray[np.bool_]]:
        """Times (m,), evenly spaced, and whether the ways that are predicted from there come nearer than required."""
        begin, end = looks.times[0], looks.times[-1]
        evenly = np.linspace(begin, end, max(2, round((end - begin) / WEIGHED_S) + 1))
        after = np.clip(np.searchsorted(looks.times, evenly), 1, len(looks.times) - 1)
        asked = ~(looks.clear[after - 1] & looks.clear[after])
        nearer = np.zeros(len(evenly), dtype=bool)
        if asked.any():
            predicted = self.ways.as_flown.at(ending, self._if_sure(evenly[asked]))
            nearer[asked] = predicted.all_nearer(self.ways.required)
        return evenly, nearer

    def _row(self, ending: Contingency, looks: ContingencySamples, run: range, grade: Grade) -> ContingencyRow:
        """The row of the looks in a run, as the worst one has it at which the vehicle may be there."""
        seen = run if grade is Grade.CLEAR else self._seen(looks, run)
        worst, near = min(self._nearest(ending, looks, seen), key=lambda found: found[1].distance)
        least, required, to = near.distance, self.ways.required, near.what
        if GROUND in looks.which[seen.start : seen.stop]:
            on_ground = [n for n in seen if GROUND in looks.which[n]]
            worst = min(on_ground, key=lambda n: float(looks.spare[n]))
            low = self.ways.lowest(ending, looks, worst)
            least, required, to = low.nearest.distance, low.required, ON_GROUND
        goal, lands = self.ways.goal(ending, looks, run.start), None
        if goal != "here":
            east, north, _ = looks.ways[run.start][looks.taken[run.start]][0, -1]
            lands = float(east), float(north)
        until = float(looks.times[min(run.stop, len(looks.times) - 1)])
        return ContingencyRow(ending, float(looks.times[run.start]), until, grade, least, required, to, goal, lands)

    def _seen(self, looks: ContingencySamples, run: range) -> range:
        """The looks of a run and those so soon before and after it that the vehicle may be there instead."""
        edges = looks.times[[run.start, run.stop - 1]]
        early, late = edges + np.array([-1.0, 1.0]) * self._doubts(edges)
        begin, end = np.searchsorted(looks.times, early), np.searchsorted(looks.times, late, side="right")
        return range(min(int(begin), run.start), max(int(end), run.stop))

    def _nearest(self, ending: Contingency, looks: ContingencySamples, run: range) -> list[tuple[int, Clearance]]:
        """The looks of a run that are nearest to something, and how near: one of these is the nearest of all."""
        spare = looks.spare[run.start : run.stop]
        inside = np.flatnonzero(spare <= -self.ways.required)  # how deep is not known yet
        few = np.linspace(0, len(inside) - 1, min(len(inside), NEAREST_FEW)).astype(int)
        picked = {*np.argsort(spare, kind="stable")[:NEAREST_FEW].tolist(), *inside[few].tolist()}
        return [(run[n], self.ways.exactly(ending, looks, run[n])) for n in sorted(picked)]

    def _timed(self, row: ContingencyRow, looks: ContingencySamples, run: range) -> ContingencyRow:
        """The row with how long its flights last, as the vehicle's model flies them, and what they take."""
        if row.ending not in (Contingency.RTL, Contingency.LAND):
            return row
        picked = {run[round(share * (len(run) - 1))] for share in np.linspace(0.0, 1.0, TIMED)}
        try:
            flown = [flown_from(self.forecast, row.ending, float(looks.times[n])) for n in sorted(picked)]
        except MissionError:
            return row
        used = [one.used.between for one in flown if one.used is not None]
        stood = [one.touches for one in flown if one.touches is not None]
        touches = (min(low for low, _ in stood), max(high for _, high in stood)) if stood else None
        lasts = min(one.lasts[0] for one in flown), max(one.lasts[1] for one in flown)
        takes = (min(one.low for one in used), max(one.high for one in used)) if used else None
        return replace(row, touches_s=touches, duration_s=lasts, energy_wh=takes)

    def lasts(self, ending: Contingency, time: float) -> tuple[float, float] | None:
        """The least and the most time that an ending takes which is ordered at a time [s]; None where nobody knows."""
        taken = self.takes(ending, time)
        return None if taken is None else taken.lasts

    def takes(self, ending: Contingency, time: float) -> Taken | None:
        """The same with what it takes of the battery, as `flown_from`."""
        try:
            return flown_from(self.forecast, ending, float(np.clip(time, *self.in_air)))
        except MissionError:
            return None


def _runs(taken: NDArray[np.bool_], grades: Sequence[Grade]) -> Iterator[range]:
    """Numbers of looks one after the other that lead to the same goals (n, k) and have the same grade (n,)."""
    same = (taken[1:] == taken[:-1]).all(axis=1) & [one is other for one, other in pairwise(grades)]
    begin = 0
    for end in [*(np.flatnonzero(~same) + 1).tolist(), len(grades)]:
        yield range(begin, end)
        begin = end
