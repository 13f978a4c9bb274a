"""ArduCopter in the built-in autopilot: its modes, as legs, and its protocol."""

import math
import random
from collections.abc import Callable, Iterator

from ipoa_mission.autopilot.commands import LANDINGS, TAKEOFFS, Command, VehicleCommand
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.link.messages import CommandResult, MissionType, Result
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.mock_profile import CAPABILITIES, FTP, Answer, MockProfile, StartUp, asks_every
from ipoa_mission.simulator.situation import FlightMode, Situation
from ipoa_mission.vehicles.arducopter.dynamics import procedures
from ipoa_mission.vehicles.arducopter.dynamics.copter import Copter, airframe_of
from ipoa_mission.vehicles.arducopter.dynamics.motion import Kind
from ipoa_mission.vehicles.arducopter.limits import LANDED_S, copter_limits
from ipoa_mission.vehicles.arducopter.vehicle import ARDUCOPTER


class ArduCopterController:
    """Give the copter its next leg: of the procedure, or by `_on_arrival`."""

    def __init__(self, situation: Situation, parameters: Parameters, chance: random.Random) -> None:
        """Ignore `chance`: SITL flights repeat to a tenth of a second."""
        self._situation = situation
        self._parameters = parameters
        conditions = situation.conditions
        limits = copter_limits(parameters, conditions.version)
        airframe = airframe_of(conditions.vehicle).at_altitude(situation.program.frame.home.altitude)
        self._copter = Copter(limits, conditions.wind, airframe, ground=conditions.ground)
        self._copter.start_at(situation.place)
        self._landing_s = LANDED_S + airframe.landing_delay
        self._legs: Iterator[None] = iter(())
        self._on_arrival: Callable[[], None] | None = None
        self._flying = False
        self._touched_s: float | None = None
        self._floor = self._copter.state.z
        self._copter.face(situation.yaw)
        self._lift_s = limits.lift_off_s + airframe.lift_delay

    def enter(self) -> None:
        match self._situation.mode:
            case FlightMode.MISSION:
                self._begin_after(self._situation.current - 1)
            case FlightMode.RETURN:
                self._return()
            case FlightMode.LAND:
                self._fly(procedures.land(self._copter, None), self._touch)
            case FlightMode.HOLD:
                self._stay()

    def follow_new_mission(self, before: tuple[Item, ...]) -> None:
        """Continue in the new mission; restart at the waypoint if the next items differ."""
        current = self._situation.current
        after = self._situation.program.items
        ahead = slice(current, current + 3)
        if current >= len(after) or before[ahead] == after[ahead] or self._on_arrival != self._finish_item:
            return
        if before[current].command in procedures.FLOWN_AS_WAYPOINTS and self._copter.this.kind != Kind.HOLD:
            self._begin_after(current - 1)

    def _return(self) -> None:
        goal = self._situation.goal_of_return(self._copter.place, self._parameters)
        self._fly(procedures.return_home(self._copter, goal), self._touch)

    def climb(self, height: float) -> None:
        self._situation.landed = False
        self._fly(procedures.take_off(self._copter, height), self._stay)

    def step(self) -> None:
        lifting = self._situation.armed and self._situation.time_s - self._situation.armed_s >= self._lift_s
        if self._touched_s is not None:
            self._stand(self._situation.time_s - self._touched_s)
        elif self._flying and lifting and self._copter.step():
            self._go_on()
        self._update_situation()

    def _begin_after(self, index: int) -> None:
        item = self._situation.come_to(
            index, lambda item: self._copter.change_speed(int(item.params[0]), item.params[1])
        )
        if item is None:
            self._stay()
        else:
            self._start(self._situation.current, item)

    def _finish_item(self) -> None:
        self._situation.done(self._situation.current)
        self._begin_after(self._situation.current)

    def _start(self, index: int, item: Item) -> None:
        if item.command == Command.NAV_RETURN_TO_LAUNCH:
            self._return()
            return
        legs = procedures.legs_of(self._copter, self._situation.program, index) or iter(())
        if item.command in TAKEOFFS:
            self._situation.landed = False
        on_arrival = self._touch if item.command in LANDINGS else self._finish_item
        self._fly(legs, on_arrival, on_ground=item.command == Command.NAV_DELAY)

    def _go_on(self) -> None:
        if next(self._legs, self) is self and self._on_arrival is not None:
            on_arrival = self._on_arrival
            self._on_arrival = None
            on_arrival()

    def _fly(self, legs: Iterator[None], on_arrival: Callable[[], None], on_ground: bool = False) -> None:
        self._flying = on_ground or not self._situation.landed
        if self._flying:
            self._legs = legs
            self._on_arrival = on_arrival
            self._go_on()

    def _touch(self) -> None:
        if self._copter.this.kind == Kind.DESCENT:
            self._touched_s = self._situation.time_s
            self._copter.wait_on_ground(0.0)
            self._floor = self._copter.state.z

    def _stand(self, seconds: float) -> None:
        self._situation.landed = seconds >= self._landing_s
        if seconds >= self._landing_s + self._copter.limits.spool_up:
            is_mission = self._situation.mode is FlightMode.MISSION
            lands = is_mission and self._situation.program.items[self._situation.current].command == Command.NAV_LAND
            self._situation.end_on_ground(announced=not lands)
            self._touched_s = None
            self._flying = False

    def _stay(self) -> None:
        self._legs = iter(())
        self._on_arrival = None
        if self._situation.landed:
            self._flying = False
        elif not self._copter.passed:
            self._copter.brake()
        else:
            self._copter.hold(math.inf)

    def _update_situation(self) -> None:
        situation = self._situation
        state = self._copter.state
        situation.yaw = state.yaw % (2.0 * math.pi)
        situation.place = self._copter.place
        situation.motion = state.velocity.real, state.velocity.imag, state.vz
        situation.tilt_accel = state.tilt.real, state.tilt.imag
        if state.z > self._floor:
            self._floor = -math.inf
        situation.on_ground = state.z <= self._floor


MOCK_PROFILE = MockProfile(
    autopilot=ARDUCOPTER,
    controller=ArduCopterController,
    requests_legacy=True,
    retry_policy=asks_every(1.0, 8.0),
    timeout_result=Result.OPERATION_CANCELLED,
    timeout_text="Mission upload timeout",
    truncating=frozenset({MissionType.MISSION, MissionType.RALLY}),
    separate_lists=True,
    reads_item_by_item=True,
    count_from_stranger=Answer.DENIED,
    count_again=Answer.OBEY,
    read_during_upload=Answer.DENIED,
    clear_during_upload=Answer.OBEY,
    stray_item=Answer.ERROR,
    reached_slot_s=0.02,
    stored_text={MissionType.MISSION: "Flight plan received"},
    flags_kept=frozenset({MissionType.MISSION}),
    no_total=0,
    runs_on_ground=True,
    refuses_modes=True,
    unsupported=frozenset({VehicleCommand.DO_REPOSITION, VehicleCommand.REQUEST_PROTOCOL_VERSION}),
    start_up=StartUp(
        3.0, 20.0, 23.5, 41.4, "Gyros inconsistent", "Need Position Estimate", no_mission="Mode requires mission"
    ),
    modes={FlightMode.HOLD: 5, FlightMode.MISSION: 3, FlightMode.RETURN: 6, FlightMode.LAND: 9},
    first_mode=0,
    placed_modes=frozenset({3, 4, 5, 6, 7, 16, 17, 21, 27}),
    armable_modes=frozenset({0, 1, 2, 4, 5, 16}),
    reports_prearm=True,
    prearm_every_s=1.0,
    refused_arming=CommandResult.FAILED,
    arm_texts=("Arming motors", "Disarming motors", "Disarming motors", "Disarming motors"),
    disarm_delay="DISARM_DELAY",
    acks_first=True,
    heartbeat_on_change=True,
    streams={"HEARTBEAT": 1.0, "TIMESYNC": 10.0},
    no_such_stream=CommandResult.DENIED,
    no_such_message=CommandResult.FAILED,
    base_mode=81,
    capabilities=CAPABILITIES | FTP,
    stream_groups={
        2: frozenset({"SYS_STATUS", "MISSION_CURRENT", "GPS_RAW_INT"}),
        6: frozenset({"GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"}),
        10: frozenset({"ATTITUDE"}),
        11: frozenset({"VFR_HUD"}),
        12: frozenset({"SYSTEM_TIME", "BATTERY_STATUS"}),
    },
)
