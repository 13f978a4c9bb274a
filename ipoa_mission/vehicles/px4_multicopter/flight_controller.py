"""PX4 in the built-in autopilot: its modes, as motions, and its protocol."""

import math
import random

from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.geometry import Enu
from ipoa_mission.link.messages import CommandResult, MissionState, MissionType
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.mock_profile import BYTEWISE, CAPABILITIES, Answer, MockProfile, StartUp, asks_every
from ipoa_mission.simulator.situation import STEP_S, FlightMode, Situation
from ipoa_mission.vehicles.px4_multicopter.dynamics import navigator
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import at_rest, begin, is_over, step
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import SIH_SENSORS, EastNorth, Motion, no_errors
from ipoa_mission.vehicles.px4_multicopter.limits import px4_limits
from ipoa_mission.vehicles.px4_multicopter.vehicle import PX4_MULTICOPTER, Px4Mode


class Px4Controller:
    """Give the vehicle its motions, one after another; `Situation` says which mode and item are current."""

    def __init__(self, situation: Situation, parameters: Parameters, chance: random.Random) -> None:
        conditions = situation.conditions
        limits = px4_limits(parameters, conditions.version)
        airframe = navigator.airframe_of(conditions.vehicle)
        self._limits = limits._replace(spool_up=max(limits.spool_up + airframe.lift_delay, 0.0))
        self._situation = situation
        self._parameters = parameters
        self._constants = navigator.simulation_constants(self._limits, airframe, SIH_SENSORS, conditions.wind, STEP_S)
        seeds = (float(chance.randrange(1, 2_000_000_000)), float(chance.randrange(1, 2_000_000_000)))
        self._state = at_rest(Enu(*situation.place), situation.time_s, situation.yaw, no_errors(*seeds), True)
        here = self._state.body.place
        self._navigator = navigator.Navigator(situation.program, conditions.ground, self._limits, here)
        self._motions: list[Motion] = []
        self._announced = False

    def enter(self) -> None:
        match self._situation.mode:
            case FlightMode.MISSION:
                self._begin_after(self._situation.current - 1)
            case FlightMode.RETURN:
                self._return()
            case FlightMode.LAND:
                ground = self._navigator.ground
                self._fly(navigator.land_mode_motions(self._estimated_place(), self._speed, ground, self._limits))
            case FlightMode.HOLD:
                self._brake()

    def follow_new_mission(self, before: tuple[Item, ...]) -> None:
        self._begin_after(self._situation.current - 1)

    def climb(self, height: float) -> None:
        """Refused before: `MOCK_PROFILE.unsupported`."""

    def step(self) -> None:
        situation = self._situation
        state = self._state
        if not situation.armed:
            self._rest()
        elif not self._motions or (situation.landed and situation.time_s - situation.armed_s < self._limits.spool_up):
            self._state = state._replace(time=situation.time_s + STEP_S)
        else:
            self._advance()
        self._show()

    def _advance(self) -> None:
        motion = self._motions[0]
        situation = self._situation
        if situation.landed:
            situation.landed = False
            rests = at_rest(self._state.body.place, situation.time_s, situation.yaw, self._state.errors, True)
            self._state = begin(rests, motion)
        self._state = step(self._state._replace(time=situation.time_s), motion, self._constants)
        reached = self._state.reached
        if len(self._motions) == 1 and not self._announced and 0.0 <= reached <= self._state.time - motion.hold_s:
            self._announced = True
            self._last_done()
        if is_over(self._state, motion) and self._motions and self._motions[0] is motion:
            self._next()

    def _next(self) -> None:
        ended = self._motions[0]
        self._motions = self._motions[1:]
        if self._motions:
            self._state = begin(self._state, self._motions[0])
        elif self._situation.mode is FlightMode.MISSION:
            self._begin_after(self._situation.current)
        else:
            self._navigator.here = ended.goal

    def _last_done(self) -> None:
        situation = self._situation
        items = situation.program.items
        if self._state.contact.on_ground:
            situation.end_on_ground()
            self._motions = []
        elif situation.mode is FlightMode.MISSION:
            # these suppress the report of the waypoint before (measured)
            suppressing = {Command.DO_JUMP, Command.DO_CHANGE_SPEED, Command.NAV_RETURN_TO_LAUNCH}
            hidden = situation.current + 1 < len(items) and items[situation.current + 1].command in suppressing
            situation.done(situation.current, announced=not hidden)

    def _rest(self) -> None:
        state = self._state
        if not state.body.on_ground or state.contact.on_ground:
            place = self._navigator.ground_under(state.body.place)
            self._state = at_rest(place, self._situation.time_s, state.yaw.angle, state.errors, True)

    def _show(self) -> None:
        situation = self._situation
        body = self._state.body
        situation.place = body.place
        situation.motion = body.speed
        situation.tilt_accel = body.thrust.east, body.thrust.north
        situation.yaw = self._state.yaw.angle % (2.0 * math.pi)
        situation.on_ground = body.on_ground

    def _begin_after(self, index: int) -> None:
        situation = self._situation
        self._navigator.program = situation.program
        item = situation.come_to(index, self._navigator.change_speed)
        if item is None:
            situation.mode = FlightMode.HOLD
            self._brake()
        elif item.command == Command.NAV_RETURN_TO_LAUNCH:
            situation.mission = MissionState.COMPLETE
            situation.mode = FlightMode.RETURN
            situation.done(situation.current)
            self._return()
        else:
            self._fly(self._motions_of(situation.current, item))

    def _motions_of(self, index: int, item: Item) -> list[Motion]:
        landed = self._situation.landed
        if item.command == Command.NAV_DELAY:
            return navigator.stay(self._navigator.here, self._limits, max(item.params[0], STEP_S))
        if item.command == Command.NAV_LAND:
            return [] if landed else self._navigator.land_at(index)
        if landed:
            self._navigator.here = self._estimated_place()
        motions = self._navigator.fly_to(index, takes_off=landed)
        if item.command == Command.NAV_LOITER_UNLIM:
            motions[-1] = motions[-1]._replace(hold_s=math.inf, beyond=motions[-1].goal)
        return motions

    def _return(self) -> None:
        self._navigator.cruise = self._limits.cruise
        here = self._estimated_place()
        goal = self._situation.goal_of_return(here, self._parameters)
        self._fly(navigator.return_motions(here, goal, self._navigator.ground, self._limits))

    @property
    def _speed(self) -> EastNorth:
        return EastNorth(*self._state.body.speed[:2])

    def _estimated_place(self) -> Enu:
        place = self._state.body.place
        return place._replace(up=place.up - self._state.errors.home_height_error)

    def _brake(self) -> None:
        here = self._state.body.place
        stop = navigator.stopping_place(here, self._speed, self._limits)
        self._navigator.here = stop
        motion = navigator.leg(self._limits, here, stop, cruise=self._navigator.cruise)
        self._fly([motion._replace(hold_s=math.inf, follows_home=False)])

    def _fly(self, motions: list[Motion]) -> None:
        """Replace the motions; on the ground only for a mission."""
        grounded = self._situation.landed and self._situation.mode is not FlightMode.MISSION
        self._announced = False
        self._motions = [] if grounded else motions
        if self._motions:
            self._state = begin(self._state, self._motions[0])


MOCK_PROFILE = MockProfile(
    autopilot=PX4_MULTICOPTER,
    controller=Px4Controller,
    retry_policy=asks_every(0.25, 5.0),
    timeout_text="Operation timeout",
    count_from_stranger=Answer.ERROR,
    count_again=Answer.ERROR,
    read_during_upload=Answer.TEXT,
    clear_during_upload=Answer.TEXT,
    obeys_cancel=True,
    stray_item=Answer.SILENCE,
    confirms_last_item_again=True,
    reached_repeats=10,
    reached_slot_s=0.1,
    clears_all=True,
    flags_kept=frozenset({MissionType.MISSION, MissionType.RALLY}),
    int_frames=True,
    reports_list_id=True,
    no_total=65535,
    no_item_text="WPM: WP CURR CMD: Not in list\t",
    restores_mode=True,
    unsupported=frozenset({
        Command.NAV_TAKEOFF, Command.DO_FENCE_ENABLE, Command.DO_PAUSE_CONTINUE, VehicleCommand.DO_SET_MISSION_CURRENT,
    }),
    start_up=StartUp(0.5, 1.0, 1.5, 1.5, *(3 * ("Resolve system health failures first",))),
    modes={
        FlightMode.HOLD: Px4Mode.AUTO_LOITER,
        FlightMode.MISSION: Px4Mode.AUTO_MISSION,
        FlightMode.RETURN: Px4Mode.AUTO_RTL,
        FlightMode.LAND: Px4Mode.AUTO_LAND,
    },
    first_mode=Px4Mode.AUTO_LOITER,
    placed_modes=frozenset(mode for mode in Px4Mode if mode.name.startswith("AUTO_")),
    armable_modes=frozenset({Px4Mode.AUTO_TAKEOFF, Px4Mode.AUTO_LOITER, Px4Mode.AUTO_MISSION}),
    mission_arms=True,
    refused_arming=CommandResult.TEMPORARILY_REJECTED,
    arm_texts=(
        "Armed by external command\t", "Disarmed by external command\t", "Disarmed by landing\t",
        "Disarmed by auto preflight disarming\t",
    ),
    disarm_delay="COM_DISARM_PRFLT",
    mode_acks=2,
    streams={
        "HEARTBEAT": 1.0, "SYS_STATUS": 1.0, "SYSTEM_TIME": 1.0, "GPS_RAW_INT": 0.2, "GLOBAL_POSITION_INT": 0.2,
        "LOCAL_POSITION_NED": 1.0, "ATTITUDE": 1.0 / 15, "BATTERY_STATUS": 2.0, "VFR_HUD": 0.25,
        "EXTENDED_SYS_STATE": 1.0, "MISSION_CURRENT": 1.0, "HOME_POSITION": 2.0,
    },
    fixed_streams=frozenset({"HEARTBEAT", "MISSION_CURRENT"}),
    no_such_stream=CommandResult.FAILED,
    no_such_message=CommandResult.DENIED,
    base_mode=29,
    capabilities=CAPABILITIES | BYTEWISE,
    protocol=(200, 100, 203),
)  # fmt: skip
