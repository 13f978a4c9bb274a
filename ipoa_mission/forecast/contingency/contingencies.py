import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.failsafe import COMPUTED, TIMED, Contingency, Failsafe
from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.contingency.contingency_samples import GROUND, ContingencySamples, StoppingPoints
from ipoa_mission.forecast.flight_energy import Consumption
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.flight_model import Z_90, FlightModel
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.world.airspace import Clearance

GROUND_NAME, NO_GOAL = "the ground", "unknown"


class Grade(StrEnum):
    """`CLEAR`: each possible flight keeps the required distance. `POSSIBLY_UNCLEAR`: some do not.

    `UNCLEAR`: the predicted path does not, at half or more of the possible times. `UNKNOWN`: the path is unknown.
    """

    CLEAR = "clear"
    POSSIBLY_UNCLEAR = "perhaps not clear"
    UNCLEAR = "not clear"
    UNKNOWN = "unknown"


def clear_at_any_time(times: Vector, clear: NDArray[np.bool_], tolerances: Vector) -> NDArray[np.bool_]:
    """Return whether no unclear one of increasing `times` is within `tolerances` of each, (n,) each [s]."""
    unclear = times[~clear]
    after = np.searchsorted(unclear, times - tolerances, side="left")
    return np.asarray(after == np.searchsorted(unclear, times + tolerances, side="right"))


def share_nearer(times: Vector, tolerances: Vector, evenly: Vector, nearer: NDArray[np.bool_]) -> Vector:
    """Return the share (n,) of `nearer` (m,), weighting `evenly` (m,) [s] by a normal density about `times` (n,) [s].

    Nine in ten of the density, and all weights, lie within ± `tolerances` (n,) [s].

    >>> share_nearer(np.array([5.0, 20.0]), np.full(2, 2.0), np.arange(0.0, 30.0), np.arange(30) < 5).round(2)
    array([0.33, 0.  ])
    """
    off = (evenly[None, :] - times[:, None]) / tolerances[:, None]
    weights = np.where(np.abs(off) <= 1.0, np.exp(-((Z_90 * off) ** 2) / 2.0), 0.0)
    return np.asarray((weights * nearer).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-12))


def failsafes_of(forecast: Forecast) -> tuple[Failsafe, ...]:
    mission = forecast.mission
    return mission.autopilot.failsafes(mission.parameters, mission.firmware_version)


def lands_by_choice(forecast: Forecast) -> tuple[Failsafe, ...]:
    return tuple(failsafe for failsafe in failsafes_of(forecast) if failsafe.lands_by_choice)


def who_lands(forecast: Forecast) -> str:
    return " and ".join(f"{by.cause} ({by.parameter} = {by.value:g})" for by in lands_by_choice(forecast))


def to_return_instead(forecast: Forecast) -> str:
    values = {failsafe.parameter: failsafe.returns_at for failsafe in lands_by_choice(forecast)}
    words = " and ".join(f"{name} = {value}" for name, value in values.items())
    return f"set {words} in the vehicle and under [vehicle.parameters], to return instead"


def contingencies_of(forecast: Forecast) -> tuple[Contingency, ...]:
    failsafes = failsafes_of(forecast)
    actions = [action for failsafe in failsafes for action in (failsafe.action, *failsafe.differs.values())]
    ordered = {contingency for action in actions for contingency in (action.contingency, *action.fallbacks)}
    if not failsafes:
        ordered = {Contingency.RTL, Contingency.LAND, Contingency.HOLD}
    return tuple(contingency for contingency in COMPUTED if contingency in ordered)


@dataclass(frozen=True)
class ContingencyRow:
    """A contingency with one goal and one `grade` from `from_s` to `to_s` [s after arming].

    `least_m`: least distance to the nearest thing, `to`, minus the deviation bound; a height where `to` is the ground.
    It is NaN where the path is unknown: `to` has the reason then. The vehicle touches down `touches_s` and disarms
    `duration_s` after the order (minimum, maximum). `energy_wh`: minimum and maximum, None where unknown. `lands`: east
    and north [m], None where the place is not fixed. `why_untimed`: why an RTL or LAND has no duration.
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
    why_untimed: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def clear(self) -> bool:
        return self.grade is Grade.CLEAR

    @property
    def leads(self) -> str:
        return {"here": "here", NO_GOAL: "goal unknown"}.get(self.goal, f"to {self.goal}")

    @property
    def keeps(self) -> str:
        return self._nearest(not self.clear and floor_cm(self.least_m) >= 0.0)

    @property
    def in_full(self) -> str:
        return f"{self.leads}: {self._nearest(with_required=True)}"

    def _nearest(self, with_required: bool) -> str:
        if math.isnan(self.least_m):
            return f"not clear: {self.to}"
        if not math.isfinite(self.least_m):
            return f"{self.grade}, nothing near"
        least = floor_cm(self.least_m)
        outside, inside = ("above", "below") if self.to == GROUND_NAME else ("from", "inside")
        relation = inside if least < 0.0 else outside
        required = f", {ceil_cm(self.required_m):.2f} m required" if with_required else ""
        return f"{self.grade}, {abs(least):.2f} m {relation} {self.to}{required}"

    def __str__(self) -> str:
        return f"{self.contingency} {self.from_s:.1f} to {self.to_s:.1f} s, {self.leads}: {self.keeps}"


class PredictedContingency(NamedTuple):
    """`duration_s`: until it disarms, `likely_s` in the likeliest way; `touches_s`: until it touches down.

    `used`: energy, None where unknown.
    """

    duration_s: tuple[float, float]
    used: Consumption | None
    touches_s: tuple[float, float] | None
    remarks: tuple[str, ...]
    likely_s: float


def predict_contingency(forecast: Forecast, contingency: Contingency, time: float) -> PredictedContingency:
    """Predict a contingency ordered at a time of the flight [s].

    Raises:
        BadInput: the time is not one of the flight.
        MissionError: as `Forecast.predicted_with`.
    """
    if not 0.0 <= time < np.inf:
        raise BadInput(f"expected a time of the flight from 0 s on, not {time:g} s")
    prediction = forecast.predicted_with(contingency, time)
    ends = float(prediction.done[-1])
    if time > ends + 1.0:  # [s], as flights with noise differ
        raise BadInput(f"expected a time of the flight, from 0 to {ends:.1f} s, not {time:g} s")
    lasts = max(float(prediction.low[-1]) - time, 0.0), max(float(prediction.high[-1]) - time, 0.0)
    touches = None
    if prediction.touched is not None and np.isfinite(prediction.touched[0]):
        first, _, last = prediction.touched
        touches = max(first - time, 0.0), max(last - time, 0.0)
    used = forecast.energy_of(forecast.placed_track(prediction.track.between(time, np.inf)))
    used = None if used is None else used.lasting(*lasts)
    return PredictedContingency(lasts, used, touches, prediction.remarks, float(prediction.done[-1]) - time)


class Contingencies:
    """Contingencies from each second of a flight; times are means over all flights."""

    def __init__(self, forecast: Forecast) -> None:
        self.forecast = forecast
        self.paths = forecast.cached(ContingencyPaths)
        self._rows = dict[Contingency, list[tuple[ContingencyRow, range]]]()

    @cached_property
    def _clocks(self) -> tuple[Vector, Vector]:
        """Times of the same places: with exact position, and in the mean."""
        tail_s = 1e6
        times = self.forecast.guarantee.flight.prediction.done, self.forecast.expected.done
        noise_free, mean = (np.concatenate([[0.0], done, done[-1:] + tail_s]) for done in times)
        return noise_free, mean

    def _mean(self, times: Vector) -> Vector:
        return np.asarray(np.interp(times, *self._clocks))

    @property
    def in_air(self) -> tuple[float, float]:
        begin, end = self._mean(np.array(self.paths.in_air))
        return float(begin), float(end)

    def stops(self, contingency: Contingency = Contingency.RTL) -> StoppingPoints:
        stops = self.paths.stops(contingency)
        return replace(stops, times=self._mean(stops.times))

    def samples(self, contingency: Contingency) -> ContingencySamples:
        samples = self.paths.samples(contingency)
        return replace(samples, times=self._mean(samples.times))

    def all_rows(self, timed: bool = True) -> tuple[ContingencyRow, ...]:
        return tuple(row for rows in self.by_contingency(timed).values() for row in rows)

    def by_contingency(self, timed: bool = True) -> dict[Contingency, tuple[ContingencyRow, ...]]:
        return {contingency: self.rows(contingency, timed) for contingency in contingencies_of(self.forecast)}

    def rows(self, contingency: Contingency, timed: bool = True) -> tuple[ContingencyRow, ...]:
        if (unknown := self._unknown(contingency)) is not None:
            return (unknown,)
        samples = self.samples(contingency)
        if contingency not in self._rows:
            grades = self._grades(contingency, samples)
            runs = _runs(samples.possible, grades)
            self._rows[contingency] = [(self._row(contingency, samples, run, grades[run.start]), run) for run in runs]
        rows = self._rows[contingency]
        return tuple(self._timed(row, samples, _extremes(samples, run)) if timed else row for row, run in rows)

    def _unknown(self, contingency: Contingency) -> ContingencyRow | None:
        if contingency is not Contingency.RTL or (why := self.paths.why_unknown()) is None:
            return None
        return ContingencyRow(contingency, *self.in_air, Grade.UNKNOWN, math.nan, self.paths.required, why, NO_GOAL)

    def _tolerances(self, times: Vector) -> Vector:
        """Return half the interval of nine flights in ten at each of `times` (n,) [s]."""
        prediction = self.forecast.expected
        scatter_s = self.forecast.mission.autopilot.part(FlightModel).takeoff_scatter_s
        return scatter_s + np.interp(times, prediction.done, (prediction.high - prediction.low) / 2)

    def _grades(self, contingency: Contingency, samples: ContingencySamples) -> list[Grade]:
        times = samples.times
        tolerances = self._tolerances(times)
        clear = clear_at_any_time(times, samples.clear, tolerances)
        grades = [Grade.CLEAR] * len(times)
        if not clear.all():
            shares = share_nearer(times[~clear], tolerances[~clear], *self._nearer(contingency, samples))
            for n, share in zip(np.flatnonzero(~clear).tolist(), shares, strict=True):
                grades[n] = Grade.UNCLEAR if share >= 0.5 else Grade.POSSIBLY_UNCLEAR
        return grades

    def _nearer(self, contingency: Contingency, samples: ContingencySamples) -> tuple[Vector, NDArray[np.bool_]]:
        """Return times 0.25 s apart, and whether the path is too near, (n,) each."""
        begin, end = samples.times[0], samples.times[-1]
        evenly = np.linspace(begin, end, max(2, round((end - begin) / 0.25) + 1))
        after = np.clip(np.searchsorted(samples.times, evenly), 1, len(samples.times) - 1)
        unclear = ~(samples.clear[after - 1] & samples.clear[after])
        nearer = np.zeros(len(evenly), dtype=bool)
        if unclear.any():
            noise_free, mean = self._clocks
            flown = self.paths.as_flown.at(contingency, np.interp(evenly[unclear], mean, noise_free))
            is_near = flown.near.min(axis=2) < self.paths.required
            nearer[unclear] = (is_near | ~flown.possible).all(axis=1)
        return evenly, nearer

    def _row(self, contingency: Contingency, samples: ContingencySamples, run: range, grade: Grade) -> ContingencyRow:
        reached = run if grade is Grade.CLEAR else self._within_tolerance(samples, run)
        near = min(self._nearest(contingency, samples, reached), key=lambda clearance: clearance.distance)
        least = near.distance
        required = self.paths.required
        to = near.what
        if GROUND in samples.which[reached.start : reached.stop]:
            on_ground = (n for n in reached if GROUND in samples.which[n])
            worst = min(on_ground, key=lambda n: float(samples.slack[n]))
            low = self.paths.lowest_height(contingency, samples, worst)
            least = low.nearest.distance
            required = low.required
            to = GROUND_NAME
        goal = self.paths.goal_names(contingency, samples, run.start)
        lands = None
        if goal != "here":
            east, north, _ = samples.paths[run.start][samples.possible[run.start]][0, -1]
            lands = float(east), float(north)
        begin = float(samples.times[run.start])
        end = float(samples.times[min(run.stop, len(samples.times) - 1)])
        return ContingencyRow(contingency, begin, end, grade, least, required, to, goal, lands)

    def _within_tolerance(self, samples: ContingencySamples, run: range) -> range:
        edges = samples.times[[run.start, run.stop - 1]]
        early, late = edges + np.array([-1.0, 1.0]) * self._tolerances(edges)
        begin = np.searchsorted(samples.times, early)
        end = np.searchsorted(samples.times, late, side="right")
        return range(min(int(begin), run.start), max(int(end), run.stop))

    def _nearest(self, contingency: Contingency, samples: ContingencySamples, run: range) -> list[Clearance]:
        slack = samples.slack[run.start : run.stop]
        inside = np.flatnonzero(slack <= -self.paths.required)  # their depth is not yet known
        most = 6
        few = np.linspace(0, len(inside) - 1, min(len(inside), most)).astype(int)
        picked = {*np.argsort(slack, kind="stable")[:most].tolist(), *inside[few].tolist()}
        return [self.paths.exact_clearance(contingency, samples, run[n]) for n in sorted(picked)]

    def _timed(self, row: ContingencyRow, samples: ContingencySamples, moments: Sequence[int]) -> ContingencyRow:
        if row.contingency not in TIMED:
            return row
        try:
            times = [float(samples.times[n]) for n in moments]
            flown = [predict_contingency(self.forecast, row.contingency, time) for time in times]
        except MissionError as error:
            return replace(row, why_untimed=str(error))
        used = [each.used.between for each in flown if each.used is not None]
        return replace(
            row,
            touches_s=_widest([each.touches_s for each in flown if each.touches_s is not None]),
            duration_s=_widest([each.duration_s for each in flown]),
            energy_wh=_widest([(each.low, each.high) for each in used]),
            remarks=tuple(dict.fromkeys(remark for each in flown for remark in each.remarks)),
        )

    def predicted(self, contingency: Contingency, time: float) -> PredictedContingency | None:
        try:
            return predict_contingency(self.forecast, contingency, float(np.clip(time, *self.in_air)))
        except MissionError:
            return None


def contingency_paths(forecast: Forecast) -> dict[Contingency, list[tuple[float, Points]] | str]:
    """Return the paths of the contingencies that the vehicle's failsafes order.

    Args:
        forecast: of a mission in a scenario.

    Returns:
        By contingency: orders [s after arming], at most 1 s apart, each with a possible path (n, 3) [m], or why the
        paths are unknown.

    Example:
        >>> from ipoa_mission import Forecast, contingency_paths, read_mission, read_scenario
        >>> forecast = Forecast(read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml"))
        >>> {str(contingency): len(paths) > 50 for contingency, paths in contingency_paths(forecast).items()}
        {'rtl': True, 'land': True, 'hold': True}
    """
    found = dict[Contingency, list[tuple[float, Points]] | str]()
    for contingency in contingencies_of(forecast):
        try:
            contingencies = forecast.cached(Contingencies)
            unknown = contingencies.paths.why_unknown() if contingency is Contingency.RTL else None
            if contingency is Contingency.SMART_RTL:
                unknown = "the way back along the flown path is not timed"
            samples = contingencies.samples(contingency)
            steps = zip(samples.times.tolist(), samples.paths, samples.possible, strict=True)
            orders = [(time, path) for time, paths, possible in steps for path in paths[possible]]
            found[contingency] = unknown or orders
        except MissionError as error:
            found[contingency] = str(error)
    return found


def _widest(intervals: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    return (min(low for low, _ in intervals), max(high for _, high in intervals)) if intervals else None


def _extremes(samples: ContingencySamples, run: range) -> list[int]:
    lengths = np.linalg.norm(np.diff(samples.paths[run.start : run.stop], axis=2), axis=-1).sum(axis=2)
    possible = samples.possible[run.start : run.stop]
    shortest = int(np.where(possible, lengths, np.inf).min(axis=1).argmin())
    longest = int(np.where(possible, lengths, 0.0).max(axis=1).argmax())
    return sorted({run[n] for n in (0, shortest, longest, -1)})


def _runs(possible: NDArray[np.bool_], grades: Sequence[Grade]) -> Iterator[range]:
    same = (possible[1:] == possible[:-1]).all(axis=1) & [grade is after for grade, after in pairwise(grades)]
    begin = 0
    for end in [*(np.flatnonzero(~same) + 1).tolist(), len(grades)]:
        yield range(begin, end)
        begin = end
