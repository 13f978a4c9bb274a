"""Commands: modes, arming, take-off, mission start."""

import math
from collections.abc import Sequence

from ipoa_mission.autopilot import commands
from ipoa_mission.autopilot.commands import WAYPOINTS, Command, Frame, VehicleCommand
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.messages import CRITICAL, INFO, WARNING, CommandResult, MissionState
from ipoa_mission.simulator.mock_vehicle import KNOWN_MESSAGES, MockVehicle
from ipoa_mission.simulator.situation import FlightMode

MAV_DO_REPOSITION_CHANGE_MODE = 1


class Commander(MockVehicle):
    _armed_s: float | None = None

    def execute(self, number: int, params: Sequence[float]) -> CommandResult:
        profile = self.profile
        match number:
            case _ if number in profile.unsupported:
                return CommandResult.UNSUPPORTED
            case Command.NAV_RETURN_TO_LAUNCH:
                return self.set_mode(profile.modes[FlightMode.RETURN])
            case Command.NAV_LAND:
                return self.set_mode(profile.modes[FlightMode.LAND])
            case Command.NAV_TAKEOFF:
                return self._climb(params[6])
            case VehicleCommand.DO_SET_MODE:  # PX4's main and sub mode, or ArduPilot's mode number
                return self.set_mode(profile.autopilot.modes.mode_of(as_integer(params[1]), as_integer(params[2])))
            case Command.DO_PAUSE_CONTINUE:
                return self._pause(params[0])
            case VehicleCommand.DO_REPOSITION:
                return self._reposition(params)
            case VehicleCommand.DO_SET_MISSION_CURRENT:
                is_there = self.set_current(as_integer(params[0]), params[1] == 1.0)
                return CommandResult.ACCEPTED if is_there else CommandResult.DENIED
            case VehicleCommand.MISSION_START:
                return self._start_mission(params)
            case Command.COMPONENT_ARM_DISARM:
                return self._arm_or_disarm(params[0])
            case VehicleCommand.RUN_PREARM_CHECKS:
                reason = self.arming_refusal()
                if profile.reports_prearm and reason:  # PX4 answers by events
                    self.send_text(CRITICAL, f"PreArm: {reason}")
                return CommandResult.ACCEPTED
            case VehicleCommand.REQUEST_MESSAGE:
                return self._find_message(message_name(as_integer(params[0])))
            case (
                Command.DO_FENCE_ENABLE
                | VehicleCommand.REQUEST_PROTOCOL_VERSION
                | VehicleCommand.GET_HOME_POSITION
                | VehicleCommand.SET_MESSAGE_INTERVAL
                | VehicleCommand.REQUEST_AUTOPILOT_CAPABILITIES
            ):
                return CommandResult.ACCEPTED
        return CommandResult.UNSUPPORTED

    def _find_message(self, name: str | None) -> CommandResult:
        known = KNOWN_MESSAGES | {"AUTOPILOT_VERSION"}
        if self.profile.protocol is not None:
            known |= {"PROTOCOL_VERSION"}
        return CommandResult.ACCEPTED if name in known else self.profile.no_such_message

    def _is_armed_on_ground(self) -> bool:
        flight = self.flight
        if not (flight.armed and flight.on_ground):
            return False
        if flight.mode is FlightMode.HOLD:
            return True
        is_at_item = self.profile.runs_on_ground and flight.current < len(self.items)
        return is_at_item and self.items[flight.current].command == Command.NAV_DELAY

    def _arm_or_disarm(self, order: float) -> CommandResult:
        if order not in (0.0, 1.0):
            return CommandResult.UNSUPPORTED
        refused = self.profile.refused_arming
        if order == 0.0 and not self.flight.on_ground:
            if not self.profile.reports_prearm:
                self.send_text(CRITICAL, "Disarming denied: not landed\t")
            return refused
        if order == 0.0 and self.flight.armed:
            self._stop_motors(self.profile.arm_texts[1])
        if order == 0.0 or self.flight.armed:
            return CommandResult.ACCEPTED
        reason = self.arming_refusal()
        if reason:
            text = f"Arm: {reason}" if self.profile.reports_prearm else f"Arming denied: {reason}\t"
            self.send_text(CRITICAL, text)
            return refused
        arms_in_auto = self.mode == self.mission_mode and int(self.parameters.get("AUTO_OPTIONS", 0.0)) & 1
        if self.mode not in self.profile.armable_modes and not arms_in_auto:
            name = self.profile.autopilot.modes.name(self.mode)
            self.send_text(CRITICAL, f"Arm: {name} mode not armable")
            return refused
        self._arm(self.profile.arm_texts[0])
        return CommandResult.ACCEPTED

    def _arm(self, words: str) -> None:
        self.flight.arm()
        self._armed_s = self.now
        self.send_text(INFO, words)
        if not self.profile.runs_on_ground and self.mode == self.mission_mode:
            self._start()

    def notice_disarming(self) -> None:
        """Report a landing that stopped the motors, or stop them after a delay."""
        if self._armed_s is None:
            return
        if not self.flight.armed:
            if not self.profile.runs_on_ground and self.flight.mission is MissionState.COMPLETE:
                self.send_text(INFO, "Mission finished, landed\t")
            self._stop_motors(self.profile.arm_texts[2])
        elif self.will_stop_motors and self.parameters[self.profile.disarm_delay] <= self.now - self._armed_s:
            self._stop_motors(self.profile.arm_texts[3])

    @property
    def will_stop_motors(self) -> bool:
        return self._is_armed_on_ground() and self.parameters[self.profile.disarm_delay] > 0.0

    def _stop_motors(self, words: str) -> None:
        mode = self.reported_mode
        self.flight.disarm()
        self._armed_s = None
        self.send_text(INFO, words)
        returned = mode in (self.profile.modes[FlightMode.RETURN], self.profile.modes[FlightMode.LAND])
        self.idle_mode = self.mode_before if returned and self.profile.restores_mode else mode
        self.flight.hold()
        if self.profile.runs_on_ground:
            self.report_changes()
            self.flight.rewind()
            self.mission_begun = self.mission_runs = False
            if self.mode == self.mission_mode:
                self._run()

    def _run(self) -> None:
        if self.items:
            self.mission_begun = self.mission_runs = True
            self.report_begun()

    def _start(self) -> None:
        takes_off = self.flight.on_ground
        self.flight.start()
        if self.profile.runs_on_ground:
            self._run()
            return
        self.send_text(INFO, "Executing Mission\t")
        placed = [item for item in self.items[self.flight.current :] if item.has_position]
        if takes_off and placed:
            height = placed[0].altitude
            if self.items[self.flight.current].frame in (Frame.GLOBAL, Frame.GLOBAL_INT):
                height -= self.flight.home.altitude
            self.send_text(INFO, f"Climb to {height:.1f} meters above home\t")

    def _start_mission(self, params: Sequence[float]) -> CommandResult:
        """MISSION_START (300): PX4 starts at the given item and arms by itself."""
        if self.profile.mission_arms:
            if not self.items:
                self.send_text(CRITICAL, "Mission start denied! No valid mission\t")
                return CommandResult.DENIED
            if not self.flight.armed:
                self.idle_mode = self.mission_mode
                if self.arming_refusal():
                    return CommandResult.DENIED
            self.set_current(as_integer(params[0]))
            self.idle_mode = self.mission_mode
            if self.flight.armed:
                self._start()
            else:
                self._arm("Armed by mission start\t")
            return CommandResult.ACCEPTED
        if params[0] or params[1]:
            return CommandResult.DENIED
        refused = self._refuses_mode(self.mission_mode) if self.flight.armed else None
        if refused is not None:
            return refused
        result = self.set_mode(self.mission_mode)
        if result == CommandResult.ACCEPTED and self.flight.armed and self.flight.mode is not FlightMode.MISSION:
            self._start()
        return result

    def _has_takeoff_first(self) -> bool:
        first = 0 if self.flight.mission is MissionState.COMPLETE else self.flight.current
        may_precede = self.profile.autopilot.guidance.may_precede_takeoff
        moving = (item.command for item in self.items[first:] if not may_precede(item.command))
        return next(moving, None) in commands.TAKEOFFS

    def set_mode(self, custom_mode: int) -> CommandResult:
        if custom_mode not in self.profile.autopilot.modes.names:
            if self.profile.refuses_modes:
                self.send_text(WARNING, f"No such mode {custom_mode}")
            return CommandResult.FAILED
        if custom_mode == self.mode:
            return CommandResult.ACCEPTED
        refused = self._refuses_mode(custom_mode) if self.flight.armed else None
        if refused is not None:
            return refused
        modes = {number: mode for mode, number in self.profile.modes.items()}
        mode = modes.get(custom_mode, FlightMode.HOLD)
        if mode is FlightMode.RETURN or mode is FlightMode.LAND:
            self.mode_before = self.mode
        self.mission_runs = False
        if not self.flight.armed or self.flight.on_ground or mode is FlightMode.HOLD:
            self.idle_mode = custom_mode
            self.flight.hold()
            if mode is FlightMode.MISSION and self.profile.runs_on_ground:
                self._run()  # on the ground only MISSION_START continues
            elif mode is FlightMode.MISSION and self.flight.armed:
                self._start()
        elif mode is FlightMode.MISSION:
            self._start()
        else:
            self.flight.enter(mode)
        return CommandResult.ACCEPTED

    def _refuses_mode(self, custom_mode: int) -> CommandResult | None:
        name = self.profile.autopilot.modes.name(custom_mode)
        is_mission = custom_mode == self.mission_mode
        if not self.profile.refuses_modes:
            if not is_mission or self.items:
                return None
            self.send_text(CRITICAL, "Switching to Mission is currently not available\t")
            return CommandResult.TEMPORARILY_REJECTED
        if custom_mode in self.profile.placed_modes and self.age < self.profile.start_up.position_s:
            self.send_text(WARNING, f"Mode change to {name} failed: requires position")
            return CommandResult.FAILED
        if not is_mission:
            return None
        lacks_takeoff = self.flight.on_ground and not self._has_takeoff_first()
        if self.items and not lacks_takeoff:
            return None
        if self.items:
            self.send_text(CRITICAL, "Auto: Missing Takeoff Cmd")
        self.send_text(WARNING, f"Mode change to {name} failed: init failed")
        return CommandResult.FAILED

    def set_current(self, seq: int, restart: bool = False) -> bool:
        index = max(seq - self.first_item, 0)
        if not (0 <= seq < len(self.items) + self.first_item and self.items):
            return False
        if restart:
            self.flight.rewind()
        self.flight.set_current(index)
        if self.profile.runs_on_ground:
            self.mission_begun = True
            self.mission_runs = self.mission_runs or restart
        self.send(self.current())
        self._reported_current = index
        if self.profile.runs_on_ground and self.mission_runs:
            self.report_begun()
        return True

    def _pause(self, resume: float) -> CommandResult:
        """Command 193: ArduPilot stays in AUTO."""
        if resume >= 0.5:
            if self.mode != self.mission_mode or self.flight.mission is not MissionState.PAUSED:
                return CommandResult.FAILED
            self._start()
        else:
            command = self.items[self.flight.current].command if self.flight.mode is FlightMode.MISSION else None
            if command not in WAYPOINTS:
                return CommandResult.FAILED
            self.idle_mode = self.mission_mode
            self.flight.hold()
        return CommandResult.ACCEPTED

    def _climb(self, height: float) -> CommandResult:
        is_guided = self.mode == self.profile.autopilot.modes.arming
        if not is_guided or not self._is_armed_on_ground() or not 0.0 < height < math.inf:
            return CommandResult.FAILED
        self.flight.climb(height)
        return CommandResult.ACCEPTED

    def _reposition(self, params: Sequence[float]) -> CommandResult:
        """Command 192 of PX4: hold; the place has no effect."""
        if as_integer(params[1]) != MAV_DO_REPOSITION_CHANGE_MODE:
            return CommandResult.UNSUPPORTED
        return self.set_mode(self.profile.modes[FlightMode.HOLD])


def as_integer(value: float) -> int:
    """Return -1 if it is no integer."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
