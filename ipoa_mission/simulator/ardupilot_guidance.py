"""How ArduCopter leads along waypoints: legs planned from rest to rest, overlapped in time where a corner allows it.

The clock of the path waits for the vehicle. Splines are joined at the speed that both sides allow.
"""

import math
from dataclasses import dataclass

from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.simulator.body import Body
from ipoa_mission.simulator.scurve import Leg, Shaping, Triple
from ipoa_mission.simulator.spline_leg import SplineLeg, most_along

NOWHERE: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Stop:
    """Where to fly: along a straight line, or a spline that leaves towards `beyond` when more follows."""

    place: Triple
    spline: bool = False
    beyond: Triple | None = None  # the waypoint after it
    beyond_is_spline: bool = False


class PathFollower:
    """The moving target: `place`, `motion` and `push` are what the position controller follows."""

    def __init__(self, parameters: Parameters) -> None:
        p = parameters
        self.speeds: Triple = (p["WPNAV_SPEED"] / 100, p["WPNAV_SPEED_UP"] / 100, p["WPNAV_SPEED_DN"] / 100)
        self._acceleration, self._rising = p["WPNAV_ACCEL"] / 100, p["WPNAV_ACCEL_Z"] / 100
        self._corner = p["WPNAV_ACCEL_C"] / 100 or 2.0 * self._acceleration
        self._radius = max(p["WPNAV_RADIUS"] / 100, 0.05)
        self._jerk = p["WPNAV_JERK"]
        self._snap = math.pi * self._jerk / (4.0 * max(p["ATC_INPUT_TC"], 0.1))
        self._gain = p.get("PSC_POSXY_P", 1.0)
        self.begin(NOWHERE)

    def begin(self, place: Triple) -> None:
        """Start from rest at a place: the vehicle's, or where it can come to a stop."""
        self.place, self.motion, self.push = place, NOWHERE, NOWHERE
        self.pace = 1.0
        self._last: Leg | None = None
        self._this: Leg | SplineLeg = Leg(place, place, self._shaping(NOWHERE))
        self._next: Leg | SplineLeg | None = None
        self._spare_s = 0.0
        self.reached = True

    def _shaping(self, direction: Triple) -> Shaping:
        return Shaping(
            max(most_along(direction, *self.speeds), 0.1),
            max(most_along(direction, self._acceleration, self._rising, self._rising), 0.1),
            self._jerk,
            self._snap,
        )

    # --- laying legs ------------------------------------------------------------------------------------------------

    def fly_to(self, stop: Stop, following: Stop | None) -> None:
        """The next leg begins; what follows it decides whether it ends in a stop."""
        before, fast = self._this, self._next is not None
        origin = before.destination
        if isinstance(before, Leg) and fast and not stop.spline:
            self._last = before
        else:
            self._last = None
        leg = self._next
        if leg is not None and leg.destination == stop.place and isinstance(leg, SplineLeg) == stop.spline:
            self._this = leg
        else:
            self._this = self._leg(before if fast else None, origin, stop)
        self._next = None
        self.reached = False
        if following is not None:
            self._next = self._leg(self._this, stop.place, following)
            self._join(self._this, self._next)

    def _leg(self, before: Leg | SplineLeg | None, origin: Triple, stop: Stop) -> Leg | SplineLeg:
        """A leg to a stop; `before` is the one that is left without stopping."""
        if not stop.spline:
            towards = _minus(stop.place, origin)
            length = math.hypot(*towards)
            unit: Triple = (towards[0] / length, towards[1] / length, towards[2] / length) if length > 0.0 else NOWHERE
            start = before.end_speed if isinstance(before, SplineLeg) else 0.0
            return Leg(origin, stop.place, self._shaping(unit), start)
        if isinstance(before, SplineLeg):
            leaving = before.arriving
        else:
            leaving = _minus(before.destination, before.origin) if before is not None else NOWHERE
        arriving = NOWHERE
        if stop.beyond is not None:
            arriving = _minus(stop.beyond, origin if stop.beyond_is_spline else stop.place)
        return SplineLeg(origin, stop.place, leaving, arriving, self.speeds, self._acceleration, self._rising)

    def _join(self, this: Leg | SplineLeg, following: Leg | SplineLeg) -> None:
        """Give a leg the speed at which the one after it may be entered, where either is a spline."""
        if isinstance(following, SplineLeg):
            if isinstance(this, Leg):
                following.start_speed = this.end_at(following.start_speed)
            else:
                this.end_speed = min(this.end_speed, following.start_speed)
        elif isinstance(this, SplineLeg):
            this.end_speed = following.start_at(this.end_speed)

    def change_speed(self, speed: float) -> None:
        """Another horizontal speed, from here on."""
        self.speeds = (speed, *self.speeds[1:])
        for leg in (self._this, self._next):
            if isinstance(leg, Leg):
                leg.change_speed(self._shaping(leg.direction))
            elif isinstance(leg, SplineLeg):
                leg.speeds = self.speeds

    # --- moving along them ------------------------------------------------------------------------------------------

    def advance(self, body: Body, dt: float) -> None:
        """Move the target on by `dt`, or by less when the vehicle is behind it."""
        self.pace += (self._wanted_pace(body) - self.pace) * dt / (self._acceleration / self._jerk + dt)
        step = self.pace * dt + self._spare_s
        self._spare_s = 0.0
        leg = self._this
        done = self._along_spline(leg, step) if isinstance(leg, SplineLeg) else self._along_legs(leg, step)
        if not self.reached and done:
            self.reached = self._next is not None or math.dist(body.place, self._this.destination) <= self._radius

    def _wanted_pace(self, body: Body) -> float:
        """0.05 + (v.d - k_p e.d)/|v_target|, from 0 to 1: the target may not run away from the vehicle."""
        speed = math.hypot(*self.motion)
        if speed <= 1e-6:
            return 1.0
        flown = lag = 0.0
        for target, at, aim, is_ in zip(self.place, body.place, self.motion, body.motion, strict=True):
            flown += is_ * aim / speed
            lag += (target - at) * aim / speed
        return min(max(0.05 + (flown - self._gain * lag) / speed, 0.0), 1.0)

    def _along_spline(self, leg: SplineLeg, dt: float) -> bool:
        direction, speed = leg.advance(math.hypot(*self.motion), dt)
        self.place = leg.place()
        self.motion = (direction[0] * speed, direction[1] * speed, direction[2] * speed)
        self.push = NOWHERE
        if leg.finished and self._next is not None:
            self._spare_s = leg.spare_s
        return leg.finished

    def _along_legs(self, leg: Leg, dt: float) -> bool:
        following = self._next if isinstance(self._next, Leg) else None
        overlapping = following is not None and following.clock > 0.0
        for one in (self._last, leg, following if overlapping else None):
            if one is not None:
                one.clock += dt
        done = leg.finished
        if following is not None and overlapping:
            done = following.clock >= leg.remaining
        elif following is not None and self._may_turn(leg, following):
            following.clock = dt
        elif done and self._next is not None:
            self._spare_s = leg.clock - leg.total
        self._sum(leg, following)
        return done

    def _sum(self, leg: Leg, following: Leg | None) -> None:
        """Add up the motions that are under way."""
        place, motion, push = list(leg.origin), [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        for one in (self._last, leg, following):
            if one is None or (one is following and one.clock <= 0.0):
                continue
            s, v, a = one.at(one.clock)
            if one is self._last:
                s = min(s - one.length, 0.0)
            for i, u in enumerate(one.direction):
                place[i] += u * s
                motion[i] += u * v
                push[i] += u * a
        self.place, self.motion, self.push = tuple(place), tuple(motion), tuple(push)  # type: ignore[assignment]

    def _may_turn(self, leg: Leg, following: Leg) -> bool:
        """Whether the next leg may begin now: judged at the middle of the overlap."""
        left = leg.remaining
        if leg.clock < leg.turn_out - following.turn_in or left >= 0.5 * following.total:
            return False
        s, _, _ = leg.at(leg.clock)
        if s < 0.5 * leg.length:
            return False
        s1, v1, a1 = leg.at(leg.clock + 0.5 * left)
        s2, v2, a2 = following.at(0.5 * left)
        place, motion, push = (
            [x * u + y * w for u, w in zip(leg.direction, following.direction, strict=True)]
            for x, y in ((s1 - leg.length, s2), (v1, v2), (a1, a2))
        )
        return (
            math.hypot(*place) < self._radius
            and math.hypot(*motion[:2]) < min(leg.peak, following.peak)
            and math.hypot(*push[:2]) < self._corner
            and abs(push[2]) < self._rising
        )


def _minus(a: Triple, b: Triple) -> Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
