"""ArduCopter's modes in the built-in autopilot: items and orders to legs."""

import math
import random
from collections.abc import Callable, Iterator

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.geometry import GRAVITY, Place
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.situation import STEP_S, FlightMode, SimulatedVehicle, Situation
from ipoa_mission.vehicles.arducopter.dynamics.airframe import airframe_of
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter, stop_at
from ipoa_mission.vehicles.arducopter.dynamics.motion import Kind
from ipoa_mission.vehicles.arducopter.dynamics.procedures import (
    circle,
    land,
    landing_place,
    loiter_to_alt,
    payload_place,
    return_home,
)
from ipoa_mission.vehicles.arducopter.limits import LANDED_S, copter_limits


class ArduCopterController:
    """Give the copter its next leg: of the procedure, or by `_on_arrival`."""

    def __init__(
        self, body: SimulatedVehicle, situation: Situation, parameters: Parameters, chance: random.Random
    ) -> None:
        """Ignore `chance`: SITL flights repeat to a tenth of a second."""
        self._body, self._now, self._parameters = body, situation, parameters
        conditions = body.conditions
        limits = copter_limits(parameters, conditions.version)
        airframe = airframe_of(conditions.vehicle).at_altitude(situation.program.frame.home.altitude)
        self._copter = Copter(limits, conditions.wind, airframe, ground=conditions.ground)
        self._copter.start_at(body.place)
        self._landing_s = LANDED_S + airframe.landing_delay
        self._legs: Iterator[None] = iter(())
        self._on_arrival: Callable[[], None] | None = None
        self._flying = False
        self._touched_s: float | None = None
        self._floor = self._copter.state.z
        self._copter.face(body.yaw)
        self._lift_s = limits.lift_off_s + airframe.lift_delay

    def enter(self) -> None:
        match self._now.mode:
            case FlightMode.MISSION:
                self._begin_after(self._now.current - 1)
            case FlightMode.RETURN:
                self._come_down(self._return())
            case FlightMode.LAND:
                self._come_down(land(self._copter, None))
            case FlightMode.HOLD:
                self._stay()

    def follow_new_mission(self, before: tuple[Item, ...]) -> None:
        """Continue in the new mission; restart at the waypoint if the next items differ."""
        now, after = self._now.current, self._now.program.items
        ahead = slice(now, now + 3)
        if self._on_arrival == self._arrived and before[ahead] != after[ahead] and now < len(after):
            self._begin_after(now - 1)

    def go_to(self, east: float, north: float, up: float, speed: float) -> None:
        """ArduCopter has no such command."""

    def _return(self) -> Iterator[None]:
        return return_home(self._copter, self._now.goal_of_return(self._copter.place, self._parameters))

    def climb(self, height: float) -> None:
        self._take_off(height, self._stay)

    @property
    def rising(self) -> bool:
        return self._flying and self._on_arrival == self._stay

    def step(self) -> None:
        lifting = self._now.armed and self._now.time_s - self._now.armed_s >= self._lift_s
        if not (self._now.armed or self._body.on_ground):
            self._fall()
        elif self._touched_s is not None:
            self._stand(self._now.time_s - self._touched_s)
        elif self._flying and lifting and self._copter.step():
            self._go_on()
        self._update_body()

    def _begin_after(self, index: int) -> None:
        """Start the next item with a duration."""
        item = self._now.come_to(index, lambda item: self._copter.change_speed(int(item.params[0]), item.params[1]))
        if item is None:
            self._stay()
        else:
            self._start(self._now.current, item)

    def _done(self) -> None:
        self._now.done(self._now.current)
        self._begin_after(self._now.current)

    def _start(self, index: int, item: Item) -> None:
        match item.command:
            case Command.NAV_TAKEOFF | Command.NAV_VTOL_TAKEOFF:
                self._take_off(self._place(index)[2], self._done)
            case Command.NAV_DELAY:
                self._copter.hold(self._copter.wait_at(item))
                self._on_arrival, self._flying = self._done, True
            case _ if self._now.landed:
                self._flying = False
            case Command.NAV_RETURN_TO_LAUNCH:
                self._come_down(self._return())
            case Command.NAV_LOITER_TURNS:
                self._go(circle(self._copter, self._place(index), item))
            case Command.NAV_LOITER_TO_ALT:
                self._go(loiter_to_alt(self._copter, self._place(index)))
            case Command.NAV_PAYLOAD_PLACE:
                self._go(payload_place(self._copter, self._place(index) if item.has_position else None, item))
            case Command.NAV_LAND | Command.NAV_VTOL_LAND:
                self._come_down(land(self._copter, landing_place(self._now.program, item)))
            case _:
                program = self._now.program
                onward, stop = program.onward(index), stop_at(program, index, self._copter.place)
                self._copter.fly_to(stop, None if onward is None else stop_at(program, onward, stop.place))
                self._on_arrival = self._arrived

    def _place(self, index: int) -> Place:
        return self._now.program.place(index, self._copter.place)

    def _go_on(self) -> None:
        if next(self._legs, self) is self and self._on_arrival is not None:
            then, self._on_arrival = self._on_arrival, None
            then()

    def _arrived(self) -> None:
        seconds = self._copter.wait_at(self._now.program.items[self._now.current])
        if seconds > 0:
            self._copter.hold(seconds)
            self._on_arrival = self._done
        else:
            self._done()

    def _take_off(self, height: float, then: Callable[[], None]) -> None:
        self._copter.take_off(height)
        self._legs, self._on_arrival = iter(()), then
        self._now.landed, self._flying = False, True

    def _go(self, legs: Iterator[None]) -> None:
        self._legs, self._on_arrival = legs, self._done
        next(legs)

    def _come_down(self, legs: Iterator[None]) -> None:
        if self._now.landed:
            return
        self._legs, self._on_arrival = legs, self._touch
        next(legs)

    def _touch(self) -> None:
        if self._copter.this.kind == Kind.DESCENT:
            self._touched_s = self._now.time_s
            self._copter.wait_on_ground(0.0)
            self._floor = self._copter.state.z

    def _stand(self, seconds: float) -> None:
        self._now.landed = seconds >= self._landing_s
        if seconds >= self._landing_s + self._copter.limits.spool_up:
            is_mission = self._now.mode is FlightMode.MISSION
            lands = is_mission and self._now.program.items[self._now.current].command == Command.NAV_LAND
            self._now.end_on_ground(announced=not lands)
            self._touched_s = None
            self._flying = False

    def _fall(self) -> None:
        """Fall to the ground without thrust; drag is neglected."""
        state = self._copter.state
        state.vz -= GRAVITY * STEP_S
        state.place += state.velocity * STEP_S
        state.z += state.vz * STEP_S
        if state.z <= self._body.conditions.ground.at(state.place.real, state.place.imag):
            self._copter.wait_on_ground(0.0)
            self._floor = self._copter.state.z

    def _stay(self) -> None:
        self._legs, self._on_arrival = iter(()), None
        if self._now.landed:
            self._flying = False
        elif not self._copter.passed:
            self._copter.brake()
        else:
            self._copter.hold(math.inf)

    def _update_body(self) -> None:
        body, state = self._body, self._copter.state
        body.yaw = state.yaw % (2.0 * math.pi)
        body.place = self._copter.place
        body.motion = state.velocity.real, state.velocity.imag, state.vz
        body.tilt_accel = state.lean.real, state.lean.imag
        if state.z > self._floor:
            self._floor = -math.inf
        body.on_ground = state.z <= self._floor
