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
    had = {contingency for action in actions for contingency in (action.contingency, *action.otherwise)}
    return tuple(contingency for contingency in LOOKED_AT if contingency in (had if failsafes else OF_ANY_VEHICLE))


@dataclass(frozen=True)
class ContingencyRow:
    """From `from_s` to `to_s` [s after arming] an ending leads to the same goal, and its `grade` stays the same.

    `least_m` is what is kept at least of the nearest thing, `to`, once the tube is taken off: a distance, or where `to`
    is the ground a height; infinite where nothing is near, NaN where it is not known where the ending leads, and `to`
    says why. From the order it stands on the ground after `touches_s`, and has disarmed after `duration_s`, each at the
    quickest and at the slowest; `energy_wh` is the least and the most that it takes; None where nobody can say.
    `lands`: east and north of home [m], None where it holds, or where the place changes all the time.
    """

    contingency: Contingency
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
        return f"{self.contingency} {self.from_s:.1f} to {self.to_s:.1f} s, {self.leads}: {self.keeps}"


class ContingencyBar(NamedTuple):
    """What a strip shows of one ending: its rows in the order of their times, and to where they lead."""

    contingency: Contingency
    leads: str
    rows: tuple[ContingencyRow, ...]


def bars_of(rows: Iterable[ContingencyRow]) -> tuple[ContingencyBar, ...]:
    """The rows ending by ending."""
    own: dict[Contingency, list[ContingencyRow]] = {}
    for row in rows:
        own.setdefault(row.contingency, []).append(row)
    return tuple(
        ContingencyBar(contingency, ", ".join(dict.fromkeys(row.leads for row in mine)), tuple(mine))
        for contingency, mine in own.items()
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

    def stops(self, contingency: Contingency = Contingency.RTL) -> StoppingPoints:
        """As those of `ways`."""
        stops = self.ways.stops(contingency)
        return replace(stops, times=self._in_mean(stops.times))

    def assessments(self, contingency: Contingency, between: tuple[float, float] | None = None) -> ContingencySamples:
        """As those of `ways`."""
        assessments = self.ways.assessments(
            contingency, None if between is None else tuple(self._if_sure(np.array(between)).tolist())
        )
        return replace(assessments, times=self._in_mean(assessments.times))

    def all_rows(self, timed: bool = True) -> tuple[ContingencyRow, ...]:
        """Every ending that the vehicle has, one after the other; as `rows`, and raises as it does."""
        return tuple(row for contingency in contingencies_of(self.forecast) for row in self.rows(contingency, timed))

    def rows(self, contingency: Contingency, timed: bool = True) -> tuple[ContingencyRow, ...]:
        """One ending, from the first moment in the air to the last; with times and energy if `timed`.

        Raises:
            MissionError: the vehicle has no model of its flight.
        """
        if contingency is Contingency.RTL and (why := self.ways.why_unknown()) is not None:
            return (
                ContingencyRow(contingency, *self.in_air, Grade.UNKNOWN, math.nan, self.ways.required, why, UNKNOWN),
            )
        assessments = self.assessments(contingency)
        if contingency not in self._rows:
            grades = self._grades(contingency, assessments)
            runs = _runs(assessments.taken, grades)
            self._rows[contingency] = [
                (self._row(contingency, assessments, run, grades[run.start]), run) for run in runs
            ]
        return tuple(self._timed(row, assessments, run) if timed else row for row, run in self._rows[contingency])

    def at(self, contingency: Contingency, time: float, timed: bool = True) -> ContingencyRow:
        """An ending that is ordered at one time in the air [s]; as `rows`, and raises as it does."""
        if contingency is Contingency.RTL and (why := self.ways.why_unknown()) is not None:
            return ContingencyRow(contingency, time, time, Grade.UNKNOWN, math.nan, self.ways.required, why, UNKNOWN)
        doubt = float(self._doubts(np.array([time]))[0])
        begin, end = np.clip([time - doubt, time + doubt], *self.in_air)
        now = self.ways.at(contingency, self._if_sure(np.clip([time], begin, end)))
        both = [self.assessments(contingency, (begin, end)), replace(now, times=np.clip([time], begin, end))]
        assessments = ContingencySamples.merged(both)
        middle = int(np.searchsorted(assessments.times, np.clip(time, begin, end)))
        row = self._row(
            contingency, assessments, range(len(assessments.times)), self._grades(contingency, assessments)[middle]
        )
        row = replace(row, from_s=time, to_s=time, goal=self.ways.goal(contingency, assessments, middle))
        return self._timed(row, assessments, range(middle, middle + 1)) if timed else row

    def _doubts(self, times: Vector) -> Vector:
        """By how much the flight may be early or late at each of these times (n,) [s]."""
        prediction = self.forecast.expected
        return BEGUN_S + np.interp(times, prediction.done, (prediction.high - prediction.low) / 2)

    def _grades(self, contingency: Contingency, assessments: ContingencySamples) -> list[Grade]:
        """Of each look (n,), from wherever the vehicle may be then."""
        times, doubts = assessments.times, self._doubts(assessments.times)
        clear, shares = clear_at_any_time(times, assessments.clear, doubts), np.zeros(len(times))
        if not clear.all():
            evenly, nearer = self._nearer(contingency, assessments)
            shares[~clear] = share_nearer(times[~clear], doubts[~clear], evenly, nearer)
        return graded(clear, shares)

    def _nearer(self, contingency: Contingency, assessments: ContingencySamples) -> tuple[Vector, NDArray[np.bool_]]:
        """Times (m,), evenly spaced, and whether the ways that are predicted from there come nearer than required."""
        begin, end = assessments.times[0], assessments.times[-1]
        evenly = np.linspace(begin, end, max(2, round((end - begin) / WEIGHED_S) + 1))
        after = np.clip(np.searchsorted(assessments.times, evenly), 1, len(assessments.times) - 1)
        asked = ~(assessments.clear[after - 1] & assessments.clear[after])
        nearer = np.zeros(len(evenly), dtype=bool)
        if asked.any():
            predicted = self.ways.as_flown.at(contingency, self._if_sure(evenly[asked]))
            nearer[asked] = predicted.all_nearer(self.ways.required)
        return evenly, nearer

    def _row(
        self, contingency: Contingency, assessments: ContingencySamples, run: range, grade: Grade
    ) -> ContingencyRow:
        """The row of the looks in a run, as the worst one has it at which the vehicle may be there."""
        seen = run if grade is Grade.CLEAR else self._seen(assessments, run)
        worst, near = min(self._nearest(contingency, assessments, seen), key=lambda found: found[1].distance)
        least, required, to = near.distance, self.ways.required, near.what
        if GROUND in assessments.which[seen.start : seen.stop]:
            on_ground = [n for n in seen if GROUND in assessments.which[n]]
            worst = min(on_ground, key=lambda n: float(assessments.spare[n]))
            low = self.ways.lowest(contingency, assessments, worst)
            least, required, to = low.nearest.distance, low.required, ON_GROUND
        goal, lands = self.ways.goal(contingency, assessments, run.start), None
        if goal != "here":
            east, north, _ = assessments.ways[run.start][assessments.taken[run.start]][0, -1]
            lands = float(east), float(north)
        until = float(assessments.times[min(run.stop, len(assessments.times) - 1)])
        return ContingencyRow(
            contingency, float(assessments.times[run.start]), until, grade, least, required, to, goal, lands
        )

    def _seen(self, assessments: ContingencySamples, run: range) -> range:
        """The looks of a run and those so soon before and after it that the vehicle may be there instead."""
        edges = assessments.times[[run.start, run.stop - 1]]
        early, late = edges + np.array([-1.0, 1.0]) * self._doubts(edges)
        begin, end = np.searchsorted(assessments.times, early), np.searchsorted(assessments.times, late, side="right")
        return range(min(int(begin), run.start), max(int(end), run.stop))

    def _nearest(
        self, contingency: Contingency, assessments: ContingencySamples, run: range
    ) -> list[tuple[int, Clearance]]:
        """The looks of a run that are nearest to something, and how near: one of these is the nearest of all."""
        spare = assessments.spare[run.start : run.stop]
        inside = np.flatnonzero(spare <= -self.ways.required)  # how deep is not known yet
        few = np.linspace(0, len(inside) - 1, min(len(inside), NEAREST_FEW)).astype(int)
        picked = {*np.argsort(spare, kind="stable")[:NEAREST_FEW].tolist(), *inside[few].tolist()}
        return [(run[n], self.ways.exactly(contingency, assessments, run[n])) for n in sorted(picked)]

    def _timed(self, row: ContingencyRow, assessments: ContingencySamples, run: range) -> ContingencyRow:
        """The row with how long its flights last, as the vehicle's model flies them, and what they take."""
        if row.contingency not in (Contingency.RTL, Contingency.LAND):
            return row
        picked = {run[round(share * (len(run) - 1))] for share in np.linspace(0.0, 1.0, TIMED)}
        try:
            flown = [flown_from(self.forecast, row.contingency, float(assessments.times[n])) for n in sorted(picked)]
        except MissionError:
            return row
        used = [one.used.between for one in flown if one.used is not None]
        stood = [one.touches for one in flown if one.touches is not None]
        touches = (min(low for low, _ in stood), max(high for _, high in stood)) if stood else None
        lasts = min(one.lasts[0] for one in flown), max(one.lasts[1] for one in flown)
        takes = (min(one.low for one in used), max(one.high for one in used)) if used else None
        return replace(row, touches_s=touches, duration_s=lasts, energy_wh=takes)

    def lasts(self, contingency: Contingency, time: float) -> tuple[float, float] | None:
        """The least and the most time that an ending takes which is ordered at a time [s]; None where nobody knows."""
        taken = self.takes(contingency, time)
        return None if taken is None else taken.lasts

    def takes(self, contingency: Contingency, time: float) -> Taken | None:
        """The same with what it takes of the battery, as `flown_from`."""
        try:
            return flown_from(self.forecast, contingency, float(np.clip(time, *self.in_air)))
        except MissionError:
            return None


def _runs(taken: NDArray[np.bool_], grades: Sequence[Grade]) -> Iterator[range]:
    """Numbers of looks one after the other that lead to the same goals (n, k) and have the same grade (n,)."""
    same = (taken[1:] == taken[:-1]).all(axis=1) & [one is other for one, other in pairwise(grades)]
    begin = 0
    for end in [*(np.flatnonzero(~same) + 1).tolist(), len(grades)]:
        yield range(begin, end)
        begin = end
