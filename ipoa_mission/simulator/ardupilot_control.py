"""ArduCopter's position controller: position error -> velocity -> PID -> lean and climb; the path tells ahead."""

import math

from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.simulator.body import GRAVITY, Body
from ipoa_mission.simulator.scurve import Triple


def speed_towards(error: float, gain: float, most_acceleration: float) -> float:
    """Proportional when near; farther away as fast as braking with `most_acceleration` allows."""
    near = most_acceleration / gain**2
    if abs(error) <= near:
        return gain * error
    return math.copysign(math.sqrt(2.0 * most_acceleration * (abs(error) - 0.5 * near)), error)


class PositionControl:
    """State of the horizontal PID: integral and filtered error."""

    def __init__(self, parameters: Parameters) -> None:
        get = parameters.get
        self._p, self._pz = get("PSC_POSXY_P", 1.0), get("PSC_POSZ_P", 1.0)
        self._vp, self._vi, self._vd = get("PSC_VELXY_P", 2.0), get("PSC_VELXY_I", 1.0), get("PSC_VELXY_D", 0.5)
        self._filter_s = 1.0 / (2.0 * math.pi * get("PSC_VELXY_FLTE", 5.0))
        self._vzp = get("PSC_VELZ_P", 5.0)
        self._acceleration, self._rising = parameters["WPNAV_ACCEL"] / 100, parameters["WPNAV_ACCEL_Z"] / 100
        self.most_lean = GRAVITY * math.tan(math.radians(parameters["ANGLE_MAX"] / 100))
        self.reset()

    def reset(self) -> None:
        """Forget what was learned of drag and wind."""
        self._integral = [0.0, 0.0]
        self._error = [0.0, 0.0]
        self._rate = [0.0, 0.0]
        self._fresh = True

    def lean(self, body: Body, place: Triple, motion: Triple, push: Triple, dt: float) -> tuple[float, float]:
        """Horizontal acceleration to ask for, east and north [m/s^2]."""
        ex, ey = place[0] - body.x, place[1] - body.y
        away = math.hypot(ex, ey)
        share = speed_towards(away, self._p, self._acceleration) / away if away > 1e-9 else 0.0
        errors = (ex * share + motion[0] - body.vx, ey * share + motion[1] - body.vy)
        fade = dt / (dt + self._filter_s)
        asked = [0.0, 0.0]
        for i, error in enumerate(errors):
            was = self._error[i]
            self._error[i] = error if self._fresh else was + fade * (error - was)
            rate = 0.0 if self._fresh else (self._error[i] - was) / dt
            self._rate[i] += fade * (rate - self._rate[i])
            asked[i] = self._vp * self._error[i] + self._integral[i] + self._vd * self._rate[i] + push[i]
        self._fresh = False
        given = self._within_lean(asked, motion)
        gain = (self._vi * self._error[0] * dt, self._vi * self._error[1] * dt)
        was = math.hypot(*self._integral)
        self._integral = [self._integral[0] + gain[0], self._integral[1] + gain[1]]
        if given is not asked and gain[0] * asked[0] + gain[1] * asked[1] > 0.0:
            size = math.hypot(*self._integral)
            if size > was:
                self._integral = [i * was / size for i in self._integral]
        return given[0], given[1]

    def _within_lean(self, asked: list[float], motion: Triple) -> list[float]:
        """Keep to the greatest lean; across the way that is flown first, along it with what remains."""
        most = self.most_lean
        if math.hypot(*asked) <= most:
            return asked
        speed = math.hypot(motion[0], motion[1])
        if speed <= 0.0:
            return [a * most / math.hypot(*asked) for a in asked]
        ux, uy = motion[0] / speed, motion[1] / speed
        along, across = asked[0] * ux + asked[1] * uy, asked[1] * ux - asked[0] * uy
        across = min(max(across, -most), most)
        rest = math.sqrt(most * most - across * across)
        along = min(max(along, -rest), rest)
        return [along * ux - across * uy, along * uy + across * ux]

    def thrust(self, body: Body, height: float, climb: float, push: float) -> float:
        """Vertical thrust to ask for [m/s^2]."""
        wanted = speed_towards(height - body.z, self._pz, self._rising) + climb
        return GRAVITY + push + self._vzp * (wanted - body.vz)


class ShapedHeight:
    """A height that moves within limits of acceleration and jerk, where no leg is planned: take-off and landing."""

    def __init__(self, parameters: Parameters) -> None:
        self._acceleration, self._jerk = parameters["WPNAV_ACCEL_Z"] / 100, parameters["PSC_JERK_Z"]
        self.begin(0.0, 0.0)

    def begin(self, height: float, climb: float) -> None:
        """Start from here."""
        self.height, self.climb, self.push = height, climb, 0.0

    def approach(self, target: float, most: float, dt: float) -> None:
        """Towards a height, braking with half of the acceleration."""
        gain = 0.5 * self._jerk / self._acceleration
        speed = speed_towards(target - self.height, gain, 0.5 * self._acceleration)
        self.sink_or_climb(min(max(speed, -most), most), dt)

    def sink_or_climb(self, climb: float, dt: float) -> None:
        """Towards a climb rate."""
        push = self._jerk / self._acceleration * (climb - self.climb)
        push = min(max(push, -self._acceleration), self._acceleration)
        self.push += min(max(push - self.push, -self._jerk * dt), self._jerk * dt)
        self.height += (self.climb + 0.5 * self.push * dt) * dt
        self.climb += self.push * dt
