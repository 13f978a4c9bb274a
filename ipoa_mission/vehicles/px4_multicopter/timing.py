"""How long PX4 1.13 to 1.18 takes in AUTO.MISSION with a multicopter: its dynamics, flown again and again with noise.

Its flights are noisy: a waypoint counts once place *and* height are right, and for two minutes from take-off the height
of home is corrected by noisy measurements. So a mission is flown once without noise, which gives the path, and then
again and again with it, which gives times and spread.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ipoa_mission.compiled import jit_if_faster
from ipoa_mission.compiled.records import records
from ipoa_mission.errors import MissionError, NotModeled
from ipoa_mission.forecast.itinerary.itinerary import Itinerary, flying_already
from ipoa_mission.forecast.timing.flight_model import Abort
from ipoa_mission.forecast.timing.prediction import Missed, Prediction
from ipoa_mission.forecast.timing.reasons import corner_deg, slow_because
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.mission.commands import Command
from ipoa_mission.vehicles.contingency import Contingency
from ipoa_mission.vehicles.parameters import Parameters
from ipoa_mission.vehicles.px4_multicopter.dynamics.airframe import KNOWS, SIH, SIH_SENSES, Airframe, SensorModel
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import fly
from ipoa_mission.vehicles.px4_multicopter.dynamics.navigator import (
    FLOWN_TO,
    law,
    plan,
    stopping_place,
    way_down,
    way_home,
    with_another_end,
)
from ipoa_mission.vehicles.px4_multicopter.dynamics.speeds import speed_to
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Enu, Law, Level, Order
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits
from ipoa_mission.vehicles.px4_multicopter.parameter_table import LEAST_HOLD
from ipoa_mission.vehicles.version import Version
from ipoa_mission.wind import CALM, Wind

ALONG_MISSION = frozenset({1.0, 2.0, 3.0, 4.0})  # RTL_TYPE
STEP = 0.04  # [s]
SAMPLE_STEPS = 3  # a sample of the track every so many steps


LANDINGS = frozenset({Command.NAV_LAND, Command.NAV_RETURN_TO_LAUNCH})


@dataclass(frozen=True)
class NoisyRuns:
    """How often an itinerary is flown with noise, and what the spread of the times makes of the interval."""

    most: int = 90
    batch: int = 6  # after every so many it is asked whether they will do:
    known_share: float = 0.003  # the standard error of the mean is this share of it
    broken_off_share: float = 0.008  # the same of an ending that is ordered
    doubt_s: float = 0.8  # what the model itself may be off by, standard deviation: this,
    doubt_share: float = 0.0125  # and this share of the time
    landing_s: float = 1.6  # what landings differ by beyond that, in recorded flights
    interval_deviations: float = 1.645  # nine in ten are so many standard deviations on either side of the mean
    late_quantile: float = 0.93  # of the runs, where misses make it later than those deviations
    broken_off_deviations: float = 2.3  # the same of endings that are ordered, as flown
    missed_s: float = 3.0  # a waypoint that takes so much longer than in most runs has been missed


RUNS = NoisyRuns()


def fly_px4(
    route: Itinerary,
    parameters: Parameters,
    wind: Wind = CALM,
    fast: bool | None = None,
    airframe: Airframe = SIH,
    senses: SensorModel = SIH_SENSES,
    version: Version | None = None,
) -> Prediction:
    """Fly the itinerary as PX4 does; `fast` is as in `estimate`. One that `KNOWS` where it is is flown only once.

    Raises:
        BadInput: an item never ends, or a parameter has no sense.
        MissionError: the vehicle does not get on, as against a wind stronger than it can fly.
    """
    flights = Flights(route, parameters, wind, airframe, senses, version)
    smooth, samples = flights.prepared(False, fast)(0)
    once = flights.prepared(True, fast, RUNS.most * samples[-1, 0] / STEP)
    remarks = list(flights.plan.remarks)
    times: list[Vector] = []
    for seed in range(1, RUNS.most + 1 if senses != KNOWS and route.visits else 1):
        if (seed - 1) % RUNS.batch == 0 and _known(times):
            break
        try:
            times.append(once(seed)[0])
        except MissionError as lost:  # circling a waypoint that is too small to be hit
            if seed > 2 * len(times) + RUNS.batch:
                raise
            remarks.append(f"some flights would not end: {lost}")
    runs = np.array(times or [smooth])
    done = runs.mean(axis=0)
    lands = np.array([visit.item.command in LANDINGS for visit in route.visits], dtype=bool)
    doubt = RUNS.doubt_s**2 + (RUNS.doubt_share * done) ** 2 + RUNS.landing_s**2 * np.maximum.accumulate(lands)
    below = RUNS.interval_deviations * runs.std(axis=0)
    above = np.maximum(below, np.quantile(runs, RUNS.late_quantile, axis=0) - done)  # who misses a waypoint is late
    unsure = RUNS.interval_deviations**2 * doubt
    warped = np.interp(samples[:, 0], [0.0, *smooth], [0.0, *done])
    warped += np.maximum(samples[:, 0] - (smooth[-1] if len(smooth) else 0.0), 0.0)
    track = Track.of(samples, warped)
    clock = np.ascontiguousarray(samples[:, 0])
    reasons = tuple(flights.why_slow(n, smooth, clock, samples) for n in range(len(route.visits)))
    low, high = done - np.sqrt(below**2 + unsure), done + np.sqrt(above**2 + unsure)
    return Prediction(done, low, high, reasons, track, tuple(remarks), _missed(route, runs))


def fly_aborted(
    route: Itinerary,
    parameters: Parameters,
    wind: Wind,
    fast: bool | None,
    airframe: Airframe,
    order: Abort,
    version: Version | None = None,
) -> Prediction:
    """Fly the itinerary up to a moment, and then what is ordered, in the mean of its noise: each from where it is then.

    Raises:
        BadInput, MissionError: as `fly_px4` does; or what is ordered has no end.
    """
    flights = Flights(route, parameters, wind, airframe, version=version)
    if order.contingency is Contingency.RTL:
        if flights.limits.land_delay < 0.0:
            raise MissionError("with an RTL_LAND_DELAY below 0 it waits over its goal for ever", code="endless-flight")
        if parameters.get("RTL_TYPE", 0.0) in ALONG_MISSION:
            raise NotModeled("how long returns along the mission last is not known well enough")
    quiet = flights.flown(False, fast)(0).done
    steps = np.diff(quiet)
    lasted, stood, when = list[float](), list[float](), list[float]()
    for seed in range(1, RUNS.most + 1):
        if (seed - 1) % RUNS.batch == 0 and _known([np.array([time]) for time in lasted], RUNS.broken_off_share):
            break
        with suppress(MissionError):
            run, begun = flights.broken_off(order.contingency, order.time, seed, fast)
            lasted.append(float(run.done[-1]) - order.time)
            stood.append(float(run.done[-1]) - run.touched)
            when.append(float(quiet[begun - 1] + min(order.time - run.done[begun - 1], steps[begun - 1])))
    then = float(np.mean(when)) if when else order.time
    last, _ = flights.broken_off(order.contingency, then, None, fast)
    lasted, stood = lasted or [float(last.done[-1]) - then], stood or [float(last.done[-1]) - last.touched]
    mean = float(np.mean(lasted))
    doubt = RUNS.doubt_s**2 + (RUNS.doubt_share * mean) ** 2
    half = RUNS.broken_off_deviations * math.sqrt(float(np.var(lasted)) + doubt + RUNS.landing_s**2)
    touched = order.time + mean - float(np.mean(stood))
    off = RUNS.broken_off_deviations * math.sqrt(float(np.var(np.subtract(lasted, stood))) + doubt)
    samples = last.samples
    track = Track.of(samples, samples[:, 0] + order.time - then)
    end = np.array([order.time + mean])
    return Prediction(end, end - half, end + half, ("",), track, touched=(touched - off, touched, touched + off))


def _known(times: list[Vector], share: float = RUNS.known_share) -> bool:
    """Whether the mean of the runs is known well enough: its standard error is so small a share of it."""
    ends = np.array([run[-1] for run in times])
    return len(ends) > 0 and bool(ends.std() / math.sqrt(len(ends)) <= share * ends.mean())


def _missed(route: Itinerary, runs: Points) -> tuple[Missed, ...]:
    """For each waypoint in which share of the runs (m, n) [s] it is missed, and what that costs."""
    lasted = np.diff(runs, axis=1, prepend=0.0)
    longer = lasted - np.median(lasted, axis=0)
    flown_to = np.array([visit.item.command in FLOWN_TO for visit in route.visits], dtype=bool)
    missed = (longer > RUNS.missed_s) & flown_to
    share = missed.mean(axis=0)
    cost = (longer * missed).sum(axis=0) / np.maximum(missed.sum(axis=0), 1)
    return tuple(Missed(*map(float, both)) for both in zip(share, cost, strict=True))


class FlownOnce(NamedTuple):
    """When each order is done, after the time of the begin (n + 1,) [s], samples, and when it came down, if it did [s].

    A sample (m, 7) is time, place and velocity.
    """

    done: Vector
    samples: Points
    touched: float


class Flights:
    """One itinerary, to be flown as often as wanted."""

    def __init__(
        self, route: Itinerary, parameters: Parameters, wind: Wind = CALM, airframe: Airframe = SIH,
        senses: SensorModel = SIH_SENSES, version: Version | None = None,
    ) -> None:  # fmt: skip
        limits = px4_limits(parameters, version)
        self.limits = limits._replace(spool_up=max(limits.spool_up + airframe.lift_delay, 0.0))
        self.route, self.airframe, self.wind = route, airframe, wind
        self.plan = plan(route, self.limits, airframe.landing_delay)
        self.orders = self.plan.orders
        turns = self.limits.turns_first or any(not math.isnan(order.heading) for order in self.plan.orders)
        with_noise = law(self.limits, airframe, senses, wind, STEP)
        self.quiet = with_noise._replace(noisy=False, turns=turns)

    def prepared(self, noisy: bool, fast: bool | None, steps: float = 0.0) -> Callable[[int], tuple[Vector, Points]]:
        """What flies it once, with the noise of a seed: when each visit is done (n,) [s], and, without noise, samples.

        A sample (m, 7) is time, place and velocity; `steps` is how many will be asked for in all.

        Raises:
            MissionError: the vehicle does not get on.
        """
        flown, ends = self.flown(noisy, fast, steps), list(self.plan.done)

        def once(seed: int) -> tuple[Vector, Points]:
            run = flown(seed)
            return run.done[ends], run.samples

        return once

    def broken_off(
        self, contingency: Contingency, time: float, seed: int | None, fast: bool | None
    ) -> tuple[FlownOnce, int]:
        """Flown up to a time [s] with the noise of a seed, or without any, and then what is ordered, as `flown`.

        And how many orders were begun until then.
        """
        self.orders = tuple(order._replace(until=time) for order in self.plan.orders)
        until = self.flown(seed is not None, fast, RUNS.most * time / STEP, True)(seed or 0)
        begun = min(int(np.searchsorted(until.done[1:], time)) + 1, len(self.orders))
        self.orders = with_another_end(
            self.orders[:begun],
            self.contingency(contingency, until.samples[-1]),
            self.limits,
            self.airframe.landing_delay,
        )
        return self.flown(seed is not None, fast, RUNS.most * time / STEP)(seed or 0), begun

    def contingency(self, contingency: Contingency, at: Vector) -> list[Order]:
        """The orders of an RTL or a LAND from one sample (7,) of a flight."""
        here, speed, ground = Enu(*map(float, at[1:4])), Level(float(at[4]), float(at[5])), self.route.ground
        if contingency is Contingency.RTL:
            goal = Enu(*self.route.goal_of_return((here.east, here.north, here.up)))
            return way_home(here, self.limits, goal._replace(up=ground.at(goal.east, goal.north)), goal.up)
        stop = stopping_place(here, speed, self.limits)
        down = stop._replace(up=ground.at(stop.east, stop.north))
        return way_down(stop, down, self.limits, self.limits.cruise, self.limits.disarm_delay)

    def flown(
        self, noisy: bool, fast: bool | None, steps: float = 0.0, sampled: bool = False
    ) -> Callable[[int], FlownOnce]:
        """The same by order; raises as `prepared` does. With noise samples are noted if they are to be `sampled`."""
        orders, height = self.orders, flying_already(self.route) or 0.0
        machine, laws = jit_if_faster(fly, fast, steps), [self.quiet._replace(noisy=noisy)]
        asked: Any = orders
        if machine is not fly:
            asked, laws = records(orders, Order), records(laws, Law)

        def once(seed: int) -> FlownOnce:
            one, two = (float(1 + x % 2_000_000_000) for x in np.random.SeedSequence(seed).generate_state(2))
            done, samples, touched = machine(
                asked, laws, height, (one, two), SAMPLE_STEPS if sampled or not noisy else 0
            )
            if len(done) > len(orders):
                return FlownOnce(np.asarray(done), np.asarray(samples).reshape(-1, 7), touched)
            goal = orders[len(done) - 1].goal
            raise MissionError(
                f"the vehicle does not reach {round(goal.east)} m east and {round(goal.north)} m north of home",
                hint="give its waypoints a hold of 0.1 s (param1), or name the version that flies it "
                "(--firmware-version); or the wind is too strong for it, or the acceptance radius too small to be hit",
                code="unreachable",
            )

        return once

    def why_slow(self, n: int, done: Vector, clock: Vector, samples: Points) -> str:
        """The reasons why visit n, flown as the samples at these times (m,) [s] say, was slow."""
        command, params = self.route.visits[n].item.command, self.route.visits[n].item.params
        if command == Command.NAV_DELAY:
            return "hold" if params[0] > 0 else ""
        if command not in FLOWN_TO:
            return ""
        order = self.plan.orders[self.plan.done[n] - 1]
        if order.holds > LEAST_HOLD:
            return "hold"
        rows = slice(*np.searchsorted(clock, [done[n - 1] if n else 0.0, done[n]], side="right"))
        length, limits = math.dist(order.start[:2], order.goal[:2]), self.limits
        stop = speed_to(length / 2, 0.0, limits.accel, limits.jerk)
        wind = self.wind.along(order.goal.east - order.start.east, order.goal.north - order.start.north)
        return slow_because(
            planned=min(stop, order.cruise) if length > 1.0 else None,
            allowed=self.allowed(order),
            asked=order.cruise,
            top=self.airframe.top_speed(limits.lean) + wind,
            flown=float(np.hypot(samples[rows, 4], samples[rows, 5]).max(initial=0.0)),
            corner=corner_deg(order.start, order.goal, order.beyond),
            stops=order.beyond == order.goal,
        )

    def allowed(self, order: Order) -> float:
        """What the climb or descent rate leaves of the level speed asked for [m/s]."""
        length, rise = math.dist(order.start[:2], order.goal[:2]), order.goal.up - order.start.up
        rate = self.limits.climb if rise > 0 else self.limits.descent
        return min(order.cruise, rate * length / abs(rise)) if rise else order.cruise
