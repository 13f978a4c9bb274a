"""Streams, and messages at events."""

import math
from collections.abc import Mapping

from ipoa_mission.autopilot.commands import LAST_NAV, WAYPOINTS, Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.vehicle_kind import QUADROTOR
from ipoa_mission.link import messages as m
from ipoa_mission.link import telemetry
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.messages import INFO, Message, MissionType
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator import streams
from ipoa_mission.simulator.judgement import Infeasible
from ipoa_mission.simulator.mission_service import MissionService
from ipoa_mission.simulator.mock_profile import MockProfile
from ipoa_mission.simulator.simulated_flight import FlightMode, MissionState, SimulatedFlight

#: In ArduCopter's text at the start of an item.
_NAMES: Mapping[int, str] = {
    Command.NAV_WAYPOINT: "WP",
    Command.NAV_SPLINE_WAYPOINT: "SplineWP",
    Command.NAV_ARC_WAYPOINT: "ArcWP",
    Command.NAV_RETURN_TO_LAUNCH: "RTL",
    Command.NAV_LOITER_UNLIM: "LoitUnlim",
    Command.NAV_LOITER_TIME: "LoitTime",
    Command.NAV_LOITER_TURNS: "LoitTurns",
    Command.NAV_LOITER_TO_ALT: "LoitAltitude",
    Command.NAV_TAKEOFF: "Takeoff",
    Command.NAV_LAND: "Land",
    Command.NAV_DELAY: "Delay",
    Command.NAV_PAYLOAD_PLACE: "PayloadPlace",
    Command.CONDITION_DELAY: "CondDelay",
    Command.CONDITION_DISTANCE: "CondDist",
    Command.CONDITION_YAW: "CondYaw",
    Command.DO_CHANGE_SPEED: "ChangeSpeed",
    Command.DO_SET_HOME: "SetHome",
    Command.DO_JUMP: "Jump",
    Command.JUMP_TAG: "Tag",
}
REPORTED_WHEN_REACHED = WAYPOINTS | {Command.NAV_LOITER_TIME, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TO_ALT}


def begun(seq: int, command: int) -> str:
    return f"Mission: {seq} {_NAMES.get(command, '?')}"


STATE_UNINIT, STATE_BOOT, STATE_STANDBY, STATE_ACTIVE = 0, 1, 3, 4  # MAV_STATE
MISSION_ACTIVE, MISSION_SUSPENDED = 1, 2  # MISSION_CURRENT.mission_mode
TEXT_BYTES = 50  # of a STATUSTEXT


class Reporting:
    def __init__(
        self,
        profile: MockProfile,
        flight: SimulatedFlight,
        transfers: MissionService,
        parameters: Parameters,
        powered_s: float,
    ) -> None:
        self.profile = profile
        self.flight = flight
        self.transfers = transfers
        self._parameters = parameters
        self._outbox: list[tuple[Message, Target]] = []
        self._now = 0.0
        self._powered_s = powered_s
        self._told_reached = 0
        self._last_reached = m.Reached(0), 0
        self._told_mode = profile.first_mode
        self._told_current = -1
        self._unflyable: Infeasible | None = None
        self._flown: tuple[Item, ...] = ()  # without home, and only a complete mission
        self._idle_mode = profile.first_mode  # without a command
        self._mode_before = profile.first_mode  # PX4: before a return or landing
        self._armed_s: float | None = None
        self._checked = -math.inf, False  # time and result of the last pre-arm check
        self._rise_to = math.nan  # PX4: AMSL; NaN: from its parameter
        self._has_begun = self._runs = False  # ArduPilot: has a current item, and advances

    @property
    def _age(self) -> float:
        return self._now - self._powered_s

    @property
    def mode(self) -> int:
        return self._idle_mode if self.flight.mode is FlightMode.HOLD else self.profile.modes[self.flight.mode]

    @property
    def _mission_mode(self) -> int:
        return self.profile.modes[FlightMode.MISSION]

    @property
    def _first(self) -> int:
        return self.profile.autopilot.counts_home

    def _arming_refusal(self) -> str:
        start_up = self.profile.start_up
        if self._age < start_up.steady_s:
            return start_up.unsteady
        if self._age < start_up.position_s and self.mode in self.profile.placed_modes:
            return start_up.unplaced
        if self.mode == self._mission_mode and not self._flown:
            return start_up.no_mission
        if not self.profile.reports_prearm and self.mode not in self.profile.armable_modes:
            return start_up.unsteady
        return ""

    def _passed_checks(self) -> bool:
        """The last check may precede the last change of mode."""
        checked_s, _ = self._checked
        if self._now - checked_s >= self.profile.prearm_every_s:
            self._checked = self._now, not self._arming_refusal()
        return self._checked[1]

    def _is_standing(self) -> bool:
        if not (self.flight.armed and self.flight.landed):
            return False
        return self.flight.mode is FlightMode.HOLD or self._delays()

    def _delays(self) -> bool:
        at = self.flight.current
        return self.profile.runs_on_ground and at < len(self._flown) and self._flown[at].command == Command.NAV_DELAY

    def _say(self, message: Message, to: Target) -> None:
        self._outbox.append((message, to))

    def _text(self, severity: int, text: str) -> None:
        """Split a text that exceeds one message."""
        for chunk, start in enumerate(range(0, len(text), TEXT_BYTES)):
            self._say(m.Text(severity, text[start : start + TEXT_BYTES], int(len(text) > TEXT_BYTES), chunk), EVERYONE)

    def _stream(self, name: str) -> Message | None:
        match name:
            case "HEARTBEAT":
                return self._heartbeat()
            case "SYS_STATUS":
                return streams.status(self._passed_checks(), self.profile.reports_prearm)
            case "MISSION_CURRENT":
                self._repeat_reached()
                return self._current()
            case "TIMESYNC":
                return m.TimeSync(0, round(self._now * 1e9))
            case "GLOBAL_POSITION_INT" if self._age < self.profile.start_up.origin_s:
                return telemetry.Position(self._now, 0.0, 0.0, 0.0, 0.0) if self.profile.reports_prearm else None
            case "HOME_POSITION" | "GPS_GLOBAL_ORIGIN" if self._age < self.profile.start_up.origin_s:
                return None
            case _:
                return streams.FROM_FLIGHT[name](self.flight, self._now)

    def _repeat_reached(self) -> None:
        reached, times = self._last_reached
        if times > 0:
            self._last_reached = reached, times - 1
            self._say(reached, EVERYONE)

    def _heartbeat(self) -> m.Heartbeat:
        armed = m.ARMED_FLAG if self.flight.armed else 0
        state = STATE_STANDBY
        if not self.transfers.booted:
            state = STATE_BOOT if self.profile.reports_prearm else STATE_UNINIT
        elif self.flight.armed and not (self.profile.reports_prearm and self.flight.landed):
            state = STATE_ACTIVE
        elif not self.profile.reports_prearm and not self.flight.armed and self._arming_refusal():
            state = STATE_UNINIT
        return m.Heartbeat(
            QUADROTOR, self.profile.autopilot.mav_autopilot, self.profile.base_mode | armed, self.mode, state
        )

    def _current(self) -> m.Current:
        total = len(self.transfers.stores[MissionType.MISSION].items) - self._first
        if total <= 0:
            mode = MISSION_SUSPENDED if self._first == 0 else 0
            return m.Current(0, self.profile.no_total, int(MissionState.NO_MISSION), mode)
        number = self.transfers.list_id(MissionType.MISSION)
        if self.profile.runs_on_ground:
            seq, state = (self.flight.current + 1 if self._has_begun else 0), MissionState.NOT_STARTED
            if self._runs or self.flight.mode is FlightMode.MISSION:
                state = MissionState.ACTIVE
            if self.flight.armed and self.flight.mission_state is MissionState.COMPLETE:
                state = MissionState.COMPLETE
            return m.Current(seq, total, int(state), int(self.mode == self._mission_mode), number)
        active = self.mode in self.profile.placed_modes - {self.profile.modes[FlightMode.HOLD]}
        state = MissionState.ACTIVE if active else MissionState.NOT_STARTED
        if self._unflyable:
            state = MissionState.NO_MISSION
        elif self.flight.mission_state is MissionState.COMPLETE:
            state = MissionState.COMPLETE
        elif not active and self.flight.reached:
            state = MissionState.PAUSED
        mode = MISSION_ACTIVE if active else MISSION_SUSPENDED
        return m.Current(self.flight.current, total, int(state), mode, number)

    def _report_changes(self) -> None:
        """Send what this firmware does not leave to its streams."""
        reached = self.flight.reached
        if len(reached) < self._told_reached:
            self._told_reached = 0
        fresh = reached[self._told_reached :]
        if fresh and self._now < fresh[-1].time_s + self.profile.reached_slot_s:
            return  # another may follow and hide it
        self._told_reached += len(fresh)
        for n, one in enumerate(fresh):
            soon = one.time_s + self.profile.reached_slot_s
            if one.announced and not any(later.time_s < soon for later in fresh[n + 1 :]):
                self._last_reached = m.Reached(one.index + self._first), self.profile.reached_repeats
                self._say(self._last_reached[0], EVERYONE)
            if self.profile.runs_on_ground:
                self._say_item(one.index)
        if fresh and self.flight.mode is FlightMode.MISSION and self.profile.runs_on_ground:
            self._say_begun()
        elif not self.profile.runs_on_ground and self.flight.current != self._told_current and self._flown:
            self._say(self._current(), EVERYONE)
        self._told_current = self.flight.current
        if self.mode != self._told_mode:
            self._told_mode = self.mode
            if self.profile.heartbeat_on_change:
                self._say(self._heartbeat(), EVERYONE)

    def _say_item(self, index: int) -> None:
        command = self._flown[index].command
        if command in REPORTED_WHEN_REACHED:
            self._text(INFO, f"Reached command #{index + 1}")
        elif command > LAST_NAV:
            self._text(INFO, begun(index + 1, command))

    def _say_begun(self) -> None:
        if self.flight.current < len(self._flown):
            self._text(INFO, begun(self.flight.current + 1, self._flown[self.flight.current].command))
