"""How PX4 leads along waypoints: a jerk-limited target that slows for the corner ahead and waits for the vehicle."""

import math

from ipoa_mission.autopilots.vehicle import Parameters
from ipoa_mission.simulator.body import Triple
from ipoa_mission.simulator.px4_smoothing import Axis, aim_together

AT_GOAL = 1e-5  # nearer than this nothing is aimed at [m]
STANDING = 1e-6  # a target slower than this has stopped [m/s]
TURNING = 0.98  # cosine between flying and aiming below which the vehicle is turning
LOOKAHEAD = 5.0  # least distance ahead on the leg that is aimed at in a turn [m]
SETPOINT_S = 0.06  # from a waypoint's being reached to the target's turning, as recorded at all waypoints


def speed_over(jerk: float, acceleration: float, distance: float, end: float) -> float:
    """The speed from which `end` can be reached within a distance, the ramps of jerk taken care of."""
    b = 4.0 * acceleration * acceleration / jerk
    return max(0.5 * (math.sqrt(b * b + 4.0 * (2.0 * acceleration * distance + end * end)) - b), end)


class PathFollower:
    """The moving target (`place`, `motion`, `push`) and the leg it follows: `last`, `goal`, `beyond`."""

    def __init__(self, parameters: Parameters) -> None:
        p = parameters
        jerk = p["MPC_JERK_AUTO"]
        self._jerk, self._acceleration, self._share = jerk, p["MPC_ACC_HOR"], p["MPC_XY_TRAJ_P"]
        self._rise, self._sink = p["MPC_ACC_UP_MAX"], p["MPC_ACC_DOWN_MAX"]
        self.climb = min(p["MPC_Z_V_AUTO_UP"], p.get("MPC_Z_VEL_MAX_UP", 3.0))
        self.descent = min(p["MPC_Z_V_AUTO_DN"], p.get("MPC_Z_VEL_MAX_DN", 1.5))
        self._error, self._height_radius = p["MPC_XY_ERR_MAX"], p["NAV_MC_ALT_RAD"]
        self._most = p["MPC_XY_VEL_MAX"]
        self.cruise = min(p["MPC_XY_CRUISE"], self._most)
        self.radius = p["NAV_ACC_RAD"]
        self.axes = (Axis(jerk, self._acceleration), Axis(jerk, self._acceleration), Axis(jerk, self._rise))
        self._held = self.cruise  # the speed that a turn may not exceed
        self._wanted: Triple = (0.0, 0.0, 0.0)
        self._coming: tuple[tuple[Triple, Triple, Triple], float] | None = None
        self._wait_s = 0.0
        self._turn_to(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))

    def begin(self, place: Triple, motion: Triple = (0.0, 0.0, 0.0)) -> None:
        """Start from here, on the leg given last."""
        self._wait_s = 0.0
        for axis, x, v in zip(self.axes, place, motion, strict=True):
            axis.begin(x, v)
        self._wanted = (0.0, 0.0, 0.0)

    def lead(self, last: Triple, goal: Triple, beyond: Triple | None, radius: float) -> None:
        """The leg to follow, and the waypoint after it if it is to be left without stopping; in `SETPOINT_S`."""
        self._coming = (last, goal, beyond if beyond is not None else goal), radius
        self._wait_s = SETPOINT_S

    def lift(self, by: float) -> None:
        """Move the leg up or down [m]; where the vehicle is beside it, it is looked for anew."""
        legs, radius = self._coming if self._coming is not None else (self._legs, self.radius)
        last, goal, beyond = ((x, y, z + by) for x, y, z in legs)
        if self._coming is not None:
            self._coming = (last, goal, beyond), radius
        else:
            self._turn_to((last, goal, beyond))

    def _turn_to(self, legs: tuple[Triple, Triple, Triple]) -> None:
        self._legs = self._points = legs
        self._state = "new"

    def set_speed(self, speed: float) -> None:
        """Cruise at another speed."""
        self.cruise = min(speed, self._most)

    @property
    def place(self) -> Triple:
        """Where the target is."""
        x, y, z = self.axes
        return x.place, y.place, z.place

    @property
    def motion(self) -> Triple:
        """How it moves."""
        x, y, z = self.axes
        return x.speed, y.speed, z.speed

    @property
    def push(self) -> Triple:
        """And how that changes."""
        x, y, z = self.axes
        return x.acceleration, y.acceleration, z.acceleration

    def advance(
        self,
        at: Triple,
        dt: float,
        climb: tuple[float, float] | None = None,
        sink: float | None = None,
        stay: bool = False,
    ) -> None:
        """Move the target on, more slowly when the vehicle (`at`) is behind.

        `climb`: rate and acceleration of a take-off in place of the usual; `sink`: descend at this rate, whatever
        the height of the goal; `stay`: brake, and go nowhere yet.
        """
        self._wait_s -= dt
        if self._coming is not None and self._wait_s <= 0.0:
            legs, self.radius = self._coming
            self._coming = None
            self._turn_to(legs)
        self._back_to_leg(at)
        self._limit_height(climb)
        wanted = (0.0, 0.0, 0.0) if stay else self._velocity(sink)
        x, y, _ = self.axes
        ex, ey = x.place - at[0], y.place - at[1]
        pace = 1.0
        standing = math.hypot(x.speed, y.speed) < STANDING
        if (standing or ex * x.speed + ey * y.speed >= 0.0) and self._error > 0.0:
            pace = 1.0 - min(math.hypot(ex, ey) / self._error, 1.0)
        for axis in self.axes:
            axis.advance(dt * pace)
        most = self.axes_most
        aim_together(self.axes, (wanted[0], wanted[1], min(max(wanted[2], -most[1]), most[0])))
        self._wanted = wanted

    def _limit_height(self, climb: tuple[float, float] | None) -> None:
        if self._wanted[2] > 0.0:
            rate, change = climb if climb is not None else (self.climb, self._rise)
            self.axes_most = (rate, rate)
            self.axes[2].accelerations = min(change, self._rise)
        else:
            self.axes_most = (self.descent, self.descent)
            self.axes[2].accelerations = self._sink

    def _back_to_leg(self, at: Triple) -> None:
        """Which points to fly to when the vehicle has left the leg: its end, its beginning, or its nearest point."""
        last, goal, beyond = self._legs
        ux, uy = goal[0] - last[0], goal[1] - last[1]
        length = math.hypot(ux, uy)
        state, nearest = "on", goal
        if length > 1e-6:
            ux, uy = ux / length, uy / length
            along = (at[0] - last[0]) * ux + (at[1] - last[1]) * uy
            nearest = (last[0] + ux * along, last[1] + uy * along, goal[2])
            if along > length:
                state = "past"
            elif along < 0.0 and math.hypot(at[0] - last[0], at[1] - last[1]) > self.radius:
                state = "before"
            elif math.hypot(at[0] - nearest[0], at[1] - nearest[1]) > self.radius:
                state = "off"
        if state == self._state and state != "off":
            return
        self._state = state
        if state == "past":
            self._points = (at, goal, beyond)
        elif state == "before":
            self._points = (at, last, goal)
        elif state == "off":
            self._points = (at, nearest, goal)
        else:
            self._points = self._legs

    def _velocity(self, sink: float | None) -> Triple:
        """The velocity to aim for, before jerk limits it."""
        x, y, z = self.axes
        last, goal, beyond = self._points
        dx, dy = goal[0] - x.place, goal[1] - y.place
        away, speed = math.hypot(dx, dy), math.hypot(x.speed, y.speed)
        aligned = (x.speed * dx + y.speed * dy) / (speed * away) if speed * away > 0.0 else 0.0
        turning = speed > 0.2 and aligned < TURNING and away > self.radius
        flat = self._flat_speed(away, dx, dy, goal, beyond)
        dz = goal[2] - z.place
        if turning:
            flat = min(flat, self._held)
            dx, dy, dz = self._ahead(last, goal)
        else:
            self._held = flat
        if sink is not None:
            size = math.hypot(dx, dy)
            return (dx * flat / size, dy * flat / size, -sink) if size > AT_GOAL else (0.0, 0.0, -sink)
        return _within(dx, dy, dz, flat, self._height_speed(goal, beyond))

    def _flat_speed(self, away: float, dx: float, dy: float, goal: Triple, beyond: Triple) -> float:
        """Cruise, or what the way to the goal and the corner there allow."""
        nx, ny = goal[0] - beyond[0], goal[1] - beyond[1]
        gap = math.hypot(nx, ny)
        corner = 0.0
        if gap > 0.001 and gap >= self.radius:
            cosine = (dx * nx + dy * ny) / (away * gap) if away > 0.0 else 0.0
            half = 0.5 * math.acos(min(max(cosine, -1.0), 1.0))
            turn = math.sqrt(self._share * self._acceleration * self.radius * math.tan(min(half, 0.5 * math.pi - 1e-7)))
            corner = min(turn, speed_over(self._jerk, self._acceleration, gap, 0.0), self.cruise)
        return min(self.cruise, speed_over(self._jerk, self._acceleration, away, corner))

    def _height_speed(self, goal: Triple, beyond: Triple) -> float:
        z = self.axes[2]
        end = 0.0
        if abs(goal[2] - beyond[2]) > 0.001:
            x, y, _ = self.place
            # as PX4 has it: the corner is judged in the plane of height and distance from the origin
            far, near, then = math.hypot(x, y), math.hypot(goal[0], goal[1]), math.hypot(beyond[0], beyond[1])
            a, b = (near - far, goal[2] - z.place), (near - then, goal[2] - beyond[2])
            sizes = math.hypot(*a) * math.hypot(*b)
            cosine = (a[0] * b[0] + a[1] * b[1]) / sizes if sizes > 0.0 else 0.0
            half = 0.5 * math.acos(min(max(cosine, -1.0), 1.0))
            end = math.sqrt(z.accelerations * self._height_radius * math.tan(min(half, 0.5 * math.pi - 1e-7)))
            end = min(end, self.axes_most[0])
        over = speed_over(self._jerk, z.accelerations, abs(goal[2] - z.place), end)
        return min(self.axes_most[0], over)

    def _ahead(self, last: Triple, goal: Triple) -> Triple:
        """From the target to a point on the leg, ahead of the nearest one."""
        leg = (goal[0] - last[0], goal[1] - last[1], goal[2] - last[2])
        length = math.sqrt(leg[0] * leg[0] + leg[1] * leg[1] + leg[2] * leg[2])
        ux, uy, uz = (d / length for d in leg) if length > 0.0 else leg
        x, y, z = self.place
        along = (x - last[0]) * ux + (y - last[1]) * uy + (z - last[2]) * uz
        nx, ny, nz = last[0] + ux * along - x, last[1] + uy * along - y, last[2] + uz * along - z
        reach = max(self.radius, LOOKAHEAD)
        ahead = math.sqrt(max(reach * reach - nx * nx - ny * ny - nz * nz, 0.0))
        return nx + ux * ahead, ny + uy * ahead, nz + uz * ahead


def _within(dx: float, dy: float, dz: float, flat: float, climb: float) -> Triple:
    """Along a direction, as fast as both the horizontal and the vertical limit allow."""
    size = math.sqrt(dx * dx + dy * dy + dz * dz)
    if size <= AT_GOAL:
        return 0.0, 0.0, 0.0
    speed = math.hypot(flat, climb)
    vx, vy, vz = dx * speed / size, dy * speed / size, dz * speed / size
    across = math.hypot(vx, vy)
    if across > flat:
        share = flat / across
        vx, vy = vx * share, vy * share
        if not (flat < 0.5 and across < 0.5):
            vz *= share
    if abs(vz) > climb:
        share = climb / abs(vz)
        if not (climb < 0.5 and abs(vz) < 0.5):
            vx, vy = vx * share, vy * share
        vz *= share
    return vx, vy, vz
