import math
from collections.abc import Sequence

from ipoa_mission.autopilot.commands import LAST_NAV, MAY_PRECEDE_TAKEOFF, TAKEOFFS, WAYPOINTS, Frame
from ipoa_mission.link.codec import EVERYONE
from ipoa_mission.link.messages import CRITICAL, INFO, WARNING, CommandResult
from ipoa_mission.simulator.reporting import Reporting
from ipoa_mission.simulator.simulated_flight import FlightMode, MissionState

GUIDED = 4  # for take-off by command
MAV_DO_REPOSITION_CHANGE_MODE = 1
ARMED_IN_AUTO = 1  # bit of AUTO_OPTIONS
ACCEPTED, DENIED, UNSUPPORTED = CommandResult.ACCEPTED, CommandResult.DENIED, CommandResult.UNSUPPORTED
FAILED = CommandResult.FAILED


class Commander(Reporting):
    def arm(self, wish: float) -> CommandResult:
        if wish not in (0.0, 1.0):
            return UNSUPPORTED
        if wish == 0.0:
            return self._disarm()
        if self.flight.armed:
            return ACCEPTED
        refused = CommandResult(self.profile.refused_arming)
        if reason := self._arming_refusal():
            self._text(CRITICAL, f"Arm: {reason}" if self.profile.reports_prearm else f"Arming denied: {reason}\t")
            return refused
        if self.mode not in self.profile.armable_modes and not self._arms_in_auto():
            self._text(CRITICAL, f"Arm: {self.profile.autopilot.modes.name(self.mode)} mode not armable")
            return refused
        self._arm(self.profile.arm_texts[0])
        return ACCEPTED

    def _arms_in_auto(self) -> bool:
        return self.mode == self._mission_mode and bool(int(self._parameters.get("AUTO_OPTIONS", 0.0)) & ARMED_IN_AUTO)

    def _arm(self, words: str) -> None:
        self.flight.arm()
        self._armed_s = self._now
        self._text(INFO, words)
        if not self.profile.runs_on_ground and self.mode == self._mission_mode:
            self._start()
        elif self.mode == self.profile.takeoff_mode:
            self._begin_rising()

    def _disarm(self) -> CommandResult:
        if not self.flight.landed:
            if not self.profile.reports_prearm:
                self._text(CRITICAL, "Disarming denied: not landed\t")
            return CommandResult(self.profile.refused_arming)
        if self.flight.armed:
            self._stop_motors(self.profile.arm_texts[1])
        return ACCEPTED

    def _notice_disarming(self) -> None:
        """Report a landing that stopped the motors, or stop them after a delay."""
        if self._armed_s is None:
            return
        if not self.flight.armed:
            if self.profile.flight_texts and self.flight.mission_state is MissionState.COMPLETE:
                self._text(INFO, "Mission finished, landed\t")
            self._stop_motors(self.profile.arm_texts[2])
        elif self._will_stop_motors and self._parameters[self.profile.disarm_delay] <= self._now - self._armed_s:
            self._stop_motors(self.profile.arm_texts[3])

    @property
    def _will_stop_motors(self) -> bool:
        return self._is_standing() and self._parameters[self.profile.disarm_delay] > 0.0

    def _notice_height(self) -> None:
        flight = self.flight
        if self.mode == self.profile.takeoff_mode and flight.armed and not (flight.landed or flight.rising):
            self._idle_mode = self.profile.modes[FlightMode.HOLD]

    def _stop_motors(self, words: str) -> None:
        mode = self._told_mode
        self.flight.disarm()
        self._armed_s = None
        self._text(INFO, words)
        returned = mode in (self.profile.modes[FlightMode.RETURN], self.profile.modes[FlightMode.LAND])
        self._idle_mode = self._mode_before if returned and self.profile.restores_mode else mode
        self.flight.hold()
        if self.profile.runs_on_ground:
            self._report_changes()
            self.flight.rewind()
            self._has_begun = self._runs = False
            if self.mode == self._mission_mode:
                self._run()

    def _run(self) -> None:
        """Continue ArduPilot's mission, in flight or on the ground."""
        if self._flown:
            self._has_begun = self._runs = True
            self._say_begun()

    def _start(self) -> None:
        takes_off = self.flight.landed
        self.flight.start()
        if self.profile.runs_on_ground:
            self._run()
            return
        self._text(INFO, "Executing Mission\t")
        ahead = (item.altitude for item in self._flown[self.flight.current :] if item.has_position)
        if takes_off and (height := next(ahead, None)) is not None:
            item = self._flown[self.flight.current]
            above = height - self.flight.home.altitude if item.frame in (Frame.GLOBAL, Frame.GLOBAL_INT) else height
            self._text(INFO, f"Climb to {above:.1f} meters above home\t")

    def start_mission(self, params: Sequence[float]) -> CommandResult:
        """Command 300: PX4 starts at the given item and arms by itself."""
        if self.profile.mission_arms:
            if not self._flown:
                self._text(CRITICAL, "Mission start denied! No valid mission\t")
                return DENIED
            if not self.flight.armed:
                self._idle_mode = self._mission_mode
                if self._arming_refusal():
                    return DENIED
            self._go_to(whole(params[0]))
            self._idle_mode = self._mission_mode
            if self.flight.armed:
                self._start()
            else:
                self._arm("Armed by mission start\t")
            return ACCEPTED
        if params[0] or params[1]:
            return DENIED
        if self.flight.armed and (refused := self._refuses_mode(self._mission_mode)) is not None:
            return refused
        result = self._set_mode(self._mission_mode)
        if result == ACCEPTED and self.flight.armed and self.flight.mode is not FlightMode.MISSION:
            self._start()
        return result

    def _has_takeoff_first(self) -> bool:
        """DO items and delays may precede the take-off."""
        first = 0 if self.flight.mission_state is MissionState.COMPLETE else self.flight.current
        ahead = (item.command for item in self._flown[first:] if item.command < LAST_NAV)
        return next((one for one in ahead if one not in MAY_PRECEDE_TAKEOFF), None) in TAKEOFFS

    def set_mode(self, params: Sequence[float]) -> CommandResult:
        """Command 176: PX4's main and sub mode, or ArduPilot's mode number."""
        main, sub = whole(params[1]), whole(params[2])
        return self._set_mode(self.profile.autopilot.modes.ordered(main, sub))

    def _set_mode(self, custom_mode: int) -> CommandResult:
        if custom_mode not in self.profile.autopilot.modes.names:
            if self.profile.no_such_mode_text:
                self._text(WARNING, f"{self.profile.no_such_mode_text} {custom_mode}")
            return FAILED
        if custom_mode == self.mode:
            return ACCEPTED
        if self.flight.armed and (refused := self._refuses_mode(custom_mode)) is not None:
            return refused
        if custom_mode == self.profile.takeoff_mode:
            return self._rise(math.nan)
        modes = {number: mode for mode, number in self.profile.modes.items()}
        mode = modes.get(custom_mode, FlightMode.HOLD)
        if mode is FlightMode.RETURN or mode is FlightMode.LAND:
            self._mode_before = self.mode
        self._runs = False
        if not self.flight.armed or self.flight.landed or mode is FlightMode.HOLD:
            self._idle_mode = custom_mode
            self.flight.hold()
            if mode is FlightMode.MISSION and self.profile.runs_on_ground:
                self._run()  # on the ground only MISSION_START continues
            elif mode is FlightMode.MISSION and self.flight.armed:
                self._start()
        elif mode is FlightMode.MISSION:
            self._start()
        elif mode is FlightMode.RETURN:
            self.flight.return_home()
        else:
            self.flight.land()
        return ACCEPTED

    def _refuses_mode(self, custom_mode: int) -> CommandResult | None:
        name = self.profile.autopilot.modes.name(custom_mode)
        is_mission = custom_mode == self._mission_mode
        if not self.profile.refuses_modes:
            if not is_mission or self._flown:
                return None
            self._text(CRITICAL, "Switching to Mission is currently not available\t")
            return CommandResult.TEMPORARILY_REJECTED
        if custom_mode in self.profile.placed_modes and self._age < self.profile.start_up.position_s:
            self._text(WARNING, f"Mode change to {name} failed: requires position")
            return FAILED
        if not is_mission:
            return None
        lacks = self.profile.missing_takeoff_text
        if not self._flown or (lacks and self.flight.landed and not self._has_takeoff_first()):
            if self._flown:
                self._text(CRITICAL, lacks or "")
            self._text(WARNING, f"Mode change to {name} failed: init failed")
            return FAILED
        return None

    def _go_to(self, seq: int, restart: bool = False) -> bool:
        index = max(seq - self._first, 0)
        if not (0 <= seq < len(self._flown) + self._first and self._flown):
            return False
        if restart:
            self.flight.rewind()
        self.flight.set_current(index)
        if self.profile.runs_on_ground:
            self._has_begun = True
            self._runs = self._runs or restart
        self._say(self._current(), EVERYONE)
        self._told_current = index
        if self.profile.runs_on_ground and self._runs:
            self._say_begun()
        return True

    def jump_to(self, params: Sequence[float]) -> CommandResult:
        if not self.profile.knows_command_224:
            return UNSUPPORTED
        return ACCEPTED if self._go_to(whole(params[0]), params[1] == 1.0) else DENIED

    def obey(self, mode: FlightMode) -> CommandResult:
        return self._set_mode(self.profile.modes[mode])

    def pause(self, goes_on: float) -> CommandResult:
        """Command 193: ArduPilot stays in AUTO, and stops on the way to a waypoint."""
        if not self.profile.autopilot.protocol_profile.pauses_in_mission:
            return UNSUPPORTED
        if goes_on >= 0.5:
            if self.mode != self._mission_mode or self.flight.mission_state is not MissionState.PAUSED:
                return FAILED
            self._start()
        else:
            at = self._flown[self.flight.current].command if self.flight.mode is FlightMode.MISSION else None
            if at not in WAYPOINTS:
                return FAILED
            self._idle_mode = self._mission_mode
            self.flight.hold()
        return ACCEPTED

    def climb(self, height: float) -> CommandResult:
        """Command 22: ArduPilot climbs in GUIDED to a height above home, PX4 to one AMSL."""
        if self.profile.takeoff_mode is not None:
            return self._rise(height)
        if self.mode != GUIDED or not self._is_standing() or not 0.0 < height < math.inf:
            return FAILED
        self.flight.climb(height)
        return ACCEPTED

    def _rise(self, altitude: float) -> CommandResult:
        self.flight.hold()
        self._idle_mode = self.profile.takeoff_mode or 0
        self._rise_to = altitude
        if self.flight.armed:
            self._begin_rising()
        return ACCEPTED

    def _begin_rising(self) -> None:
        here = float(self.flight.local[2])
        height = self._rise_to - self.flight.home.altitude
        if not math.isfinite(height):
            usual = self._parameters["MIS_TAKEOFF_ALT"]
            self._text(INFO, f"Using default takeoff altitude: {usual:.1f} m\t")
            height = here + usual
        if height < here:
            self._text(CRITICAL, "Already higher than takeoff altitude\t")
        self.flight.climb(max(height, here))
        self._rise_to = math.nan

    def reposition(self, params: Sequence[float]) -> CommandResult:
        """Command 192 of PX4: hold, or go there; altitude AMSL in every frame."""
        if not self.profile.repositions or whole(params[1]) != MAV_DO_REPOSITION_CHANGE_MODE:
            return UNSUPPORTED
        self.obey(FlightMode.HOLD)
        if self.flight.armed and not self.flight.landed:
            self.flight.go_to(params[4], params[5], params[6], params[0])
        return ACCEPTED

    def check(self) -> CommandResult:
        """Command 401; PX4 answers by events."""
        if self.profile.reports_prearm and (reason := self._arming_refusal()):
            self._text(CRITICAL, f"PreArm: {reason}")
        return ACCEPTED

    def reboot(self, how: float) -> CommandResult:
        """Command 246: ArduPilot restarts unless armed; PX4 in simulation does not."""
        if not self.profile.reboots:
            return DENIED if how else ACCEPTED
        if how != 1.0:
            return UNSUPPORTED
        if self.flight.armed:
            return FAILED
        self._powered_s = self._now
        self._idle_mode = self.profile.first_mode
        self._has_begun = self._runs = False
        self.flight.rewind()
        return ACCEPTED


def whole(value: float) -> int:
    """Return -1 if it is no integer."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
