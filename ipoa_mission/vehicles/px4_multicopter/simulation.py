"""Fly the motions of an itinerary as PX4, once or with sensor noise; flights share their first motions."""

import math
from bisect import bisect_right
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.compiled import compiled, records
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.flight_model import LegSpeeds, SharedStretches, corner_deg
from ipoa_mission.geometry import Samples, Vector
from ipoa_mission.vehicles.px4_multicopter.dynamics import navigator, state
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import at_start, fly
from ipoa_mission.vehicles.px4_multicopter.dynamics.guidance import speed_to
from ipoa_mission.vehicles.px4_multicopter.dynamics.navigator import HELD_OR_REACHED
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Motion
from ipoa_mission.vehicles.px4_multicopter.limits import LEAST_HOLD, Px4Return, px4_limits
from ipoa_mission.wind import CALM, Wind


class NoisyRuns(NamedTuple):
    """Runs with sensor noise, and the uncertainty of the model (docs/lab/flight-time.md)."""

    least: int = 3
    most: int = 90
    of_median: int = 8  # always the same seeds
    step_s: float = 0.04
    sample_steps: int = 3  # between samples
    batch: int = 6  # runs between checks
    known_share: float = 0.003  # relative standard error of the mean
    contingency_share: float = 0.008  # for a contingency
    doubt_s: float = 0.8  # standard deviation of the model, its constant part
    doubt_share: float = 0.0125  # and its part by time
    landing_s: float = 1.6  # more for landings, as recorded
    late_quantile: float = 0.93
    contingency_deviations: float = 2.3  # for contingencies, fitted in docs/lab/returns.md
    missed_s: float = 3.0  # later than the median: missed
    nearest_s: float = 1.6  # before or after, for the nearest place of another run
    usual_deviation: tuple[float, float] = (0.6, 1.0)  # to a side and in height [m]: the deviation law has it


RUNS = NoisyRuns()


class FlownMotions(NamedTuple):
    done: Vector  # times at the start and after each motion (n + 1,) [s]
    samples: Samples
    progress: state.FlightProgress


class FlyOn(Protocol):
    """Fly on to the end of all or the first `to` motions, or until a time [s]."""

    def __call__(self, flight: FlownMotions, until: float = math.inf, to: int | None = None) -> FlownMotions: ...


_start = lru_cache(maxsize=128)(at_start)


class MissionSimulation:
    def __init__(self, itinerary: Itinerary, wind: Wind = CALM, sensors: state.SensorModel = state.SIH_SENSORS) -> None:
        mission = itinerary.mission
        self.itinerary = itinerary
        self.airframe = navigator.airframe_of(mission.vehicle)
        self.wind = wind
        limits = px4_limits(mission.parameters, mission.firmware_version)
        self.limits = limits._replace(spool_up=max(limits.spool_up + self.airframe.lift_delay, 0.0))
        self.mission_motions = navigator.motions_of_itinerary(itinerary, self.limits, self.airframe.landing_delay)
        turns = self.limits.turns_first or any(
            not math.isnan(motion.heading) for motion in self.mission_motions.motions
        )
        with_noise = navigator.simulation_constants(self.limits, self.airframe, sensors, wind, RUNS.step_s)
        self.noise_free_constants = with_noise._replace(noisy=False, turns=turns)

    @property
    def conditions(self) -> bytes:
        """All that a noise-free flight depends on, but for its motions; only LAND measures the ground."""
        limits = self.limits._replace(returning=Px4Return(0.0, 0.0, 0.0, 0.0))
        constants = self.noise_free_constants._replace(limits=limits, sensors=state.NOISE_FREE)
        packed: bytes = records([constants], state.SimulationConstants).tobytes()
        return packed + self.at_start(0).samples.tobytes()

    def flown_with(self, contingency: Contingency, time: float, seed: int | None) -> tuple[FlownMotions, FlownMotions]:
        """Return a flight at an order and at its end, with a seed's noise or none."""
        noisy = seed is not None
        fly_mission = self.flight_of(self.mission_motions.motions, noisy=noisy, sampled=True)
        until = fly_mission(self.at_start(seed or 0), time)
        onward = navigator.contingency_motions(contingency, until.samples[-1], self.itinerary, self.limits)
        motions = tuple(navigator.with_timeouts(onward, onward[0].start, self.limits, self.airframe.landing_delay))
        begins = until._replace(done=until.done[-1:], progress=until.progress._replace(steps=state.NOT_BEGUN))
        return until, self.flight_of(motions, noisy=noisy)(begins)

    def flight_of(self, motions: tuple[Motion, ...], *, noisy: bool, sampled: bool = False) -> FlyOn:
        """Return a function that flies `motions` on or raises MissionError; `sampled` or noise-free it samples."""
        machine = compiled(fly)
        inputs = records(motions, Motion)
        constants = records([self.noise_free_constants._replace(noisy=noisy)], state.SimulationConstants)
        every = RUNS.sample_steps if sampled or not noisy else 0

        def fly_on(flight: FlownMotions, until: float = math.inf, to: int | None = None) -> FlownMotions:
            left = inputs[len(flight.done) - 1 : to]
            times, places, (last, of_motion, touched) = machine(left, constants, flight.progress, until, every)
            done = np.append(flight.done, times)
            progress = state.FlightProgress(state.State(*last), of_motion, touched)
            if len(done) > (len(motions) if to is None else to) or progress.state.time >= until:
                return FlownMotions(done, np.vstack([flight.samples, places]), progress)
            raise MissionError(*self._why_not_reached(motions, len(done) - 1), code="unreachable")

        return fly_on

    def _why_not_reached(self, motions: tuple[Motion, ...], n: int) -> tuple[str, str]:
        goal = motions[n].goal
        is_own = motions is self.mission_motions.motions  # not a contingency's
        item = f"item {self.itinerary.visits[bisect_right(self.mission_motions.done, n)].seq}, " if is_own else ""
        words = f"the vehicle does not reach {item}{round(goal.east)} m east and {round(goal.north)} m north of home"
        wind = max(map(self.wind.speed_at, (motions[n].start.up, goal.up)))
        top = self.airframe.top_speed(self.limits.max_tilt)
        if wind > top:
            words += f": the wind of {wind:.3g} m/s is stronger than the {top:.2g} m/s that it can fly against"
            return words, "fly in less wind, or with a greater tilt (MPC_TILTMAX_AIR, at its risk)"
        return words, (
            "set a hold of 0.1 s (param1) at its waypoints, or name its version (--firmware-version). "
            "Other causes: too strong a wind, or too small an acceptance radius"
        )

    def at_start(self, seed: int) -> FlownMotions:
        height = self.itinerary.start_height or 0.0
        return FlownMotions(np.zeros(1), np.array([[0.0, 0.0, 0.0, height, 0.0, 0.0, 0.0]]), _start(height, seed))

    def why_slow(self, n: int, done: Vector, sample_times: Vector, samples: Samples) -> str:
        """Return why visit n was slow, by samples at these times (m,) [s]."""
        command = self.itinerary.visits[n].item.command
        params = self.itinerary.visits[n].item.params
        if command == Command.NAV_DELAY:
            return "hold" if params[0] > 0 else ""
        if command not in HELD_OR_REACHED:
            return ""
        motion = self.mission_motions.motions[self.mission_motions.done[n] - 1]
        if motion.hold_s > LEAST_HOLD:
            return "hold"
        rows = slice(*np.searchsorted(sample_times, [done[n - 1] if n else 0.0, done[n]], side="right"))
        length = math.dist(motion.start[:2], motion.goal[:2])
        limits = self.limits
        stop = speed_to(length / 2, 0.0, limits.accel, limits.jerk)
        wind = self.wind.along(motion.goal.east - motion.start.east, motion.goal.north - motion.start.north)
        return LegSpeeds(
            planned=min(stop, motion.cruise) if length > 1.0 else None,
            allowed=self.allowed(motion),
            asked=motion.cruise,
            top=self.airframe.top_speed(limits.max_tilt) + wind,
            flown=float(np.hypot(samples[rows, 4], samples[rows, 5]).max(initial=0.0)),
            corner=corner_deg(motion.start, motion.goal, motion.beyond),
            stops=motion.beyond == motion.goal,
        ).why_slow()

    def allowed(self, motion: Motion) -> float:
        """Return the horizontal speed that climb or descent allows [m/s]."""
        length = math.dist(motion.start[:2], motion.goal[:2])
        rise = motion.goal.up - motion.start.up
        rate = self.limits.climb if rise > 0 else self.limits.descent
        return min(motion.cruise, rate * length / abs(rise)) if rise else motion.cruise


def fly_noise_free(simulation: MissionSimulation, latest: SharedStretches[FlownMotions]) -> FlownMotions:
    """Fly a mission without noise, motion by motion; `latest` flights may share the first ones."""
    motions = simulation.mission_motions.motions
    fly_on = simulation.flight_of(motions, noisy=False)
    sees_ground = simulation.noise_free_constants.sensors.sees_ground
    stretches = [(sees_ground and motion.kind == state.LAND, records([motion], Motion).tobytes()) for motion in motions]

    def fly_motion(flown: FlownMotions, n: int) -> FlownMotions:
        return fly_on(flown._replace(samples=flown.samples[:0]), to=n + 1)

    start = simulation.at_start(0)
    ends = [start, *latest.fly(simulation.conditions, start, stretches, fly_motion)]
    return ends[-1]._replace(samples=np.vstack([flown.samples for flown in ends]))
