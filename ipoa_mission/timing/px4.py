"""PX4 1.13 to 1.17 in AUTO.MISSION with a multicopter: smoothed trajectories, acceptance radii, take-off, RTL, LAND.

What its navigator decides at waypoints is written here; what happens between two decisions is stepped by `_px4_steps`.
Its flights are noisy: a waypoint counts once place *and* height are right, and for two minutes from take-off the height
of home is corrected by noisy measurements. So a mission is flown once without noise, which gives the path, and then
again and again with it, which gives times and spread.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from ipoa_mission.autopilots.px4 import RANGE_LAG_S, Px4Limits, Px4Touchdown, px4_limits
from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.commands import Command
from ipoa_mission.dynamics.compiled import stepping
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.itinerary.itinerary import LAST_NAV, UNTIMED, Itinerary, flying_already
from ipoa_mission.timing import _px4_steps
from ipoa_mission.timing.body import GRAVITY, PX4_SIMULATOR, Body, Senses
from ipoa_mission.timing.prediction import Prediction, Track
from ipoa_mission.timing.reasons import corner_deg, slow_because
from ipoa_mission.wind import CALM, Wind

STEP = 0.04  # [s]
SAMPLE_STEPS = 3  # a sample of the track every so many steps
NOTICED = (
    0.075  # from reaching a waypoint to steering for the next: half the navigator's cycle, and a setpoint's way [s]
)
GROUND_SINK = 0.7  # the trajectory's speed downwards until a take-off begins [m/s]
RUNS = 90  # with noise
SOME_RUNS, WELL_KNOWN = 6, 0.003  # fewer will do once the mean is known to this share of it; asked every so many
DOUBT, DOUBT_SHARE = 1.0, 0.01  # what the model itself may be off by on either side: seconds, and share of the time
LIKELY = 0.9  # the share of the runs between which the interval lies, before that is added
#: "Commander: adjust home position altitude after gnss altitude correction" (pull request 25003, from 1.17 on): by how
#: much the measured height has to differ [m], and for how long from take-off [s].
CORRECTED_BEYOND, CORRECTED_FOR = 1.0, 120.0
STATE = 41  # numbers that the stepping code keeps
#: Those of them that are noise: the seeds, home's height, the next measurement, the drifts.
SEEDS, NOISE_STATE = (27, 40), (27, 30, 31, 32, 33, 34, 40)

HOLDING = frozenset({Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME})
FLOWN_TO = HOLDING | {Command.NAV_LOITER_TO_ALT}
#: A waypoint is flown through towards these; before everything else the vehicle brakes for a stop.
AHEAD = FLOWN_TO | {Command.NAV_LAND, Command.NAV_TAKEOFF, Command.NAV_LOITER_UNLIM}

Place = tuple[float, float, float]


def fly_px4(
    route: Itinerary, parameters: Parameters, wind: Wind = CALM, fast: bool | None = None, body: Body = PX4_SIMULATOR
) -> Prediction:
    """Fly the itinerary as PX4 does; `fast` is as in `estimate`.

    Raises:
        BadInput: an item never ends, or a parameter has no sense.
        MissionError: the vehicle does not get on, as against a wind stronger than it can fly.
    """
    limits = px4_limits(parameters)
    plan = _Plan(route, limits, wind, body)
    smooth = _Flight(plan, _px4_steps if fast is None else stepping(_px4_steps, fast, 0.0), seed=0)
    smooth.run()
    samples = np.array(smooth.samples, dtype=np.float64).reshape(-1, 7)
    samples = samples[np.concatenate([[True], np.diff(samples[:, 0]) > 1e-9])]
    times = [smooth.done]
    if body.senses is not None and route.visits:
        times = []
        steps = stepping(_px4_steps, fast, RUNS * smooth.now / STEP)
        for seed in range(1, RUNS + 1):
            if (seed - 1) % SOME_RUNS == 0 and _known(times):
                break
            run = _Flight(plan, steps, seed)
            try:
                run.run()
            except MissionError as lost:  # circling a waypoint that is too small to be hit
                if seed > 2 * len(times) + SOME_RUNS:
                    raise
                smooth.remarks.append(f"some flights would not end: {lost}")
                continue
            times.append(run.done)
    runs = np.array(times, dtype=np.float64)  # (runs, visits)
    done = runs.mean(axis=0)
    low, high = np.quantile(runs, [(1 - LIKELY) / 2, (1 + LIKELY) / 2], axis=0) if route.visits else (done, done)
    doubt = DOUBT + DOUBT_SHARE * done
    warped = np.interp(samples[:, 0], [0.0, *smooth.done], [0.0, *done])
    warped += np.maximum(samples[:, 0] - (smooth.done[-1] if smooth.done else 0.0), 0.0)
    track = Track(warped, samples[:, 1:4], np.linalg.norm(samples[:, 4:7], axis=1))
    interval = (np.minimum(low, done) - doubt, np.maximum(high, done) + doubt)
    return Prediction(done, *interval, tuple(smooth.reasons), track, tuple(smooth.remarks))


def _known(times: Sequence[Sequence[float]]) -> bool:
    """Whether the mean of the runs is known well enough: its standard error is a small share of it."""
    ends = np.array([run[-1] for run in times])
    return len(ends) > 0 and bool(ends.std() / math.sqrt(len(ends)) <= WELL_KNOWN * ends.mean())


@dataclass(frozen=True)
class _Leg:
    """A visit that is flown to: whence, whither, whither then; seconds that the nose turns and that it holds there.

    `waits` are the seconds that the nose turns before the vehicle goes (MPC_YAW_MODE 4).
    """

    before: Place
    target: Place
    after: Place
    radius: float
    turns: float
    waits: float
    holds: float
    stops: bool


@dataclass(frozen=True)
class _Plan:
    """What is the same in all flights; `legs` are noted, visit by visit, as the first flight comes to them."""

    route: Itinerary
    limits: Px4Limits
    wind: Wind
    body: Body
    legs: dict[int, _Leg] = field(default_factory=dict)


class _Flight:
    """One flight under way: the time, the place last bound for, the cruise speed in force, where the nose points.

    With seed 0 it is flown without noise and watched: samples of its path and the reasons of its legs are kept.
    """

    def __init__(self, plan: _Plan, steps: ModuleType, seed: int) -> None:
        self.plan, self.route, self.limits = plan, plan.route, plan.limits
        self.watched = seed == 0
        self.step_to = steps.fly_to
        self.pack: Callable[[Any], Any] = list if steps is _px4_steps else _packed
        self.room: Callable[[int], Any] = _zeros if steps is _px4_steps else np.zeros
        self.cruise, self.heading = self.limits.cruise, math.nan
        self.here, self.airborne, self.since = (0.0, 0.0, 0.0), False, 0.0  # since: when the last thing was done
        self.done: list[float] = []
        self.reasons: list[str] = []
        self.remarks: list[str] = []
        self.samples: list[float] = []
        self.no_samples = self.pack([0.0])
        self.pace = self.pack(_pace(plan, noisy=not self.watched))
        self.state = self.pack([0.0] * STATE)
        for n, value in zip(SEEDS, np.random.SeedSequence(seed).generate_state(2), strict=True):
            self.state[n] = float(1 + value % 2_000_000_000)
        self.rest(0.0)

    @property
    def now(self) -> float:
        return float(self.state[0])

    def run(self) -> None:
        """Do every visit of the itinerary in turn; without a take-off before, in the air from the beginning."""
        height = flying_already(self.route)
        if height is not None:
            self.here, self.airborne = (0.0, 0.0, height), True
            self.rest(0.0)
            self.samples = self.samples[7:]
        for n in range(len(self.route.visits)):
            done, why = self.visit(n)
            self.done.append(done)
            self.reasons.append(why)

    def visit(self, n: int) -> tuple[float, str]:
        """Do visit n; when it was done, and why it was slow."""
        visit = self.route.visits[n]
        command, params = visit.item.command, visit.item.params
        if command in FLOWN_TO:
            return self.fly_to(n)
        if command == Command.NAV_TAKEOFF:
            return self.take_off(n), ""
        if command == Command.NAV_LOITER_UNLIM:
            raise BadInput(f"items[{visit.seq - 1}]: loiters without end, so the flight has no time")
        if command == Command.NAV_DELAY:
            return self.hold(max(params[0], 0.0)), "hold"
        if command == Command.DO_CHANGE_SPEED and params[0] < 2:
            self.cruise = params[1] if params[1] > 0 else self.limits.cruise
        elif command == Command.NAV_RETURN_TO_LAUNCH:
            return self.return_home(), ""
        elif command == Command.NAV_LAND:
            east, north, _ = self.target(n)
            self.straight_to((east, north, self.here[2]))
            self.come_down()
        elif command <= LAST_NAV or command in UNTIMED:
            self.remarks.append(f"item {visit.seq}: command {command} is not modeled and counts as no time")
        return self.now, ""

    def target(self, n: int) -> Place:
        """Where visit n leads: its own place, or straight above or below the place last bound for."""
        east, north, up = (float(x) for x in self.route.places[n])
        return (self.here[0], self.here[1], up) if math.isnan(east) else (east, north, up)

    def onward(self, n: int) -> int | None:
        """The visit that the vehicle flies on to without a stop at n; items without a place are no hindrance."""
        if self.holds(n) > 0:
            return None
        for later in range(n + 1, len(self.route.visits)):
            command = self.route.visits[later].item.command
            if command <= LAST_NAV:
                return later if command in AHEAD else None
        return None

    def holds(self, n: int) -> float:
        """How long visit n asks to stay [s]."""
        item = self.route.visits[n].item
        return max(item.params[0], 0.0) if item.command in HOLDING else 0.0

    # --- legs -------------------------------------------------------------------------------------------------

    def leg(self, n: int) -> _Leg:
        """The leg to visit n from the place last bound for."""
        item, target = self.route.visits[n].item, self.target(n)
        if item.command == Command.NAV_SPLINE_WAYPOINT:
            self.remarks.append(f"item {self.route.visits[n].seq}: PX4 knows no splines, flown straight")
        onward = self.onward(n)
        own = item.command == Command.NAV_WAYPOINT and item.params[1] > 0
        before, self.here = self.here, target
        turns = self.turning_time(item.params[3], before, target)
        return _Leg(
            before=before,
            target=target,
            after=self.target(onward) if onward is not None else target,
            radius=item.params[1] if own else self.limits.radius,
            turns=0.0 if math.isnan(item.params[3]) else turns,
            waits=turns if self.limits.turns_first else 0.0,
            holds=self.holds(n),
            stops=onward is None,
        )

    def fly_to(self, n: int) -> tuple[float, str]:
        """Fly to visit n, turn the nose where it says, hold as long as it says."""
        legs, used = self.plan.legs, len(self.samples)
        leg = legs[n] if n in legs else legs.setdefault(n, self.leg(n))
        self.here = leg.target
        headed, starts = self.now + leg.turns, self.now + leg.waits
        self.fly(leg.before, leg.target, leg.after, leg.radius, headed=headed, starts=starts)
        reached, why = self.since, self.why_slow(leg, used) if self.watched else ""
        if leg.holds > 0:
            return self.hold(leg.holds), "hold"
        return reached, why

    def why_slow(self, leg: _Leg, used: int) -> str:
        """The reasons of a leg just flown, whose samples begin at `used`."""
        level = math.dist(leg.before[:2], leg.target[:2])
        rows = np.array(self.samples[used:]).reshape(-1, 7)
        flown = float(np.hypot(rows[:, 4], rows[:, 5]).max()) if len(rows) else 0.0
        stop = _px4_steps.speed_to(level / 2, 0.0, self.limits.accel, self.limits.jerk)
        asked = min(self.cruise, self.limits.most_speed)
        east, north = (leg.target[axis] - leg.before[axis] for axis in (0, 1))
        return slow_because(
            planned=min(stop, asked) if level > 1.0 else None,
            allowed=self.allowed(leg.before, leg.target, asked),
            asked=asked,
            top=self.plan.body.top_speed(self.limits.lean) + self.plan.wind.along(east, north),
            flown=flown,
            corner=corner_deg(leg.before, leg.target, leg.after),
            stops=leg.stops,
        )

    def allowed(self, before: Place, target: Place, asked: float) -> float:
        """What the climb or descent rate leaves of the level speed asked for [m/s]."""
        level, rise = math.dist(before[:2], target[:2]), target[2] - before[2]
        rate = self.limits.climb if rise > 0 else self.limits.descent
        return min(asked, rate * level / abs(rise)) if rise else asked

    def fly(
        self,
        before: Place,
        target: Place,
        after: Place,
        radius: float,
        climbing_off: bool = False,
        headed: float = 0.0,
        starts: float = 0.0,
    ) -> None:
        """Step until the target is reached and the nose is `headed` as it should be, but stay until it `starts` [s]."""
        distance = math.dist(self.state[1:4], target) + abs(self.state[3] - target[2]) * 3
        cruise = min(self.cruise, self.limits.most_speed)
        most = (120 + 6 * distance * max(1.0, 1 / cruise)) * max(1.0, 1 / radius)  # a small circle is hard to hit
        most += max(headed - self.now, starts - self.now, 0.0)
        reaching = (radius, self.limits.height_radius, cruise, float(climbing_off), most, headed, starts)
        self.step((*before, *target, *after, *reaching))
        self.since = float(self.state[26])

    def hold(self, seconds: float) -> float:
        """Stay at the place last bound for; when that is over [s]."""
        if seconds <= 0:
            return self.now
        over = max(self.since + seconds, self.now)
        there = (*self.here, *self.here, *self.here)
        self.step((*there, 1e9, 1e9, self.cruise, 0.0, seconds + 6, 0.0, 0.0), latency=over - self.now)
        self.since = over
        return over

    def step(self, way: tuple[float, ...], latency: float = NOTICED) -> None:
        """Fly a way as the stepping code has it: three places, radii, cruise, climbing off or landing,
        patience, until when the nose turns, and until when the vehicle stays.
        """
        samples = self.no_samples
        if self.watched:
            samples = self.room(7 * (int(way[13] / (STEP * SAMPLE_STEPS)) + 1))
        self.pace[1], self.state[24] = latency, 0.0
        if not self.step_to(tuple(map(float, way)), self.pace, self.state, samples):
            raise MissionError(
                f"the vehicle does not reach {round(way[3])} m east and {round(way[4])} m north of home",
                hint="the wind may be stronger than it can fly against, or the acceptance radius too small to be hit",
            )
        self.samples += [float(x) for x in samples[: int(self.state[24])]]

    def turning_time(self, yaw_deg: float, before: Place, target: Place) -> float:
        """How long the nose needs to point, within the error allowed, where the item says or else to the target [s]."""
        old, east, north = self.heading, target[0] - before[0], target[1] - before[1]
        if not math.isnan(yaw_deg):
            self.heading = math.radians(yaw_deg)
        elif math.dist(before[:2], target[:2]) > self.limits.radius:
            self.heading = math.atan2(east, north)
        if math.isnan(old) or math.isnan(self.heading):
            return 0.0
        turn = abs(math.remainder(self.heading - old, 2 * math.pi))
        rate, accel, near = self.limits.yaw_rate, self.limits.yaw_accel, self.limits.yaw_error
        if turn <= near:
            return 0.0
        whole = turn / rate + rate / accel if turn > rate * rate / accel else 2 * math.sqrt(turn / accel)
        peak = min(rate, math.sqrt(turn * accel))  # it is near enough while it still turns
        braking = peak * peak / (2 * accel)
        return whole - (math.sqrt(2 * near / accel) if near < braking else peak / accel + (near - braking) / peak)

    def straight_to(self, target: Place) -> None:
        """A leg that ends in a stop."""
        if math.dist(self.here, target) > self.limits.radius:
            before, self.here = self.here, target
            self.fly(before, target, target, self.limits.radius)

    # --- what is not a leg ------------------------------------------------------------------------------------

    def take_off(self, n: int) -> float:
        """Spool up, ramp up the thrust, climb; then the item is a waypoint like any other: when that is reached [s]."""
        target, onward = self.target(n), self.onward(n)
        if not self.airborne:
            self.rest(self.limits.spool_up)
            self.state[19], self.airborne = -GROUND_SINK, True
        self.here = target
        self.fly(target, target, target, self.limits.radius, climbing_off=True)
        self.fly(target, target, self.target(onward) if onward is not None else target, self.limits.radius)
        return self.since

    def return_home(self) -> float:
        """RTL: climb as `Px4Return` says, fly home at MPC_XY_CRUISE, wait, come down, disarm."""
        x, y, z = self.here
        self.cruise = self.limits.cruise
        height = self.limits.returning.height(z, math.hypot(x, y))
        if height > z + self.limits.height_radius:
            x, y = float(self.state[1]), float(self.state[2])  # where it is when told to, however fast it still moves
            self.here = (x, y, height)
            self.fly((x, y, z), self.here, self.here, self.limits.radius)
        self.straight_to((0.0, 0.0, self.here[2]))
        self.hold(self.limits.land_delay)
        self.come_down()
        self.rest(self.limits.disarm_delay)
        return self.now

    def come_down(self) -> None:
        """Sink over the place last bound for to the ground, and stand there until the landing is noticed."""
        over = (self.here[0], self.here[1], 0.0)
        slowest = min(self.limits.land_speed, self.limits.descent, self.limits.crawl_speed)
        most = 300.0 + 4.0 * max(float(self.state[3]), 0.0) / slowest
        cruise = min(self.cruise, self.limits.most_speed)
        self.step((*over, *over, *over, self.limits.radius, 0.0, cruise, -1.0, most, 0.0, 0.0), latency=0.0)
        self.here = over
        self.rest(0.0)
        self.airborne = False

    def rest(self, seconds: float) -> None:
        """Let time pass at `here` with no motion left in anything; the noise goes on from where it is."""
        x, y, z = self.here
        kept = ((0, self.now + seconds), *((n, float(self.state[n])) for n in NOISE_STATE))
        self.state = self.pack([0.0] * STATE)
        for n, value in kept:
            self.state[n] = value
        self.state[1], self.state[2], self.state[3], self.state[25] = x, y, z + float(self.state[30]), 1.0
        self.state[14], self.state[15], self.state[16] = self.state[1], self.state[2], self.state[3]
        self.state[38], self.state[39] = 1.0, self.now
        self.since = self.now
        self.samples += (self.now, x, y, z, 0.0, 0.0, 0.0)


def _pace(plan: _Plan, noisy: bool) -> tuple[float, ...]:
    """What the stepping code goes by: its step and samples, limits and gains, the body, the wind, noise, landing."""
    limits, body, wind = plan.limits, plan.body, plan.wind
    return (
        *(STEP, NOTICED, 0.0 if noisy else float(SAMPLE_STEPS)),
        *(limits.accel, limits.jerk, limits.corner_gain, limits.most_error, limits.most_speed),
        *(limits.climb, limits.descent, limits.accel_up, limits.accel_down),
        *(limits.takeoff_speed, limits.takeoff_speed / limits.takeoff_ramp, limits.land_high),
        *(limits.p_xy, limits.p_v, limits.i_v, limits.d_v, GRAVITY * math.tan(limits.lean)),
        *(limits.p_z, limits.p_vz, 1 - math.exp(-STEP / limits.lean_lag), 1 - math.exp(-STEP / body.lag)),
        *(body.linear_drag, wind.east, wind.north, limits.i_vz, limits.hover_learning, NOTICED),
        *_noise(body.senses if noisy else None, limits.spool_up),
        *(limits.most_climb, limits.most_descent),
        *(limits.land_low, limits.land_speed, *_crawl(body.senses, limits)),
        *(limits.takeoff_ramp, *_standing(body.senses, limits.touchdown)),
    )


def _noise(senses: Senses | None, taken_off: float) -> tuple[float, ...]:
    """The noise for the stepping code: every, height, by how much and until when home is corrected; drifts, memory."""
    if senses is None:
        return (math.inf, 0.0, math.inf, 0.0, 0.0, 0.0, 0.0)
    kept = math.exp(-senses.every / senses.drift_lasts)
    fresh = math.sqrt(1 - kept * kept)
    correction = (senses.height_noise, CORRECTED_BEYOND, taken_off + CORRECTED_FOR)
    return (senses.every, *correction, fresh * senses.drift, fresh * senses.drift_up, kept)


def _crawl(senses: Senses | None, limits: Px4Limits) -> tuple[float, float]:
    """Below which height a landing crawls, and how fast: only where the ground is seen."""
    seen = senses is not None and senses.sees_ground
    return (limits.crawl_below if seen else 0.0), limits.crawl_speed


def _standing(senses: Senses | None, known: Px4Touchdown) -> tuple[float, ...]:
    """What is taken for a landing: seen late by, low thrust, a speed that is none, stages with and without ground."""
    low, seen = GRAVITY * (known.low_thrust - 1.0), senses is not None and senses.sees_ground
    return (RANGE_LAG_S if seen else 0.0, low, known.most_speed, known.stage_s(False), known.stage_s(seen))


def _packed(numbers: Any) -> Any:
    return np.array(numbers, dtype=np.float64)


def _zeros(count: int) -> list[float]:
    return [0.0] * count
