"""Reasons that a vehicle reports: its texts (STATUSTEXT), and PX4's events, sent as numbers with arguments.

PX4 1.17 and 1.18 report a mission's feasibility by events alone. They report other reasons as both: the words here
equal the text, so that a reason counts once.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

from ipoa_mission.link import messages as m


def event_number(name: str) -> int:
    """Return PX4's number of an EVENT: component id, and lower 24 bits of the name's FNV-1a hash."""
    value = 0x811C9DC5
    for byte in name.encode():
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return 1 << 24 | value & 0xFFFFFF  # of the autopilot


#: PX4's words for a mode, by events' navigation_mode_t.
_MODES = {0: "Manual", 1: "Altitude", 2: "Position", 3: "Mission", 4: "Hold", 5: "Return", 10: "Takeoff", 11: "Land"}
#: Words, and the memory layout of the arguments that they name. `mode` is the last argument.
_EVENTS: Mapping[int, tuple[str, str]] = {
    event_number(name): (words, layout)
    for name, words, layout in (
        ("navigator_mis_takeoff_missing", "the mission needs a take-off item", "<"),
        ("navigator_mis_land_missing", "the mission needs a landing item", "<"),
        ("feasibility_mis_in_air_landing_req", "the mission needs a landing item", "<"),
        ("navigator_mis_takeoff_or_land_missing", "the mission lacks a take-off or a landing item", "<"),
        ("navigator_mis_add_land_or_rm_to", "the mission has a take-off but no landing", "<"),
        ("navigator_mis_add_to_or_rm_land", "the mission has a landing but no take-off", "<"),
        ("navigator_mis_takeoff_too_low", "the take-off is not above home", "<"),
        ("navigator_mis_takeoff_not_first", "the take-off is not the first item with a position", "<"),
        ("navigator_mis_starts_w_landing", "the mission begins with a landing", "<"),
        ("navigator_mis_starts_w_landing2", "the mission begins with a landing", "<"),
        ("navigator_mis_unsup_cmd", "item {0} has command {1}, which this vehicle cannot fly", "<HH"),
        ("navigator_mis_no_home_rel_alt", "the vehicle has no home, but item {0} has an altitude above it", "<h"),
        ("navigator_mis_vtol_items", "the mission has items of a VTOL, and the vehicle is none", "<"),
        ("navigator_mis_dm_read_fail", "the vehicle could not read its stored item {0} (list {1})", "<HB"),
        ("navigator_mis_first_wp_far", "the first waypoint is {0} m from home", "<I"),
        ("navigator_mis_wp_gate_too_close", "a waypoint and a gate are only {0:.0f} m apart", "<f"),
        ("navigator_mis_no_pos_lock", "the vehicle has no position yet", "<"),
        ("navigator_mis_geofence_no_home", "the vehicle's fence needs a home position", "<"),
        ("navigator_mis_geofence_no_home2", "the vehicle's fence needs a home position", "<"),
        ("navigator_mis_geofence_violation", "item {0} is outside of the vehicle's fence", "<h"),
        ("commander_arm_denied_calibrating", "Arming denied: calibrating", "<"),
        ("commander_arm_denied_throttle_unsafe", "Arming denied: throttle not in safe position", "<"),
        ("commander_arm_denied_resolve_failures", "Arming denied: Resolve system health failures first", "<"),
        ("commander_disarm_denied_not_landed", "Disarming denied: not landed", "<"),
        ("commander_mission_start_denied_no_mission", "Mission start denied! No valid mission", "<"),
        ("commander_modeswitch_not_avail", "Switching to {mode} is currently not available", "<IB"),
        ("check_system_no_global_pos", "Preflight Fail: Global position estimate required", "<"),
        ("check_system_no_home_pos", "Preflight Fail: Home position required", "<"),
        ("check_system_safety_button", "Preflight Fail: Press safety button first", "<"),
        ("check_modes_angular_velocity", "Preflight Fail: No valid data from the gyroscopes", "<"),
        ("check_modes_attitude", "Preflight Fail: Attitude estimate required", "<"),
        ("check_modes_local_alt", "Preflight Fail: Altitude estimate required", "<"),
        ("check_modes_local_pos", "Preflight Fail: Position estimate required", "<"),
        ("check_modes_global_pos", "Preflight Fail: Global position estimate required", "<"),
        ("check_estimator_missing_data", "Preflight Fail: ekf2 missing data", "<"),
        ("check_estimator_hgt_not_stable", "Preflight Fail: height estimate not stable", "<"),
        ("check_estimator_hor_pos_not_stable", "Preflight Fail: horizontal position unstable", "<"),
        ("check_estimator_hor_vel_not_stable", "Preflight Fail: horizontal velocity unstable", "<"),
        ("check_estimator_vert_vel_not_stable", "Preflight Fail: vertical velocity unstable", "<"),
        ("check_rc_dl_no_dllink", "Preflight Fail: No connection to the GCS", "<"),
        ("check_battery_low", "Low battery", "<"),
        ("check_battery_critical", "Critical battery", "<"),
        ("check_battery_unhealthy", "Preflight Fail: Battery unhealthy", "<"),
    )
}


def event(name: str, *values: float) -> m.Event:
    """Return an event of `_EVENTS`, an error of PX4 for the user."""
    number = event_number(name)
    return m.Event(number, 0x63, struct.pack(_EVENTS[number][1], *values))


def words_in(message: m.Message | None, least_severity: int = m.WARNING) -> str:
    """Return the words of a text or an event, "" for others and less severe ones."""
    match message:
        case m.Text(severity, text) if severity <= least_severity:
            return text.rstrip("\t ")  # PX4 marks the text of an event with a tab
        case m.Event(number, levels, arguments) if levels & 0xF <= least_severity:  # the other four bits are internal
            words, layout = _EVENTS.get(number, ("", "<"))
            size = struct.calcsize(layout)
            values = struct.unpack(layout, arguments[:size].ljust(size, b"\0"))  # MAVLink cuts zeros off
            return words.format(*values, mode=_MODES.get(values[-1], "this mode") if values else "")
    return ""


@dataclass
class VehicleTexts:
    """The last twenty texts and events of a vehicle, each once."""

    least_severity: int = m.INFO
    words: list[str] = field(default_factory=list)

    def note(self, message: m.Message | None) -> None:
        words = words_in(message, self.least_severity)
        if words and words not in self.words:
            self.words = [*self.words[-19:], words]

    def __str__(self) -> str:
        return "; ".join(self.words)
