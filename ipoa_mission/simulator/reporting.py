"""Telemetry of the built-in autopilot: its streams, and messages at events."""

import math
from collections.abc import Mapping
from enum import IntEnum

from ipoa_mission.autopilot.commands import LAST_NAV, WAYPOINTS, Command
from ipoa_mission.autopilot.vehicle_kind import QUADROTOR
from ipoa_mission.link import messages as m
from ipoa_mission.link import telemetry
from ipoa_mission.link.messages import INFO, Message, MissionType
from ipoa_mission.simulator import streams
from ipoa_mission.simulator.mock_vehicle import MockVehicle
from ipoa_mission.simulator.situation import FlightMode, MissionState

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


class MavState(IntEnum):
    """MAV_STATE."""

    UNINIT = 0
    BOOT = 1
    STANDBY = 3
    ACTIVE = 4


class MissionMode(IntEnum):
    """MISSION_CURRENT.mission_mode."""

    ACTIVE = 1
    SUSPENDED = 2


class Reporter:
    def __init__(self, vehicle: MockVehicle) -> None:
        self._vehicle = vehicle
        self.reported_mode = vehicle.profile.first_mode
        self._reported_current = -1
        self._reported_count = 0  # of items done
        self._last_reached = m.Reached(0), 0  # and how often it is still repeated
        self._checked = -math.inf, False  # time and result of the last pre-arm check

    def message(self, name: str) -> Message | None:
        """Return a message to send now; None: not sent."""
        vehicle = self._vehicle
        is_placed = vehicle.age >= vehicle.profile.start_up.origin_s
        match name:
            case "HEARTBEAT":
                return self._heartbeat()
            case "AUTOPILOT_VERSION":
                return telemetry.AutopilotVersion(vehicle.profile.capabilities, vehicle.profile.version.number, uid=1)
            case "PROTOCOL_VERSION" if vehicle.profile.protocol is not None:
                return telemetry.ProtocolVersion(*vehicle.profile.protocol)
            case "SYS_STATUS":
                return streams.status(self._passed_checks(), vehicle.profile.reports_prearm)
            case "MISSION_CURRENT":
                self._repeat_reached()
                return self.current()
            case "TIMESYNC":
                return m.TimeSync(0, round(vehicle.now * 1e9))
            case "GLOBAL_POSITION_INT" if not is_placed:
                return telemetry.Position(vehicle.now, 0.0, 0.0, 0.0, 0.0) if vehicle.profile.reports_prearm else None
            case "HOME_POSITION" | "GPS_GLOBAL_ORIGIN" if not is_placed:
                return None
            case _:
                return streams.FROM_FLIGHT[name](vehicle.flight, vehicle.now)

    def _passed_checks(self) -> bool:
        """The last check may precede the last change of mode."""
        checked_s, _ = self._checked
        if self._vehicle.now - checked_s >= self._vehicle.profile.prearm_every_s:
            self._checked = self._vehicle.now, not self._vehicle.arming_refusal()
        return self._checked[1]

    def _repeat_reached(self) -> None:
        reached, times = self._last_reached
        if times > 0:
            self._last_reached = reached, times - 1
            self._vehicle.send(reached)

    def _heartbeat(self) -> m.Heartbeat:
        vehicle, profile, armed = self._vehicle, self._vehicle.profile, self._vehicle.flight.armed
        state = MavState.STANDBY
        if not vehicle.transfers.booted:
            state = MavState.BOOT if profile.reports_prearm else MavState.UNINIT
        elif armed and not (profile.reports_prearm and vehicle.flight.landed):
            state = MavState.ACTIVE
        elif not profile.reports_prearm and not armed and vehicle.arming_refusal():
            state = MavState.UNINIT
        base_mode = profile.base_mode | (m.ARMED_FLAG if armed else 0)
        return m.Heartbeat(QUADROTOR, profile.autopilot.mav_autopilot, base_mode, vehicle.mode, state)

    def current(self) -> m.Current:
        vehicle, profile, flight = self._vehicle, self._vehicle.profile, self._vehicle.flight
        total = len(vehicle.transfers.stores[MissionType.MISSION].items) - vehicle.first_item
        if total <= 0:
            mode = 0 if vehicle.first_item else MissionMode.SUSPENDED
            return m.Current(0, profile.no_total, MissionState.NO_MISSION, mode)
        list_id = vehicle.transfers.list_id(MissionType.MISSION)
        is_complete = flight.mission_state is MissionState.COMPLETE
        if profile.runs_on_ground:
            seq, state = (flight.current + 1 if vehicle.mission_begun else 0), MissionState.NOT_STARTED
            if vehicle.mission_runs or flight.mode is FlightMode.MISSION:
                state = MissionState.ACTIVE
            if flight.armed and is_complete:
                state = MissionState.COMPLETE
            return m.Current(seq, total, state, int(vehicle.mode == vehicle.mission_mode), list_id)
        is_active = vehicle.mode in profile.placed_modes - {profile.modes[FlightMode.HOLD]}
        state = MissionState.ACTIVE if is_active else MissionState.NOT_STARTED
        if vehicle.infeasible:
            state = MissionState.NO_MISSION
        elif is_complete:
            state = MissionState.COMPLETE
        elif not is_active and flight.reached:
            state = MissionState.PAUSED
        mode = MissionMode.ACTIVE if is_active else MissionMode.SUSPENDED
        return m.Current(flight.current, total, state, mode, list_id)

    def report_current(self, index: int) -> None:
        self._vehicle.send(self.current())
        self._reported_current = index

    def report_changes(self) -> None:
        """Send what this firmware does not leave to its streams."""
        vehicle, profile, flight = self._vehicle, self._vehicle.profile, self._vehicle.flight
        reached = flight.reached
        if len(reached) < self._reported_count:
            self._reported_count = 0
        done = reached[self._reported_count :]
        if done and vehicle.now < done[-1].time_s + profile.reached_slot_s:
            return  # another may follow and hide it
        self._reported_count += len(done)
        for n, item in enumerate(done):
            slot_end_s = item.time_s + profile.reached_slot_s
            if item.announced and not any(later.time_s < slot_end_s for later in done[n + 1 :]):
                self._last_reached = m.Reached(item.index + vehicle.first_item), profile.reached_repeats
                vehicle.send(self._last_reached[0])
            if profile.runs_on_ground:
                self._report_done(item.index)
        if done and flight.mode is FlightMode.MISSION and profile.runs_on_ground:
            self.report_begun()
        elif not profile.runs_on_ground and flight.current != self._reported_current and vehicle.items:
            vehicle.send(self.current())
        self._reported_current = flight.current
        if vehicle.mode != self.reported_mode:
            self.reported_mode = vehicle.mode
            if profile.heartbeat_on_change:
                vehicle.send(self._heartbeat())

    def _report_done(self, index: int) -> None:
        command = self._vehicle.items[index].command
        if command in REPORTED_WHEN_REACHED:
            self._vehicle.send_text(INFO, f"Reached command #{index + 1}")
        elif command > LAST_NAV:
            self._report_item(index)

    def report_begun(self) -> None:
        if self._vehicle.flight.current < len(self._vehicle.items):
            self._report_item(self._vehicle.flight.current)

    def _report_item(self, index: int) -> None:
        name = _NAMES.get(self._vehicle.items[index].command, "?")
        self._vehicle.send_text(INFO, f"Mission: {index + 1} {name}")
