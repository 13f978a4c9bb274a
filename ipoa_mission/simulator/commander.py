"""Commands: modes, arming, take-off, mission start."""

import math
from collections.abc import Sequence

from ipoa_mission.autopilot.commands import (
    LAST_NAV,
    MAY_PRECEDE_TAKEOFF,
    TAKEOFFS,
    WAYPOINTS,
    Command,
    Frame,
    VehicleCommand,
)
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.messages import CRITICAL, INFO, WARNING, CommandResult
from ipoa_mission.simulator.mock_vehicle import MockVehicle
from ipoa_mission.simulator.reporting import Reporter
from ipoa_mission.simulator.situation import FlightMode, MissionState
from ipoa_mission.simulator.streams import KNOWN_MESSAGES

GUIDED = 4  # ArduCopter's mode of take-off by command
MAV_DO_REPOSITION_CHANGE_MODE = 1


class Commander:
    def __init__(self, vehicle: MockVehicle, reporter: Reporter) -> None:
        self._vehicle, self._reporter = vehicle, reporter
        self._profile, self._flight, self._send_text = vehicle.profile, vehicle.flight, vehicle.send_text
        self._mode_before = vehicle.profile.first_mode  # PX4: before a return or landing
        self._armed_s: float | None = None
        self._takeoff_altitude = math.nan  # PX4: AMSL [m]; NaN: from its parameter

    def execute(self, number: int, params: Sequence[float]) -> CommandResult:
        profile, accepted, unsupported = self._profile, CommandResult.ACCEPTED, CommandResult.UNSUPPORTED
        match number:
            case Command.NAV_RETURN_TO_LAUNCH:
                return self._obey(FlightMode.RETURN)
            case Command.NAV_LAND:
                return self._obey(FlightMode.LAND)
            case Command.NAV_TAKEOFF:
                return self._climb(params[6])
            case VehicleCommand.DO_SET_MODE:  # PX4's main and sub mode, or ArduPilot's mode number
                return self.set_mode(profile.autopilot.modes.mode_of(whole(params[1]), whole(params[2])))
            case Command.DO_PAUSE_CONTINUE:
                return self._pause(params[0])
            case VehicleCommand.DO_REPOSITION:
                return self._reposition(params)
            case Command.DO_FENCE_ENABLE:
                return accepted if profile.switches_fence else unsupported
            case VehicleCommand.DO_SET_MISSION_CURRENT if profile.knows_command_224:
                return accepted if self.set_current(whole(params[0]), params[1] == 1.0) else CommandResult.DENIED
            case VehicleCommand.PREFLIGHT_REBOOT_SHUTDOWN:
                return self._reboot(params[0])
            case VehicleCommand.MISSION_START:
                return self._start_mission(params)
            case Command.COMPONENT_ARM_DISARM:
                return self._arm_or_disarm(params[0])
            case VehicleCommand.RUN_PREARM_CHECKS:
                if profile.reports_prearm and (reason := self._vehicle.arming_refusal()):
                    self._send_text(CRITICAL, f"PreArm: {reason}")
                return accepted  # PX4 answers by events
            case VehicleCommand.REQUEST_PROTOCOL_VERSION:
                return unsupported if profile.protocol is None else accepted
            case VehicleCommand.REQUEST_MESSAGE:
                return self._find_message(message_name(whole(params[0])))
            case (
                VehicleCommand.GET_HOME_POSITION
                | VehicleCommand.GET_MESSAGE_INTERVAL
                | VehicleCommand.SET_MESSAGE_INTERVAL
                | VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES
            ):
                return accepted
        return unsupported

    def _find_message(self, name: str | None) -> CommandResult:
        is_known = name == "AUTOPILOT_VERSION" or name in KNOWN_MESSAGES
        is_known = is_known or (name == "PROTOCOL_VERSION" and self._profile.protocol is not None)
        return CommandResult.ACCEPTED if is_known else CommandResult(self._profile.no_such_message)

    def _is_armed_on_ground(self) -> bool:
        flight, items = self._flight, self._vehicle.items
        if not (flight.armed and flight.landed):
            return False
        if flight.mode is FlightMode.HOLD:
            return True
        is_at_item = self._profile.runs_on_ground and flight.current < len(items)
        return is_at_item and items[flight.current].command == Command.NAV_DELAY

    def _arm_or_disarm(self, order: float) -> CommandResult:
        if order not in (0.0, 1.0):
            return CommandResult.UNSUPPORTED
        if order == 0.0:
            return self._disarm()
        if self._flight.armed:
            return CommandResult.ACCEPTED
        refused = CommandResult(self._profile.refused_arming)
        if reason := self._vehicle.arming_refusal():
            text = f"Arm: {reason}" if self._profile.reports_prearm else f"Arming denied: {reason}\t"
            self._send_text(CRITICAL, text)
            return refused
        options = int(self._vehicle.parameters.get("AUTO_OPTIONS", 0.0))
        arms_in_auto = self._vehicle.mode == self._vehicle.mission_mode and options & 1
        if self._vehicle.mode not in self._profile.armable_modes and not arms_in_auto:
            name = self._profile.autopilot.modes.name(self._vehicle.mode)
            self._send_text(CRITICAL, f"Arm: {name} mode not armable")
            return refused
        self._arm(self._profile.arm_texts[0])
        return CommandResult.ACCEPTED

    def _arm(self, words: str) -> None:
        self._flight.arm()
        self._armed_s = self._vehicle.now
        self._send_text(INFO, words)
        if not self._profile.runs_on_ground and self._vehicle.mode == self._vehicle.mission_mode:
            self._start()
        elif self._vehicle.mode == self._profile.takeoff_mode:
            self._begin_rising()

    def _disarm(self) -> CommandResult:
        if not self._flight.landed:
            if not self._profile.reports_prearm:
                self._send_text(CRITICAL, "Disarming denied: not landed\t")
            return CommandResult(self._profile.refused_arming)
        if self._flight.armed:
            self._stop_motors(self._profile.arm_texts[1])
        return CommandResult.ACCEPTED

    def notice_disarming(self) -> None:
        """Report a landing that stopped the motors, or stop them after a delay."""
        if self._armed_s is None:
            return
        if not self._flight.armed:
            if self._profile.flight_texts and self._flight.mission_state is MissionState.COMPLETE:
                self._send_text(INFO, "Mission finished, landed\t")
            self._stop_motors(self._profile.arm_texts[2])
        elif (
            self.will_stop_motors
            and self._vehicle.parameters[self._profile.disarm_delay] <= self._vehicle.now - self._armed_s
        ):
            self._stop_motors(self._profile.arm_texts[3])

    @property
    def will_stop_motors(self) -> bool:
        return self._is_armed_on_ground() and self._vehicle.parameters[self._profile.disarm_delay] > 0.0

    def notice_height(self) -> None:
        flight = self._flight
        if self._vehicle.mode == self._profile.takeoff_mode and flight.armed and not (flight.landed or flight.rising):
            self._vehicle.idle_mode = self._profile.modes[FlightMode.HOLD]

    def _stop_motors(self, words: str) -> None:
        mode = self._reporter.reported_mode
        self._flight.disarm()
        self._armed_s = None
        self._send_text(INFO, words)
        returned = mode in (self._profile.modes[FlightMode.RETURN], self._profile.modes[FlightMode.LAND])
        self._vehicle.idle_mode = self._mode_before if returned and self._profile.restores_mode else mode
        self._flight.hold()
        if self._profile.runs_on_ground:
            self._reporter.report_changes()
            self._flight.rewind()
            self._vehicle.mission_begun = self._vehicle.mission_runs = False
            if self._vehicle.mode == self._vehicle.mission_mode:
                self._run()

    def _run(self) -> None:
        """Continue ArduPilot's mission, in flight or on the ground."""
        if self._vehicle.items:
            self._vehicle.mission_begun = self._vehicle.mission_runs = True
            self._reporter.report_begun()

    def _start(self) -> None:
        takes_off = self._flight.landed
        self._flight.start()
        if self._profile.runs_on_ground:
            self._run()
            return
        self._send_text(INFO, "Executing Mission\t")
        ahead = (item.altitude for item in self._vehicle.items[self._flight.current :] if item.has_position)
        if takes_off and (height := next(ahead, None)) is not None:
            item = self._vehicle.items[self._flight.current]
            above = height - self._flight.home.altitude if item.frame in (Frame.GLOBAL, Frame.GLOBAL_INT) else height
            self._send_text(INFO, f"Climb to {above:.1f} meters above home\t")

    def _start_mission(self, params: Sequence[float]) -> CommandResult:
        """Command 300: PX4 starts at the given item and arms by itself."""
        if self._profile.mission_arms:
            if not self._vehicle.items:
                self._send_text(CRITICAL, "Mission start denied! No valid mission\t")
                return CommandResult.DENIED
            if not self._flight.armed:
                self._vehicle.idle_mode = self._vehicle.mission_mode
                if self._vehicle.arming_refusal():
                    return CommandResult.DENIED
            self.set_current(whole(params[0]))
            self._vehicle.idle_mode = self._vehicle.mission_mode
            if self._flight.armed:
                self._start()
            else:
                self._arm("Armed by mission start\t")
            return CommandResult.ACCEPTED
        if params[0] or params[1]:
            return CommandResult.DENIED
        if self._flight.armed and (refused := self._refuses_mode(self._vehicle.mission_mode)) is not None:
            return refused
        result = self.set_mode(self._vehicle.mission_mode)
        if result == CommandResult.ACCEPTED and self._flight.armed and self._flight.mode is not FlightMode.MISSION:
            self._start()
        return result

    def _has_takeoff_first(self) -> bool:
        """DO items and delays may precede the take-off."""
        first = 0 if self._flight.mission_state is MissionState.COMPLETE else self._flight.current
        ahead = (item.command for item in self._vehicle.items[first:] if item.command < LAST_NAV)
        return next((command for command in ahead if command not in MAY_PRECEDE_TAKEOFF), None) in TAKEOFFS

    def set_mode(self, custom_mode: int) -> CommandResult:
        if custom_mode not in self._profile.autopilot.modes.names:
            if self._profile.no_such_mode_text:
                self._send_text(WARNING, f"{self._profile.no_such_mode_text} {custom_mode}")
            return CommandResult.FAILED
        if custom_mode == self._vehicle.mode:
            return CommandResult.ACCEPTED
        if self._flight.armed and (refused := self._refuses_mode(custom_mode)) is not None:
            return refused
        if custom_mode == self._profile.takeoff_mode:
            return self._rise(math.nan)
        modes = {number: mode for mode, number in self._profile.modes.items()}
        mode = modes.get(custom_mode, FlightMode.HOLD)
        if mode is FlightMode.RETURN or mode is FlightMode.LAND:
            self._mode_before = self._vehicle.mode
        self._vehicle.mission_runs = False
        if not self._flight.armed or self._flight.landed or mode is FlightMode.HOLD:
            self._vehicle.idle_mode = custom_mode
            self._flight.hold()
            if mode is FlightMode.MISSION and self._profile.runs_on_ground:
                self._run()  # on the ground only MISSION_START continues
            elif mode is FlightMode.MISSION and self._flight.armed:
                self._start()
        elif mode is FlightMode.MISSION:
            self._start()
        else:
            self._flight.enter(mode)
        return CommandResult.ACCEPTED

    def _refuses_mode(self, custom_mode: int) -> CommandResult | None:
        name = self._profile.autopilot.modes.name(custom_mode)
        is_mission = custom_mode == self._vehicle.mission_mode
        if not self._profile.refuses_modes:
            if not is_mission or self._vehicle.items:
                return None
            self._send_text(CRITICAL, "Switching to Mission is currently not available\t")
            return CommandResult.TEMPORARILY_REJECTED
        if custom_mode in self._profile.placed_modes and self._vehicle.age < self._profile.start_up.position_s:
            self._send_text(WARNING, f"Mode change to {name} failed: requires position")
            return CommandResult.FAILED
        if not is_mission:
            return None
        text = self._profile.missing_takeoff_text
        if not self._vehicle.items or (text and self._flight.landed and not self._has_takeoff_first()):
            if self._vehicle.items:
                self._send_text(CRITICAL, text or "")
            self._send_text(WARNING, f"Mode change to {name} failed: init failed")
            return CommandResult.FAILED
        return None

    def set_current(self, seq: int, restart: bool = False) -> bool:
        index = max(seq - self._vehicle.first_item, 0)
        if not (0 <= seq < len(self._vehicle.items) + self._vehicle.first_item and self._vehicle.items):
            return False
        if restart:
            self._flight.rewind()
        self._flight.set_current(index)
        if self._profile.runs_on_ground:
            self._vehicle.mission_begun = True
            self._vehicle.mission_runs = self._vehicle.mission_runs or restart
        self._reporter.report_current(index)
        if self._profile.runs_on_ground and self._vehicle.mission_runs:
            self._reporter.report_begun()
        return True

    def _obey(self, mode: FlightMode) -> CommandResult:
        return self.set_mode(self._profile.modes[mode])

    def _pause(self, resume: float) -> CommandResult:
        """Command 193: ArduPilot stays in AUTO, and stops on the way to a waypoint."""
        if not self._profile.autopilot.protocol_profile.pauses_in_mission:
            return CommandResult.UNSUPPORTED
        if resume >= 0.5:
            if (
                self._vehicle.mode != self._vehicle.mission_mode
                or self._flight.mission_state is not MissionState.PAUSED
            ):
                return CommandResult.FAILED
            self._start()
        else:
            at = self._vehicle.items[self._flight.current].command if self._flight.mode is FlightMode.MISSION else None
            if at not in WAYPOINTS:
                return CommandResult.FAILED
            self._vehicle.idle_mode = self._vehicle.mission_mode
            self._flight.hold()
        return CommandResult.ACCEPTED

    def _climb(self, height: float) -> CommandResult:
        """Command 22: ArduPilot climbs in GUIDED to a height above home, PX4 to one AMSL."""
        if self._profile.takeoff_mode is not None:
            return self._rise(height)
        if self._vehicle.mode != GUIDED or not self._is_armed_on_ground() or not 0.0 < height < math.inf:
            return CommandResult.FAILED
        self._flight.climb(height)
        return CommandResult.ACCEPTED

    def _rise(self, altitude: float) -> CommandResult:
        self._flight.hold()
        self._vehicle.idle_mode = self._profile.takeoff_mode or 0
        self._takeoff_altitude = altitude
        if self._flight.armed:
            self._begin_rising()
        return CommandResult.ACCEPTED

    def _begin_rising(self) -> None:
        here = float(self._flight.local[2])
        height = self._takeoff_altitude - self._flight.home.altitude
        if not math.isfinite(height):
            default = self._vehicle.parameters["MIS_TAKEOFF_ALT"]
            self._send_text(INFO, f"Using default takeoff altitude: {default:.1f} m\t")
            height = here + default
        if height < here:
            self._send_text(CRITICAL, "Already higher than takeoff altitude\t")
        self._flight.climb(max(height, here))
        self._takeoff_altitude = math.nan

    def _reposition(self, params: Sequence[float]) -> CommandResult:
        """Command 192 of PX4: hold, or go there; altitude AMSL in every frame."""
        if not self._profile.repositions or whole(params[1]) != MAV_DO_REPOSITION_CHANGE_MODE:
            return CommandResult.UNSUPPORTED
        self._obey(FlightMode.HOLD)
        if self._flight.armed and not self._flight.landed:
            self._flight.go_to(params[4], params[5], params[6], params[0])
        return CommandResult.ACCEPTED

    def _reboot(self, order: float) -> CommandResult:
        """Command 246: ArduPilot restarts unless armed; PX4 in simulation does not."""
        if not self._profile.reboots:
            return CommandResult.DENIED if order else CommandResult.ACCEPTED
        if order != 1.0:
            return CommandResult.UNSUPPORTED
        if self._flight.armed:
            return CommandResult.FAILED
        self._vehicle.powered_s = self._vehicle.now
        self._vehicle.idle_mode = self._profile.first_mode
        self._vehicle.mission_begun = self._vehicle.mission_runs = False
        self._flight.rewind()
        return CommandResult.ACCEPTED


def whole(value: float) -> int:
    """Return -1 if it is no integer."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
