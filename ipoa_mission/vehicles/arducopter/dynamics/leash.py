"""ArduCopter 3.x: a copter led to its waypoints on a leash, without S-curves.

A point runs ahead of the copter along the straight line to the waypoint. It gains speed at twice the acceleration of
waypoints, and is held back where it has run ahead by the way in which the copter could stop. The copter aims for a
velocity that grows with how far the point is away, linearly, then with the square root. A waypoint counts as soon as
the point has come to it, and the next leg begins at the copter's speed; where the copter is to stay, the point brakes,
and the copter must come within WPNAV_RADIUS. So ArduPilot's documentation of the controller before 4.0 has it.
"""

import math
from collections.abc import Iterator

import numpy as np

from ipoa_mission.errors import MissionError
from ipoa_mission.geometry import Points
from ipoa_mission.itinerary.program import Place
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter, Stop
from ipoa_mission.vehicles.arducopter.dynamics.legs import limits_along, straight_leg
from ipoa_mission.vehicles.arducopter.dynamics.motion import HOLD, NO_LEG, STEP, STRAIGHT, Leg, Vector
from ipoa_mission.vehicles.arducopter.dynamics.scurve import Limits
from ipoa_mission.vehicles.arducopter.dynamics.steps import SAMPLE_STEPS, control, move, towards

SLOWEST_POINT = 0.5  # the point brakes down to this speed and no further [m/s]
EAGER = 2.0  # times the acceleration of waypoints, with which the point gains and loses speed
PATIENCE_S, PATIENCE = 60.0, 6.0  # a leg may last so long, and so many times as long as at its speed


class LeashedCopter(Copter):
    """A `Copter` whose straight legs are flown on a leash; splines are flown straight."""

    _stays = True  # whether the copter is to stand at the end of the leg

    def _fly_to(self, stop: Stop, following: Stop | None = None) -> None:
        """Begin a leg where the last one's point stands; with a stop `following` it is not braked for."""
        origin = self.this.target if self.passed and self.this.kind in (STRAIGHT, HOLD) else Vector(*self.place)
        this = straight_leg(origin, stop.place, self.speeds, self.limits)
        self._before = NO_LEG
        self.state.clock = 0.0
        onward = None if following is None else straight_leg(stop.place, following.place, self.speeds, self.limits)
        self._begin(this, onward or NO_LEG)
        self._stays = stop.stays
        way = this.direction
        self.state.speed = max(self.state.vx * way.x + self.state.vy * way.y + self.state.vz * way.z, 0.0)

    @property
    def here(self) -> Place:
        """Where the next leg begins: where the point of the last one stands, or where the copter can come to a stop."""
        return self.this.target if self.passed else self.stopping_place()

    @property
    def spool_down(self) -> float:
        """None: before 4.0 it disarms as soon as it has landed."""
        return 0.0

    def land(self, place: Place | None) -> Iterator[None]:
        """LAND: fly over its place and come down; None: come down."""
        if place is not None:
            self.fly_to(Stop((*place[:2], self.state.z)))
            yield
        self.descend()
        yield

    def step(self) -> bool:
        """Let one step pass; whether the leg is over."""
        if self.this.kind != STRAIGHT:
            return super().step()
        over = self._led()
        control(self.state, self._tuning)
        move(self.state, self._tuning)
        self.passed = self.passed or over
        return self.passed

    def run(self) -> Points:
        """Let time pass to the end of the leg; samples of the track: time, place, velocity (n, 7).

        Raises:
            MissionError: it does not get there.
        """
        if self.this.kind != STRAIGHT:
            return super().run()
        until = self.state.time + PATIENCE_S + PATIENCE * self.this.length / self._along().speed
        rows: list[tuple[float, ...]] = []
        count, over = 0, False
        while not over:
            over, count, state = self.step(), count + 1, self.state
            if count % SAMPLE_STEPS == 0:
                rows.append((state.time, state.x, state.y, state.z, state.vx, state.vy, state.vz))
            if state.time > until:
                raise MissionError(self._lost(-1))
        return np.array(rows, dtype=np.float64).reshape(-1, 7)

    def _along(self) -> Limits:
        """The most along the leg."""
        return limits_along(self.this.origin, self.this.target, self.this.speeds, self.limits)

    def _led(self) -> bool:
        """Move the point on, and tell the controllers what to aim for; whether the waypoint counts."""
        state, leg, fast = self.state, self.this, not self._stays
        along, way, gain = self._along(), leg.direction, self._tuning.p_position
        off = state.x - leg.origin.x, state.y - leg.origin.y, state.z - leg.origin.z
        flown = off[0] * way.x + off[1] * way.y + off[2] * way.z
        aside = math.hypot(off[0] - flown * way.x, off[1] - flown * way.y)
        near = along.accel / gain**2
        leash = near / 2 + along.speed**2 / (2 * along.accel) if along.speed > near * gain else along.speed / gain
        farthest = flown + max(leash - aside, 0.0)
        speed = state.vx * way.x + state.vy * way.y + state.vz * way.z
        linear = along.accel / gain
        change = EAGER * along.accel * STEP
        if state.share > farthest:  # the leash is taut
            state.speed = max(state.speed - change, 0.0)
        else:
            state.speed = min(state.speed + change, along.speed)
            if not fast:
                left = max(leg.length - state.share, 0.0)
                braked = max(math.sqrt(2 * EAGER * along.accel * left), SLOWEST_POINT)
                state.speed = min(state.speed, braked)
            if abs(speed) < linear:
                state.speed = min(max(state.speed, speed - linear), speed + linear)
            state.share = min(state.share + state.speed * STEP, max(farthest, state.share))
        if not fast:
            state.share = min(state.share, leg.length)
        self._aim(leg)
        if state.share < leg.length:
            return False
        to = leg.target.x - state.x, leg.target.y - state.y, leg.target.z - state.z
        return fast or math.hypot(*to) <= self._tuning.radius

    def _aim(self, leg: Leg) -> None:
        """A velocity towards the point, for the velocity controller, and its change."""
        state, way, tuning, limits = self.state, leg.direction, self._tuning, self.limits
        x = leg.origin.x + state.share * way.x - state.x
        y = leg.origin.y + state.share * way.y - state.y
        z = leg.origin.z + state.share * way.z - state.z
        far, before = math.hypot(x, y), (state.aim_x, state.aim_y)
        speed = min(towards(far, limits.accel, tuning.p_position), leg.speeds.level) if far > 0 else 0.0
        share = speed / far if far > 0 else 0.0
        state.aim_x, state.aim_y = share * x, share * y
        state.push_x, state.push_y = (state.aim_x - before[0]) / STEP, (state.aim_y - before[1]) / STEP
        size, most = math.hypot(state.push_x, state.push_y), EAGER * limits.accel
        if size > most:
            state.push_x, state.push_y = state.push_x * most / size, state.push_y * most / size
        state.target_x, state.target_y = state.x + state.vx * STEP, state.y + state.vy * STEP
        climb = min(max(towards(z, limits.accel_z, tuning.p_height), -leg.speeds.down), leg.speeds.up)
        state.aim_z += min(max(climb - state.aim_z, -limits.accel_z * STEP), limits.accel_z * STEP)
        state.target_z, state.rate = state.z + state.aim_z * STEP, 1.0
