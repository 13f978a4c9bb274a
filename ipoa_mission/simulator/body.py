"""The vehicle itself: a point mass under gravity, air and a thrust that leans and grows with a lag.

Lean is kept as the horizontal acceleration that it gives at a thrust of one g: g tan(angle), east and north.
"""

import math
from dataclasses import dataclass

from ipoa_mission.simulator.vehicle import Vehicle

GRAVITY = 9.80665


@dataclass(frozen=True)
class Airframe:
    """What the makers of a simulated vehicle say of it; accelerations for each kilogram."""

    rotor_drag: float  # of rotors that turn the air, across their axis, for each m/s at a thrust of one g [1/s]
    body_drag: float  # for each (m/s)^2, across the rotors' axis and along it [1/m]
    most_thrust: float  # [m/s^2]
    motor_s: float  # lag of the thrust
    rate_loop_s: float  # lag of the lean behind what the attitude controller asks of the rates


#: ArduPilot's default quadrotor: 45 degrees of lean hold 15.08 m/s; of that drag, 0.2 v sqrt(T rho A) is the rotors'
#: (disc area 0.385 m^2, 3 kg) and the rest the body's, at air density 1.12 kg/m^3 there and 1.22 near sea level.
QUAD = Airframe(0.248, 0.0369, 25.0, 0.05, 0.1)


class Body(Vehicle):
    """Place and motion, east, north, up [m, m/s]; stands on the ground at height 0 until thrust lifts it."""

    def __init__(self, airframe: Airframe, wind: tuple[float, float] = (0.0, 0.0)) -> None:
        super().__init__(wind)
        self.airframe = airframe
        self.attitude_s = 0.15  # lag of the attitude that is asked for behind what the position controller wants
        self.ax = self.ay = self.az = 0.0
        self.thrust = 0.0  # vertical part [m/s^2]
        self.yaw_rate = 0.0
        self._aim_x = self._aim_y = 0.0
        self._fades = (0.0, 0.0, 0.0, 0.0)

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
        nx, ny, nz = self.lean_x / GRAVITY / slope, self.lean_y / GRAVITY / slope, 1.0 / slope
        along = wx * nx + wy * ny + wz * nz
        cx, cy, cz = wx - along * nx, wy - along * ny, wz - along * nz
        k = frame.rotor_drag * math.sqrt(self.thrust * slope / GRAVITY)
        k += frame.body_drag * math.sqrt(cx * cx + cy * cy + cz * cz)
        m = frame.body_drag * abs(along) * along
        ax = self.lean_x * self.thrust / GRAVITY - (k * cx + m * nx)
        ay = self.lean_y * self.thrust / GRAVITY - (k * cy + m * ny)
        az = self.thrust - GRAVITY - (k * cz + m * nz)
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
