"""State that commands change, and telemetry that reports it: on request, as a stream, at events."""

import math
from collections.abc import Mapping, Set
from dataclasses import astuple
from enum import IntEnum

from ipoa_mission.autopilot.autopilot import QUADROTOR
from ipoa_mission.autopilot.commands import LAST_NAV, WAYPOINTS, Command
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.link import messages as m
from ipoa_mission.link.codec import EVERYONE, Target
from ipoa_mission.link.definitions import message_name
from ipoa_mission.link.messages import INFO, Message, MissionState, MissionType
from ipoa_mission.link.vehicle_state import PREARM_CHECK
from ipoa_mission.link.wire import saturated
from ipoa_mission.mission.items import Item
from ipoa_mission.simulator.mission_service import MissionService, infeasibility
from ipoa_mission.simulator.mock_profile import MockProfile
from ipoa_mission.simulator.simulated_flight import SimulatedFlight
from ipoa_mission.simulator.situation import FlightMode

TEXT_BYTES = 50  # of a STATUSTEXT
#: MAV_SYS_STATUS_SENSOR: gyroscopes, accelerometers, compass, barometer, GPS, fence, AHRS, battery.
SENSORS = 1 | 2 | 4 | 8 | 32 | 0x100000 | 0x200000 | 0x2000000
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
FASTEST_S, SLOWEST_S = 0.01, 2000.0
#: As a stream or on request.
KNOWN_MESSAGES = frozenset({
    "HEARTBEAT", "SYS_STATUS", "MISSION_CURRENT", "TIMESYNC", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED",
    "GPS_RAW_INT", "BATTERY_STATUS", "ATTITUDE", "VFR_HUD", "EXTENDED_SYS_STATE", "SYSTEM_TIME", "HOME_POSITION",
})  # fmt: skip
REPORTED_WHEN_REACHED = WAYPOINTS | {Command.NAV_LOITER_TIME, Command.NAV_LOITER_TURNS, Command.NAV_LOITER_TO_ALT}


class MavState(IntEnum):
    UNINIT = 0
    BOOT = 1
    STANDBY = 3
    ACTIVE = 4


class MissionMode(IntEnum):
    ACTIVE = 1
    SUSPENDED = 2


class MockVehicle:
    def __init__(self, profile: MockProfile, flight: SimulatedFlight, parameters: Parameters, powered_s: float) -> None:
        self.profile = profile
        self.flight = flight
        self.parameters = parameters
        self.transfers = MissionService(profile, lambda: flight.home, self.send, self.load_list)
        self.now = 0.0
        self.powered_s = powered_s
        self.outbox: list[tuple[Message, Target]] = []
        self.items: tuple[Item, ...] = ()  # without home, and only a complete mission
        self.infeasible: m.Event | None = None
        self.idle_mode = self.reported_mode = profile.first_mode  # without a command
        self.mode_before = profile.first_mode  # PX4: before a return or landing
        self.mission_begun = self.mission_runs = False  # ArduPilot: has a current item, and advances
        self._reported_current = -1
        self._reported_count = 0  # of items done
        self._last_reached = m.Reached(0), 0  # and how often it is still repeated
        self._checked = -math.inf, False  # time and result of the last pre-arm check

    @property
    def age(self) -> float:
        return self.now - self.powered_s  # [s]

    @property
    def mode(self) -> int:
        return self.idle_mode if self.flight.mode is FlightMode.HOLD else self.profile.modes[self.flight.mode]

    @property
    def mission_mode(self) -> int:
        return self.profile.modes[FlightMode.MISSION]

    @property
    def first_item(self) -> int:
        return self.profile.autopilot.seq_offset

    def send(self, message: Message, to: Target = EVERYONE) -> None:
        self.outbox.append((message, to))

    def send_text(self, severity: int, text: str) -> None:
        for chunk, start in enumerate(range(0, len(text), TEXT_BYTES)):
            self.send(m.Text(severity, text[start : start + TEXT_BYTES], int(len(text) > TEXT_BYTES), chunk))

    def arming_refusal(self) -> str:
        start_up = self.profile.start_up
        if self.age < start_up.steady_s:
            return start_up.unsteady
        if self.age < start_up.position_s and self.mode in self.profile.placed_modes:
            return start_up.unplaced
        if self.mode == self.mission_mode and not self.items:
            return start_up.no_mission
        if not self.profile.reports_prearm and self.mode not in self.profile.armable_modes:
            return start_up.unsteady
        return ""

    def load_list(self, kind: int) -> None:
        if kind == MissionType.RALLY:
            self.flight.know_rally(self.transfers.listed(kind))
        if kind != MissionType.MISSION:
            return
        items = self.transfers.listed(kind)[self.first_item :]
        self.infeasible = None
        autopilot = self.profile.autopilot
        if autopilot.protocol_profile.judges_later and items:
            self.infeasible = infeasibility(autopilot, self.profile.firmware, items, self.flight.home, self.parameters)
        if self.infeasible:
            self.send(self.infeasible)
        self.items = () if self.infeasible else items
        self.flight.load(self.items)
        if not items:
            self.mission_begun = self.mission_runs = False

    def message(self, name: str) -> Message | None:
        profile = self.profile
        flight = self.flight
        now = self.now
        is_placed = self.age >= profile.start_up.origin_s
        place = flight.position
        east, north, up = flight.motion
        roll, pitch, yaw = flight.attitude
        match name:
            case "HEARTBEAT":
                return self._heartbeat()
            case "AUTOPILOT_VERSION":
                return m.AutopilotVersion(profile.capabilities, profile.version.number, uid=1)
            case "PROTOCOL_VERSION" if profile.protocol is not None:
                return m.ProtocolVersion(*profile.protocol)
            case "SYS_STATUS":  # PX4's pre-arm check is healthy without being present
                present = SENSORS | (PREARM_CHECK if profile.reports_prearm else 0)
                return m.SystemStatus(present, present, SENSORS | (PREARM_CHECK if self._passed_checks() else 0))
            case "MISSION_CURRENT":
                self._repeat_reached()
                return self.current()
            case "TIMESYNC":
                return m.TimeSync(0, round(now * 1e9))
            case "GLOBAL_POSITION_INT" if not is_placed:
                return m.Position(now, 0.0, 0.0, 0.0, 0.0) if profile.reports_prearm else None
            case "GLOBAL_POSITION_INT":
                height = place.altitude - flight.home.altitude
                velocity = (north, east, -up)
                return m.Position(now, place.latitude_deg, place.longitude_deg, place.altitude, height, velocity, yaw)
            case "HOME_POSITION":
                return m.HomePosition(*astuple(flight.home)) if is_placed else None
            case "LOCAL_POSITION_NED":
                x, y, z = flight.place
                return m.LocalPosition(now, (y, x, -z), (north, east, -up))
            case "GPS_RAW_INT":
                return m.Gps(now, place.latitude_deg, place.longitude_deg, place.altitude, math.hypot(east, north))
            case "BATTERY_STATUS":
                return m.BatteryStatus(0, 12.6, -0.01, 100)
            case "ATTITUDE":
                return m.Attitude(now, roll, pitch, math.remainder(yaw, 2 * math.pi) if math.isfinite(yaw) else 0.0)
            case "VFR_HUD":
                speed = math.hypot(east, north)
                heading = saturated(math.degrees(yaw)) % 360
                return m.Hud(speed, speed, heading, 50 if flight.armed else 0, place.altitude, up)
            case "EXTENDED_SYS_STATE":
                return m.ExtendedState(1 if flight.on_ground else 2)
            case "SYSTEM_TIME":
                return m.SystemTime(0.0, now)
        return None

    def _passed_checks(self) -> bool:
        """Return the last check's result, which may be of an earlier mode."""
        if self.now - self._checked[0] >= self.profile.prearm_every_s:
            self._checked = self.now, not self.arming_refusal()
        return self._checked[1]

    def _repeat_reached(self) -> None:
        reached, times = self._last_reached
        if times > 0:
            self._last_reached = reached, times - 1
            self.send(reached)

    def _heartbeat(self) -> m.Heartbeat:
        profile = self.profile
        armed = self.flight.armed
        state = MavState.STANDBY
        if not self.transfers.booted:
            state = MavState.BOOT if profile.reports_prearm else MavState.UNINIT
        elif armed and not (profile.reports_prearm and self.flight.on_ground):
            state = MavState.ACTIVE
        elif not profile.reports_prearm and not armed and self.arming_refusal():
            state = MavState.UNINIT
        base_mode = profile.base_mode | (m.ARMED_FLAG if armed else 0)
        return m.Heartbeat(QUADROTOR, profile.autopilot.mav_autopilot, base_mode, self.mode, state)

    def current(self) -> m.Current:
        profile = self.profile
        flight = self.flight
        total = len(self.transfers.stores[MissionType.MISSION].items) - self.first_item
        if total <= 0:
            mode = 0 if self.first_item else MissionMode.SUSPENDED
            return m.Current(0, profile.no_total, MissionState.NO_MISSION, mode)
        list_id = self.transfers.list_id(MissionType.MISSION)
        is_complete = flight.mission is MissionState.COMPLETE
        if profile.runs_on_ground:
            seq = flight.current + 1 if self.mission_begun else 0
            state = MissionState.NOT_STARTED
            if self.mission_runs or flight.mode is FlightMode.MISSION:
                state = MissionState.ACTIVE
            if flight.armed and is_complete:
                state = MissionState.COMPLETE
            elif flight.armed and self.mode == self.mission_mode and flight.mission is MissionState.PAUSED:
                state = MissionState.PAUSED
            return m.Current(seq, total, state, int(self.mode == self.mission_mode), list_id)
        is_active = self.mode in profile.placed_modes - {profile.modes[FlightMode.HOLD]}
        state = MissionState.ACTIVE if is_active else MissionState.NOT_STARTED
        if self.infeasible or self.age < profile.start_up.origin_s:
            state = MissionState.NO_MISSION
        elif is_complete:
            state = MissionState.COMPLETE
        elif not is_active and flight.reached:
            state = MissionState.PAUSED
        mode = MissionMode.ACTIVE if is_active else MissionMode.SUSPENDED
        return m.Current(flight.current, total, state, mode, list_id)

    def report_changes(self) -> None:
        """Send what this firmware does not leave to its streams."""
        profile = self.profile
        flight = self.flight
        if len(flight.reached) < self._reported_count:
            self._reported_count = 0
        done = flight.reached[self._reported_count :]
        if done and self.now < done[-1].time_s + profile.reached_slot_s:
            return  # another may follow and hide it
        self._reported_count += len(done)
        for n, item in enumerate(done):
            slot_end_s = item.time_s + profile.reached_slot_s
            if item.announced and not any(later.time_s < slot_end_s for later in done[n + 1 :]):
                self._last_reached = m.Reached(item.index + self.first_item), profile.reached_repeats
                self.send(self._last_reached[0])
            command = self.items[item.index].command
            if profile.runs_on_ground and command in REPORTED_WHEN_REACHED:
                self.send_text(INFO, f"Reached command #{item.index + 1}")
            elif profile.runs_on_ground and command > LAST_NAV:
                self._report_item(item.index)
        if done and flight.mode is FlightMode.MISSION and profile.runs_on_ground:
            self.report_begun()
        elif not profile.runs_on_ground and flight.current != self._reported_current and self.items:
            self.send(self.current())
        self._reported_current = flight.current
        if self.mode != self.reported_mode:
            self.reported_mode = self.mode
            if profile.heartbeat_on_change:
                self.send(self._heartbeat())

    def report_begun(self) -> None:
        if self.flight.current < len(self.items):
            self._report_item(self.flight.current)

    def _report_item(self, index: int) -> None:
        self.send_text(INFO, f"Mission: {index + 1} {_NAMES.get(self.items[index].command, '?')}")


class Schedule:
    """One rate of a message for all listeners: the last ordered."""

    def __init__(self, usual: Mapping[str, float], fixed: Set[str]) -> None:
        """`usual`: default intervals [s]; `fixed`: streams of constant interval."""
        self._usual = usual
        self._fixed = fixed
        self._intervals = dict(usual)
        self._due = dict.fromkeys(usual, 0.0)

    def set_interval(self, number: int, interval_us: float, now: float) -> bool:
        """Command 511: -1 stops a stream, 0 restores its default; return whether it exists."""
        name = message_name(number)
        if name is None or name not in KNOWN_MESSAGES or name in self._fixed or math.isnan(interval_us):
            return False
        usual = self._usual.get(name, math.inf)
        seconds = math.inf if interval_us < 0 else min(max(interval_us / 1e6, FASTEST_S), SLOWEST_S)
        if name == "HEARTBEAT" and interval_us < 0:  # other listeners need it
            return True
        self._set(name, usual if interval_us == 0 else seconds, now)
        return True

    def set_rate(self, names: Set[str], rate_hz: int, now: float) -> None:
        """REQUEST_DATA_STREAM in whole milliseconds; 0 stops the group."""
        interval_ms = 0 if rate_hz == 0 else 1000 // rate_hz
        for name in names:
            self._set(name, math.inf if interval_ms == 0 else max(interval_ms / 1e3, FASTEST_S), now)

    def _set(self, name: str, seconds: float, now: float) -> None:
        if seconds != self._intervals.get(name, math.inf):
            self._intervals[name] = seconds
            self._due[name] = now + seconds

    def due(self, now: float) -> list[str]:
        names = [name for name, when in self._due.items() if when <= now]
        for name in names:
            self._due[name] = max(self._due[name] + self._intervals[name], now + self._intervals[name] / 2)
        return names

    @property
    def deadline(self) -> float:
        return min(self._due.values())
