"""Flight times of PX4 in AUTO.MISSION, measured on 1.17 and 1.18.

A run without noise gives the path, many with noise mean and deviation.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.commands import MULTICOPTER_LANDINGS
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.returning import ReturnBy
from ipoa_mission.compiled import records
from ipoa_mission.errors import EndlessFlight, MissionError, NotModeled
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.flight_model import (
    NEVER_MISSED,
    Z_90,
    FlightModel,
    Kinematics,
    Missed,
    Prediction,
    SharedStretches,
)
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Matrix, Points, Vector
from ipoa_mission.vehicles.px4_multicopter.dynamics import state
from ipoa_mission.vehicles.px4_multicopter.dynamics.navigator import HELD_OR_REACHED
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Motion
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits
from ipoa_mission.vehicles.px4_multicopter.simulation import RUNS, FlownMotions, MissionSimulation, fly_noise_free
from ipoa_mission.wind import Wind


class Px4Model(FlightModel):
    """PX4 in SIH; flown with noise unless `noise_free`."""

    scatter = (0.7, 0.02, 2.0)
    takeoff_scatter_s = 0.6
    simulated_lag = state.SIH.lag

    def __init__(self) -> None:
        self._latest = SharedStretches[FlownMotions](most=2048)
        self._latest_noisy = SharedStretches[tuple[Matrix, tuple[str, ...]]](most=4)

    def predicted(self, itinerary: Itinerary, wind: Wind, noise_free: bool) -> Prediction:
        simulation = MissionSimulation(itinerary, wind, state.NOISE_FREE if noise_free else state.SIH_SENSORS)
        motions, visits_done, remarks = simulation.mission_motions
        ends = list(visits_done)

        exact_run = fly_noise_free(simulation, self._latest)
        exact_times = exact_run.done[ends]
        samples = exact_run.samples
        times = exact_times[None, :]
        if itinerary.visits and not noise_free:
            fly_noisy = simulation.flight_of(motions, noisy=True)

            def fly_runs(*_: object) -> tuple[Matrix, tuple[str, ...]]:
                return _sample_runs(lambda seed: fly_noisy(simulation.at_start(seed)).done[ends], RUNS.known_share)

            mission = (simulation.noise_free_constants.sensors, records(motions, Motion).tobytes(), visits_done)
            ((times, lost),) = self._latest_noisy.fly(simulation.conditions, (times, ()), [mission], fly_runs)
            remarks += lost
        done = times.mean(axis=0)
        low, high = _interval(itinerary, times)

        track = Track.of(samples, _in_mean_time(samples[:, 0], exact_times, done))
        sample_times = np.ascontiguousarray(samples[:, 0])
        numbers = range(0 if noise_free else len(itinerary.visits))
        reasons = tuple(simulation.why_slow(n, exact_times, sample_times, samples) for n in numbers)
        return Prediction(done, low, high, reasons, track, remarks, _missed(itinerary, times))

    def predict_contingency(
        self, itinerary: Itinerary, wind: Wind, contingency: Contingency, time: float
    ) -> Prediction:
        simulation = MissionSimulation(itinerary, wind)
        if contingency is Contingency.RTL:
            if simulation.limits.land_delay < 0.0:
                raise EndlessFlight("with an RTL_LAND_DELAY below 0 RTL never lands")
            if itinerary.returns_by is not ReturnBy.DIRECT:
                raise NotModeled(f"the duration of returns {itinerary.returns_by} is not modeled well enough")
        motions = simulation.mission_motions.motions
        exact_times = simulation.flight_of(motions, noisy=False)(simulation.at_start(0)).done
        exact_steps = np.diff(exact_times)

        def once(seed: int) -> Vector:
            at_order, at_end = simulation.flown_with(contingency, time, seed)
            current = min(len(at_order.done), len(motions)) - 1  # index of the motion in progress
            in_progress_s = min(time - at_order.done[current], exact_steps[current])
            exact_order_time = exact_times[current] + in_progress_s
            end = at_end.done[-1]
            time_on_ground = end - at_end.progress.touched  # from touchdown until it disarms
            return np.array([exact_order_time, time_on_ground, end - time])

        sampled, remarks = _sample_runs(once, RUNS.contingency_share)
        exact_order_times, times_on_ground, durations = sampled.T
        clusters = _duration_clusters(durations)
        spans = np.array([_span(time, durations[runs], times_on_ground[runs]) for runs in clusters])  # (clusters, 2, 3)
        if len(clusters) > 1:
            each = zip(clusters, (spans[:, 0] - time).round().tolist(), strict=True)
            words = ", ".join(f"{low:.0f} to {high:.0f} s in {runs.sum()}" for runs, (low, _, high) in each)
            remarks += (f"ordered at {time:.1f} s, of {len(durations)} flights with noise it takes {words}",)
        likeliest = int(np.argmax([runs.sum() for runs in clusters]))
        mean_order_time = float(np.mean(exact_order_times[clusters[likeliest]]))
        _, exact_run = simulation.flown_with(contingency, mean_order_time, None)
        low = spans[:, :, 0].min(axis=0)
        high = spans[:, :, 2].max(axis=0)
        end, touched = spans[likeliest, :, 1]
        track = Track.of(exact_run.samples, exact_run.samples[:, 0] + time - mean_order_time)
        between = float(low[1]), float(touched), float(high[1])
        return Prediction(np.array([end]), low[:1], high[:1], ("",), track, remarks, touched=between)

    def excess_deviation(self, itinerary: Itinerary, wind: Wind, predicted: Prediction) -> Points | None:
        simulation = MissionSimulation(itinerary, wind)
        if not itinerary.visits or len(predicted.track.times) < 4:  # it does not move
            return None
        motions = simulation.mission_motions.motions
        ends = [0, *simulation.mission_motions.done]
        fly_on = simulation.flight_of(motions, noisy=True, sampled=True)
        done = [0.0, *predicted.done]
        runs = list[Matrix]()
        for seed in range(1, RUNS.of_median + 1):
            try:
                run = fly_on(simulation.at_start(seed))
            except MissionError:  # it circles a waypoint
                if seed > len(runs) + 1:
                    raise
                continue
            runs.append(np.column_stack([np.interp(run.samples[:, 0], run.done[ends], done), run.samples[:, 1:4]]))
        return excess_of(predicted.track, runs)

    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        limits = px4_limits(parameters)
        speed = min(speed or limits.cruise, limits.max_speed)
        return Kinematics(speed, limits.climb, limits.descent, limits.accel, limits.jerk)

    def airframe(self, altitude: float) -> state.Airframe:
        return state.SIH

    def median_times(self, itinerary: Itinerary) -> Vector:
        simulation = MissionSimulation(itinerary)
        fly_on = simulation.flight_of(simulation.mission_motions.motions, noisy=True)
        ends = list(simulation.mission_motions.done)
        starts = map(simulation.at_start, range(1, RUNS.of_median + 1))
        return np.asarray(np.median([fly_on(start).done[ends] for start in starts], axis=0))


def _sample_runs(once: Callable[[int], Vector], share: float) -> tuple[Matrix, tuple[str, ...]]:
    """Return times of runs (m, n), until the last's mean is known to a `share`, and remarks.

    Raise MissionError if most never end.
    """
    times = list[Vector]()
    lost = list[str]()
    for seed in range(1, RUNS.most + 1):
        if (seed - 1) % RUNS.batch == 0 and len(times) >= RUNS.least:
            ends = np.array([run[-1] for run in times])
            if ends.std() / math.sqrt(len(ends)) <= share * ends.mean():
                break
        try:
            times.append(once(seed))
        except MissionError as error:  # it circles a waypoint
            if seed > 2 * len(times) + RUNS.batch:
                raise
            lost.append(str(error))
    if not lost:
        return np.array(times), ()
    return np.array(times), (f"{len(lost)} of {len(lost) + len(times)} flights with noise did not end: {lost[0]}",)


def _duration_clusters(durations: Vector) -> list[NDArray[np.bool_]]:
    """Return masks of runs between wide gaps of durations (m,) [s], as of different ways home."""
    ordered = np.sort(durations)
    doubt = math.sqrt(RUNS.doubt_s**2 + (RUNS.doubt_share * ordered[-1]) ** 2 + RUNS.landing_s**2)
    (gaps,) = np.nonzero(np.diff(ordered) > 2.0 * RUNS.contingency_deviations * doubt)
    cluster = np.searchsorted(ordered[gaps + 1], durations, side="right")
    return [cluster == number for number in range(len(gaps) + 1)]


def _span(time: float, durations: Vector, times_on_ground: Vector) -> Matrix:
    """Return the earliest, mean and latest end and touchdown of runs (m,), (2, 3) [s]."""
    duration = np.mean(durations)
    doubt = RUNS.doubt_s**2 + (RUNS.doubt_share * duration) ** 2
    variances = [np.var(durations) + doubt + RUNS.landing_s**2, np.var(durations - times_on_ground) + doubt]
    means = time + duration - np.array([0.0, np.mean(times_on_ground)])
    half_widths = RUNS.contingency_deviations * np.sqrt(variances)
    return np.column_stack([means - half_widths, means, means + half_widths])


def _interval(itinerary: Itinerary, times: Matrix) -> tuple[Vector, Vector]:
    """Return the 90 % interval of each visit's end, (n,) each, of runs (m, n) [s]."""
    done = times.mean(axis=0)
    lands = np.array([visit.item.command in MULTICOPTER_LANDINGS for visit in itinerary.visits], dtype=bool)
    has_landed = np.maximum.accumulate(lands)
    doubt = RUNS.doubt_s**2 + (RUNS.doubt_share * done) ** 2 + RUNS.landing_s**2 * has_landed
    unsure = Z_90**2 * doubt
    if len(times) == 1:
        return done - np.sqrt(unsure), done + np.sqrt(unsure)
    below = Z_90 * times.std(axis=0)
    above = np.maximum(below, np.quantile(times, RUNS.late_quantile, axis=0) - done)
    return done - np.sqrt(below**2 + unsure), done + np.sqrt(above**2 + unsure)


def _in_mean_time(sample_times: Vector, exact_times: Vector, done: Vector) -> Vector:
    """Return times (m,) of the exact run in the mean run: each visit ends at `done`."""
    warped = np.interp(sample_times, [0.0, *exact_times], [0.0, *done])
    exact_end = exact_times[-1] if len(exact_times) else 0.0
    return np.asarray(warped + np.maximum(sample_times - exact_end, 0.0))


def _missed(itinerary: Itinerary, runs: Matrix) -> tuple[Missed, ...]:
    """Return the share of runs (m, n) [s] that miss each waypoint, and their mean delay."""
    if len(runs) == 1:
        return (NEVER_MISSED,) * len(itinerary.visits)
    lasted = np.diff(runs, axis=1, prepend=0.0)
    longer = lasted - np.median(lasted, axis=0)
    flown_to = np.array([visit.item.command in HELD_OR_REACHED for visit in itinerary.visits], dtype=bool)
    missed = (longer > RUNS.missed_s) & flown_to
    share = missed.mean(axis=0)
    cost = (longer * missed).sum(axis=0) / np.maximum(missed.sum(axis=0), 1)
    return tuple(Missed(*map(float, both)) for both in zip(share, cost, strict=True))


def excess_of(path: Track, runs: list[Matrix]) -> Points:
    """Return how far runs leave the path beyond the usual: to a side, below, above (n, 3) [m].

    A run is time on the path and place (m, 4).
    """
    every = 3  # samples
    sample_times = path.times[::every]
    places = path.points[::every]
    ahead = np.gradient(places[:, :2], axis=0)
    across = ahead[:, ::-1] * (-1.0, 1.0) / np.maximum(np.linalg.norm(ahead, axis=1), 0.01)[:, None]
    moments = sample_times + np.arange(-RUNS.nearest_s, RUNS.nearest_s + 0.1, 0.2)[:, None]
    offsets = np.empty((len(runs), len(sample_times), 2))
    for run, offset in zip(runs, offsets, strict=True):
        away = np.stack([np.interp(moments, run[:, 0], axis) for axis in run[:, 1:].T], axis=-1) - places
        nearest = away[np.argmin(np.sum(away**2, axis=-1), axis=0), np.arange(len(sample_times))]
        offset[:] = np.column_stack([np.sum(nearest[:, :2] * across, axis=1), nearest[:, 2]])
    side, up = offsets.mean(axis=0).T
    wider, higher = np.maximum(2.0 * offsets.std(axis=0) - RUNS.usual_deviation, 0.0).T
    beyond = (np.abs(side) + wider, np.maximum(higher - up, 0.0), np.maximum(higher + up, 0.0))
    return np.column_stack([np.interp(path.times, sample_times, column) for column in beyond])


MODEL = Px4Model()

#: The measured distance of PX4's flights from their predicted paths (docs/safety.md), and 0.1 m (docs/lab/kept.md).
LAW = DeviationLaw(
    lateral=Quantiles(
        (-1.5, 0.0, 0.12, 0.22, 0.42, 0.62, 1.07, 1.42, 1.72), (1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)
    ).longer(0.1),
    down=Quantiles((-2.5, 0.0, 0.75, 1.1, 1.35, 1.75, 2.1), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    up=Quantiles((-2.0, 0.0, 0.55, 1.0, 1.45, 2.1, 2.7), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.9, 1.75, 2.0, 2.4), (1.0, 0.5, 0.1, 0.05, 0.01)),
    highest=Quantiles((0.0, 1.0, 2.4, 2.85, 3.2), (1.0, 0.5, 0.1, 0.05, 0.01)),
    farthest=None,
    doubling_acceleration=8.0,
    after_cruise_factor=1.5,
    decorrelation_s=4.0,
    height_decorrelation_s=10.0,
    growth=(0.1, 0.03, 0.1),
    source="PX4 1.17 in its simulator (SIH): 92 flights of 21 missions, 1.5 to 18 m/s, and 22 in wind, by true place",
    strongest=6.0,
)
