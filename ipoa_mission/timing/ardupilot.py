"""ArduCopter 4.x in AUTO: S-curve legs that overlap at corners, splines, stops, take-off, return and landing.

What the autopilot decides at waypoints is written here, in its order; what happens between two decisions is stepped by
`_ardupilot_steps`. Sources: ArduPilot's documentation of S-curves and spline waypoints, and the recorded flights.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ipoa_mission.autopilots.ardupilot import (
    ARMING_DELAY_S,
    CENTIMETRE,
    LAND_DETECTOR_S,
    LIFT_S,
    THROTTLE_DOWN_S,
    CopterLimits,
    copter_limits,
)
from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.commands import Command
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.itinerary.copter_spline import FLOWN_ON_INTO, Place, flies_on_to
from ipoa_mission.itinerary.itinerary import LAST_NAV, UNTIMED, Itinerary, flying_already
from ipoa_mission.timing import _ardupilot_steps
from ipoa_mission.timing._compiled import stepping
from ipoa_mission.timing.body import ARDUPILOT_SIMULATOR, GRAVITY, Body
from ipoa_mission.timing.copter_legs import (
    NO_LEG,
    Leg,
    Speeds,
    as_numbers,
    at_speeds,
    joined,
    spline_leg,
    straight_leg,
)
from ipoa_mission.timing.copter_vertical import Climb, descend, take_off
from ipoa_mission.timing.prediction import Prediction, Track
from ipoa_mission.timing.reasons import corner_deg, slow_because
from ipoa_mission.wind import CALM, Wind

STEP = 0.02  # [s]
SAMPLE_STEPS = 5  # a sample of the track every so many steps
JUST_BEGUN = 0.3  # so far into a leg a change of speed still plans it anew, as `straight` was flown [s]
#: LAND flies to its place at the height where the vehicle is, cut to whole centimetres: that is the waypoint's, or one
#: centimetre below, and a leg of one takes a second. Before a flight nothing tells which: half of it is counted.
LAND_BELOW = 0.5
#: RTL begins with a leg to where the vehicle would stop, its height and place cut likewise: by so much on average [m].
RETURN_ROUNDING = 0.7 * CENTIMETRE
#: What rounding leaves to climb when a take-off counts as done: up to half a millimetre, for which the leg over the
#: take-off takes 0.4 s, or nothing, for which it takes no time. This much takes 0.2 s [m].
TAKEOFF_REST = 0.00003
GAINS = (1.0, 2.0, 1.0, 0.25)  # position P, velocity P, I, D of the horizontal controllers: ArduCopter's defaults
ERROR_FILTER = 1 / (2 * math.pi * 5.0)  # of the velocity error: 5 Hz by default [s]
OVERRUNNING = 1.0  # a stop that is come to faster is overrun; after a leg that is long enough it is 0.3 [m/s]
DOUBT, DOUBT_SHARE = 0.15, 0.0075  # half the width of the interval: seconds, and share of the time

#: Of these only the flight to their place is modelled.
ONLY_THE_WAY = frozenset({Command.NAV_LOITER_TO_ALT})
TO_A_PLACE = FLOWN_ON_INTO | ONLY_THE_WAY | {Command.NAV_LOITER_TURNS}


def fly_arducopter(
    route: Itinerary,
    parameters: Parameters,
    wind: Wind = CALM,
    fast: bool | None = None,
    body: Body = ARDUPILOT_SIMULATOR,
) -> Prediction:
    """Fly the itinerary as ArduCopter does; `fast` is as in `estimate`.

    Raises:
        BadInput: an item never ends, or a parameter has no sense.
        MissionError: the copter does not get on, as against a wind stronger than it can fly.
    """
    flight = _Flight(route, copter_limits(parameters), wind, body, fast)
    for n in range(len(route.visits)):
        flight.done_reasons.append(flight.visit(n))
        flight.done.append(flight.now)
    samples = np.array(flight.samples, dtype=np.float64).reshape(-1, 7)
    samples = samples[np.concatenate([[True], np.diff(samples[:, 0]) > 1e-9])]
    track = Track(samples[:, 0], samples[:, 1:4], np.linalg.norm(samples[:, 4:7], axis=1))
    done = np.array(flight.done, dtype=np.float64)
    doubt = DOUBT + DOUBT_SHARE * done
    return Prediction(done, done - doubt, done + doubt, tuple(flight.done_reasons), track, tuple(flight.remarks))


class _Flight:
    """A flight under way: the time, the place last bound for, the speeds in force, the legs in progress.

    `state` is what the stepping code keeps from leg to leg; `planned` is the leg that it may have begun already while
    the last one ended, and `tail` that last one.
    """

    def __init__(self, route: Itinerary, limits: CopterLimits, wind: Wind, body: Body, fast: bool | None) -> None:
        self.route, self.limits, self.wind = route, limits, wind
        self.top = body.top_speed(limits.lean)
        self.items = [visit.item for visit in route.visits]
        steps = stepping("_ardupilot_steps", fast, 0.0)
        plain = steps is _ardupilot_steps
        self.step_leg = steps.fly_leg
        self.pack: Callable[[Any], Any] = list if plain else _packed
        self.room: Callable[[int], Any] = _zeros if plain else np.zeros
        self.speeds = Speeds(limits.speed, limits.climb, limits.descent)
        self.now, self.here, self.airborne = 0.0, (0.0, 0.0, 0.0), False
        self.passing = 0.0, 0.0  # the velocity with which the last stop was come to [m/s]
        self.done: list[float] = []
        self.done_reasons: list[str] = []
        self.remarks: list[str] = []
        height = flying_already(route)
        if height is not None:
            self.here, self.airborne = (0.0, 0.0, height), True
        self.samples: list[float] = [0.0, *self.here, 0.0, 0.0, 0.0]
        clock_lag = max(limits.accel / limits.jerk, STEP)
        lean = GRAVITY * math.tan(limits.lean)
        drag = (body.linear_drag, body.quadratic_drag, wind.east, wind.north)
        lags = (STEP, limits.lean_lag, body.lag)
        pace = (limits.radius, limits.corner_accel, limits.accel_z, *lags, *drag, *GAINS, clock_lag, lean)
        self.pace = self.pack([*pace, float(SAMPLE_STEPS), ERROR_FILTER])
        self.rest()

    def rest(self) -> None:
        """Forget all motion: the copter stands in the air, its path's clock at full rate."""
        x, y, z = self.here
        self.state = self.pack([self.now, x, y] + [0.0] * 10 + [1.0, x, y, z] + [0.0] * 11)
        self.planned: Leg | None = None
        self.tail: Leg | None = None

    # --- what the mission asks for ----------------------------------------------------------------------------

    def visit(self, n: int) -> str:
        """Do visit n; why it was slow."""
        visit = self.route.visits[n]
        command, params = visit.item.command, visit.item.params
        if command == Command.NAV_TAKEOFF:
            self.take_off(self.target(n)[2])
        elif command == Command.NAV_LOITER_UNLIM:
            raise BadInput(f"items[{visit.seq - 1}]: loiters without end, so the flight has no time")
        elif command in TO_A_PLACE:
            return self.fly_to(n)
        elif command == Command.NAV_DELAY:
            self.wait(max(params[0], 0.0))
            return "hold"
        elif command == Command.DO_CHANGE_SPEED:
            self.change_speed(int(params[0]), params[1])
        elif command == Command.NAV_RETURN_TO_LAUNCH:
            self.return_home()
        elif command == Command.NAV_LAND:
            self.land_at(self.target(n))
        elif command == Command.NAV_PAYLOAD_PLACE:
            east, north, _ = self.target(n)
            self.straight_to((east, north, self.here[2]))
            self.remarks.append(f"item {visit.seq}: only the flight to its place is counted")
        elif command <= LAST_NAV or command in UNTIMED:
            self.remarks.append(f"item {visit.seq}: command {command} is not modelled and counts as no time")
        return ""

    def target(self, n: int) -> Place:
        """Where visit n leads: its own place, or straight above or below the place last bound for."""
        east, north, up = (float(x) for x in self.route.places[n])
        return (self.here[0], self.here[1], up) if math.isnan(east) else (east, north, up)

    def flies_on(self, n: int) -> int | None:
        """The visit that the copter flies on to without stopping at n."""
        return flies_on_to(self.items, n)

    def fly_to(self, n: int) -> str:
        """Fly to visit n, and do there what it asks for."""
        visit, target, onward = self.route.visits[n], self.target(n), self.flies_on(n)
        this, following = self.leg_now(n, target), None
        corner = 0.0
        if onward is not None:
            following = self.leg_to(onward, target, self.target(onward), this)
            this = joined(this, following)
            corner = 0.0 if following.shape is None else corner_deg(this.origin, target, following.target)
        flown_at = self.fly(this, following)
        planned = this.shape.peak if this.shape is not None and this.length > 1.0 else None
        top = self.top + self.wind.along(target[0] - this.origin[0], target[1] - this.origin[1])
        why = slow_because(
            planned=planned,
            allowed=this.limits.speed,
            asked=self.speeds.level,
            top=top,
            flown=flown_at,
            corner=corner,
            stops=following is None,
            curved=this.shape is None,
        )
        self.here, self.planned = target, following
        self.tail = this if following is not None and this.shape is not None else None
        if following is not None:
            return why
        self.passing = float(self.state[3]), float(self.state[4])
        self.rest()
        hold = float(int(visit.item.params[0]))
        if visit.item.command == Command.NAV_LOITER_TURNS:
            hold = self.circling_time(abs(visit.item.params[0]), abs(visit.item.params[2]))
        elif visit.item.command in ONLY_THE_WAY:
            self.remarks.append(f"item {visit.seq}: only the flight to its place is counted")
            hold = 0.0
        if hold > 0:
            self.wait(hold)
            return "hold"
        return why

    def circling_time(self, turns: float, radius: float) -> float:
        """Turns over the rate of turning, which speed and acceleration limit on a wide circle [s]."""
        radius = radius or self.limits.circle_radius
        rate = min(self.limits.circle_rate, self.speeds.level / radius, math.sqrt(self.limits.accel / radius))
        return 2 * math.pi * turns / rate

    def change_speed(self, kind: int, speed: float) -> None:
        """DO_CHANGE_SPEED: the kind says which speed (0 and 1 level, 2 climb, 3 descent); 0 or less changes nothing."""
        if speed > 0:
            now = self.speeds
            match kind:
                case 2:
                    self.speeds = Speeds(now.level, speed, now.descent)
                case 3:
                    self.speeds = Speeds(now.level, now.climb, speed)
                case _:
                    self.speeds = Speeds(speed, now.climb, now.descent)

    # --- legs -------------------------------------------------------------------------------------------------

    def leg_to(self, n: int, origin: Place, target: Place, previous: Leg | None) -> Leg:
        """The leg to visit n from `origin`, flown into from `previous` if that is given."""
        if self.route.visits[n].item.command != Command.NAV_SPLINE_WAYPOINT or math.dist(origin, target) < 1e-3:
            return straight_leg(origin, target, self.speeds, self.limits)
        onward = self.flies_on(n)
        after = None
        if onward is not None:
            bends_on = self.route.visits[onward].item.command == Command.NAV_SPLINE_WAYPOINT
            after = (self.target(onward), bends_on)
        return spline_leg(origin, target, previous, after, self.speeds, self.limits)

    def leg_now(self, n: int, target: Place) -> Leg:
        """The leg to visit n as it is begun: planned before, perhaps under way, perhaps at another speed since."""
        if self.planned is None:
            return self.leg_to(n, self.here, target, None)
        elapsed = float(self.state[21])
        if self.planned.shape is None or elapsed > JUST_BEGUN:
            return at_speeds(self.planned, self.speeds, elapsed)
        enter = float(self.state[25]) if self.tail is None else 0.0  # out of a spline a leg starts at its speed
        return straight_leg(self.here, target, self.speeds, self.limits, enter=enter)

    def fly(self, this: Leg, following: Leg | None) -> float:
        """Let time pass until `this` counts as passed; the highest level speed on it [m/s]."""
        expected = this.shape.lasts if this.shape is not None else this.length
        samples = self.room(8 * int((60 + 4 * expected) / (STEP * SAMPLE_STEPS)))
        before, onward = (NO_LEG if leg is None else as_numbers(leg) for leg in (self.tail, following))
        self.state[23] = 0.0
        packed = (self.pack(before), self.pack(as_numbers(this)), self.pack(onward))
        if not self.step_leg(*packed, self.pace, self.state, samples):
            raise MissionError(
                f"the copter does not reach {round(this.target[0])} m east and {round(this.target[1])} m north of home",
                hint="the wind may be stronger than it can fly against",
            )
        self.now = float(self.state[0])
        passed_over = self.state[22] if this.shape is not None and following is not None else 0.0
        self.state[20], self.state[21], self.state[22], self.state[24] = self.state[21], passed_over, 0.0, 0.0
        rows = np.asarray(samples[: int(self.state[23])]).reshape(-1, 8)
        self.samples += rows[:, :7].ravel().tolist()
        return float(np.hypot(rows[:, 4], rows[:, 5]).max()) if len(rows) else 0.0

    def straight_to(self, target: Place) -> None:
        """A leg of its own, from rest to rest."""
        if math.dist(self.here, target) > 1e-3:
            self.rest()
            self.fly(straight_leg(self.here, target, self.speeds, self.limits), None)
            self.here = target
        self.rest()

    # --- what is not a leg ------------------------------------------------------------------------------------

    def wait(self, seconds: float) -> None:
        """Stay here."""
        for t in (self.now + min(0.1, seconds), self.now + seconds):
            self.samples += (t, *self.here, 0.0, 0.0, 0.0)
        self.now += seconds
        self.rest()

    def rise(self, flown: Climb) -> None:
        """Follow a climb or descent straight up or down."""
        for t, height, rate in flown[::SAMPLE_STEPS] + flown[-1:]:
            self.samples += (self.now + t, self.here[0], self.here[1], height, 0.0, 0.0, rate)
        self.now += flown[-1][0]

    def take_off(self, height: float) -> None:
        """Spool up on the ground and climb to the height, but for a rest that is left to the next leg."""
        if not self.airborne:
            self.wait(ARMING_DELAY_S + 2 * self.limits.spool_up + LIFT_S)
            self.airborne = True
        if height > self.here[2]:
            self.rise(take_off(self.limits, self.here[2], height))
            self.here = (self.here[0], self.here[1], height - TAKEOFF_REST)
        self.rest()

    def return_home(self) -> None:
        """RTL: climb if below its height (no higher than a cone over home asks for), fly home, loiter, come down."""
        self.stand()
        x, y, z = self.here
        least = z + self.limits.rtl_climb
        height = max(least, self.limits.rtl_height)
        if self.limits.rtl_cone >= 0.5:
            height = min(height, max(math.hypot(x, y) * self.limits.rtl_cone, least))
        self.speeds = Speeds(self.limits.rtl_speed, self.limits.climb, self.limits.descent)
        top = x, y, max(z + RETURN_ROUNDING, height)
        climb = straight_leg(self.here, top, self.speeds, self.limits)
        if math.hypot(x, y) > 1e-3:
            home = straight_leg(top, (0.0, 0.0, top[2]), self.speeds, self.limits)
            self.fly(climb, home)
            self.tail = climb
            self.fly(home, None)
        else:
            self.fly(climb, None)
        self.here = 0.0, 0.0, top[2]
        self.rest()
        self.wait(self.limits.rtl_loiter)
        self.come_down(self.limits.rtl_final)

    def land_at(self, place: Place) -> None:
        """LAND: fly over its place, or the centimetre that rounding leaves to it, and come down."""
        over = place[0], place[1], self.here[2]
        if math.dist(self.here, over) > 1e-3:
            self.straight_to(over)
        elif self.airborne:
            below = self.here[0], self.here[1], self.here[2] - CENTIMETRE
            leg = straight_leg(self.here, below, self.speeds, self.limits)
            self.wait(LAND_BELOW * leg.shape.lasts if leg.shape is not None else 0.0)
        self.come_down(0.0)

    def stand(self) -> None:
        """Brake, where the last stop was come to too fast: on a curve that is shorter than ArduCopter brakes in."""
        speed = math.hypot(*self.passing)
        if speed > OVERRUNNING:
            way = speed**2 / (2 * self.limits.accel) + self.limits.accel / (2 * GAINS[0] ** 2)
            x, y, z = self.here
            self.here = x + way * self.passing[0] / speed, y + way * self.passing[1] / speed, z
            self.now += 2 * way / speed
            self.rest()
            self.samples += (self.now, *self.here, 0.0, 0.0, 0.0)

    def come_down(self, floor: float) -> None:
        """Descend to the floor; on the ground, until the landing is noticed."""
        self.rise(descend(self.limits, self.here[2], floor))
        self.here = (self.here[0], self.here[1], floor)
        if floor <= 0:
            self.wait(THROTTLE_DOWN_S + LAND_DETECTOR_S + self.limits.spool_up)
            self.airborne = False


def _packed(numbers: Any) -> Any:
    return np.array(numbers, dtype=np.float64)


def _zeros(count: int) -> list[float]:
    return [0.0] * count
