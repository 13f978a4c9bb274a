"""PX4's position controller: position error -> velocity -> PID -> acceleration -> lean within the greatest tilt."""

import math

from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.simulator.body import GRAVITY, Body, Triple
from ipoa_mission.simulator.px4_hover import HoverThrust

DERIVATIVE_S = 1.0 / (2.0 * math.pi * 5.0)  # MPC_VELD_LP


class PositionControl:
    """State of the velocity PID, east, north, up."""

    def __init__(self, parameters: Parameters, most_thrust: float) -> None:
        get = parameters.get
        self._p = (parameters["MPC_XY_P"], parameters["MPC_Z_P"])
        self._flat = (get("MPC_XY_VEL_P_ACC", 1.8), get("MPC_XY_VEL_I_ACC", 0.4), get("MPC_XY_VEL_D_ACC", 0.2))
        self._up = (get("MPC_Z_VEL_P_ACC", 4.0), get("MPC_Z_VEL_I_ACC", 2.0), get("MPC_Z_VEL_D_ACC", 0.0))
        self._most = parameters["MPC_XY_VEL_MAX"]
        self.most_lean = GRAVITY * math.tan(math.radians(min(get("MPC_TILTMAX_AIR", 45.0), 89.0)))
        self._margin = get("MPC_THR_XY_MARG", 0.3) * most_thrust
        self._full_thrust = most_thrust
        self._hover = HoverThrust(parameters, most_thrust)
        self.reset()

    def reset(self) -> None:
        """Forget what was learned of drag, wind and weight."""
        self._integral = [0.0, 0.0, 0.0]
        self._was: Triple | None = None
        self._rate = [0.0, 0.0, 0.0]

    def lean_and_thrust(
        self,
        body: Body,
        seen: tuple[Triple, Triple],
        place: Triple,
        motion: Triple,
        push: Triple,
        climbs: tuple[float, float],
        dt: float,
    ) -> tuple[tuple[float, float], float]:
        """Horizontal acceleration and vertical thrust to ask for; `seen` is the estimated place and motion.

        `climbs`: the highest rates up and down.
        """
        at, flown = seen
        self._learn_to_hover(body, dt)
        most_thrust = self._full_thrust / self._hover.ratio  # from here on as PX4 believes thrust to be
        self._differentiate(flown, dt)
        wanted = self._velocity(at, place, motion, climbs)
        errors = [w - v for w, v in zip(wanted, flown, strict=True)]
        asked = [
            p * e + i - d * r + a
            for (p, d), e, i, r, a in zip(
                ((self._flat[0], self._flat[2]), (self._flat[0], self._flat[2]), (self._up[0], self._up[2])),
                errors,
                self._integral,
                self._rate,
                push,
                strict=True,
            )
        ]
        size = math.hypot(asked[0], asked[1])
        lean = min(size, self.most_lean)
        thrust = max(GRAVITY + asked[2], 0.0)
        flat = lean * thrust / GRAVITY
        top = math.sqrt(max(most_thrust**2 - min(flat, self._margin) ** 2, 0.0))
        if not ((thrust >= top and errors[2] > 0.0) or (thrust <= 0.0 and errors[2] < 0.0)):
            self._integral[2] += self._up[1] * errors[2] * dt
        self._integral[2] = min(max(self._integral[2], -GRAVITY), GRAVITY)
        thrust = min(thrust, top)
        flat = min(flat, math.sqrt(max(most_thrust**2 - thrust**2, 0.0)))
        share = flat / size if size > 1e-9 else 1.0
        for i in range(2):
            lost = asked[i] * (1.0 - share) if flat < size else 0.0
            self._integral[i] += self._flat[1] * (errors[i] - 2.0 / self._flat[0] * lost) * dt
        lean = flat * GRAVITY / thrust if thrust > 0.1 else 0.0
        leaning = (asked[0] * lean / size, asked[1] * lean / size) if size > 1e-9 else (0.0, 0.0)
        return leaning, thrust * self._hover.ratio

    def _learn_to_hover(self, body: Body, dt: float) -> None:
        """A change of what hovering takes must not change the thrust: the integrator makes up for it."""
        if body.on_ground:
            return
        before = self._hover.ratio
        self._hover.learn(body.thrust, body.az, body.vz, dt)
        self._integral[2] = (GRAVITY + self._integral[2]) * before / self._hover.ratio - GRAVITY

    def _differentiate(self, flown: Triple, dt: float) -> None:
        if self._was is not None:
            fade = dt / (dt + DERIVATIVE_S)
            for i in range(3):
                self._rate[i] += fade * ((flown[i] - self._was[i]) / dt - self._rate[i])
        self._was = flown

    def _velocity(self, at: Triple, place: Triple, motion: Triple, climbs: tuple[float, float]) -> Triple:
        """Velocity to fly; towards the place comes before what the path foresees when both are too much."""
        gain = self._p[0]
        cx, cy = (place[0] - at[0]) * gain, (place[1] - at[1]) * gain
        vx, vy = cx + motion[0], cy + motion[1]
        if math.hypot(vx, vy) > self._most:
            vx, vy = _constrain(cx, cy, motion[0], motion[1], self._most)
        cz = (place[2] - at[2]) * self._p[1]
        return vx, vy, min(max(cz + motion[2], -climbs[1]), climbs[0])


def _constrain(cx: float, cy: float, fx: float, fy: float, most: float) -> tuple[float, float]:
    """The correction (c) whole as far as it fits, and as much of the foreseen (f) as then does."""
    size = math.hypot(cx, cy)
    if size >= most:
        return cx * most / size, cy * most / size
    foreseen = math.hypot(fx, fy)
    ux, uy = fx / foreseen, fy / foreseen
    inline = cx * ux + cy * uy
    more = math.sqrt(max(inline * inline - size * size + most * most, 0.0)) - inline
    return cx + ux * more, cy + uy * more
