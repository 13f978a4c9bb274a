"""The vehicle itself: a point mass under gravity, air and a thrust that leans and grows with a lag.

Lean is kept as the horizontal acceleration that it gives at a thrust of one g: g tan(angle), east and north.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

from ipoa_mission.wind import CALM, Wind

GRAVITY = 9.80665
Triple: TypeAlias = tuple[float, float, float]  # east, north, up


@dataclass(frozen=True)
class Airframe:
    """What the makers of a simulated vehicle say of it; accelerations for each kilogram."""

    linear_drag: float  # for each m/s, in any direction [1/s]
    most_thrust: float  # [m/s^2]
    motor_s: float  # lag of the thrust
    rate_loop_s: float  # lag of the lean behind what the attitude controller asks of the rates


#: PX4's SIH: 1 kg, 1 N for each m/s in any direction, four rotors of 5 N with 50 ms.
PX4_AIRFRAME = Airframe(linear_drag=1.0, most_thrust=20.0, motor_s=0.05, rate_loop_s=0.05)


class Body:
    """Place and motion, east, north, up [m, m/s]; stands on the ground at height 0 until thrust lifts it.

    PX4's pilot lets it `step`; ArduCopter's writes down where its own model has it.
    """

    def __init__(self, air: Wind = CALM, airframe: Airframe = PX4_AIRFRAME) -> None:
        self.airframe = airframe
        self.attitude_s = 0.15  # lag of the attitude that is asked for behind what the position controller wants
        self.air = air
        self.wind = air.east, air.north  # towards [m/s]
        self.x = self.y = self.z = 0.0
        self.vx = self.vy = self.vz = 0.0
        self.ax = self.ay = self.az = 0.0
        self.lean_x = self.lean_y = 0.0
        self.thrust = 0.0  # vertical part [m/s^2]
        self.yaw = self.yaw_rate = 0.0
        self.on_ground = True
        self._aim_x = self._aim_y = 0.0
        self._fades = (0.0, 0.0, 0.0, 0.0)

    @property
    def place(self) -> tuple[float, float, float]:
        """East, north, up [m]."""
        return self.x, self.y, self.z

    @property
    def motion(self) -> tuple[float, float, float]:
        """East, north, up [m/s]."""
        return self.vx, self.vy, self.vz

    def step(self, lean: tuple[float, float], thrust: float, dt: float) -> None:
        """Let `dt` pass while `lean` (g tan of the angle, east and north) and vertical `thrust` are asked for."""
        if self._fades[0] != dt:
            frame = self.airframe
            lags = (self.attitude_s, frame.rate_loop_s, frame.motor_s)
            self._fades = (dt, *(1.0 - math.exp(-dt / lag) for lag in lags))  # type: ignore[assignment]
        _, shaping, rates, motors = self._fades
        self._aim_x += shaping * (lean[0] - self._aim_x)
        self._aim_y += shaping * (lean[1] - self._aim_y)
        self.lean_x += rates * (self._aim_x - self.lean_x)
        self.lean_y += rates * (self._aim_y - self.lean_y)
        slope = math.sqrt(1.0 + (self.lean_x**2 + self.lean_y**2) / GRAVITY**2)
        most = self.airframe.most_thrust / slope
        self.thrust += motors * (min(max(thrust, 0.0), most) - self.thrust)
        self._fall(slope, dt)

    def _fall(self, slope: float, dt: float) -> None:
        """Newton's second law, and the ground."""
        frame = self.airframe
        wx, wy, wz = self.vx - self.wind[0], self.vy - self.wind[1], self.vz
        ax = self.lean_x * self.thrust / GRAVITY - frame.linear_drag * wx
        ay = self.lean_y * self.thrust / GRAVITY - frame.linear_drag * wy
        az = self.thrust - GRAVITY - frame.linear_drag * wz
        if self.z <= 0.0 and self.thrust <= GRAVITY:
            self.z = 0.0
            self.vx = self.vy = self.vz = self.ax = self.ay = self.az = 0.0
            self.on_ground = True
            return
        self.on_ground = False
        vx, vy, vz = self.vx + ax * dt, self.vy + ay * dt, self.vz + az * dt
        self.x += 0.5 * (self.vx + vx) * dt
        self.y += 0.5 * (self.vy + vy) * dt
        self.z += 0.5 * (self.vz + vz) * dt
        self.vx, self.vy, self.vz, self.ax, self.ay, self.az = vx, vy, vz, ax, ay, az
        if self.z < 0.0:
            self.z = 0.0
            self.vz = max(self.vz, 0.0)

    def turn(self, heading: float, most_rate: float, most_acceleration: float, dt: float) -> None:
        """Turn towards a heading within limits of rate and of its change [rad/s, rad/s^2]."""
        error = (heading - self.yaw + math.pi) % (2.0 * math.pi) - math.pi
        wanted = math.copysign(min(most_rate, math.sqrt(2.0 * most_acceleration * abs(error))), error)
        wanted = min(max(wanted, -abs(error) / dt), abs(error) / dt)
        change = min(max(wanted - self.yaw_rate, -most_acceleration * dt), most_acceleration * dt)
        self.yaw_rate += change
        self.yaw = (self.yaw + self.yaw_rate * dt) % (2.0 * math.pi)
