"""How telemetry lies in MAVLink's fields: scaled to integers, which say their end where a value does not fit."""

import math
from typing import Any

from ipoa_mission.link import telemetry
from ipoa_mission.link.layout import Fields, Layout, plain

NO_CELL = 0xFFFF  # BATTERY_STATUS.voltages


def _e7(latitude_deg: float, longitude_deg: float) -> tuple[int, int]:
    return saturated(latitude_deg * 1e7), saturated(longitude_deg * 1e7)


def _millis(seconds: float) -> int:
    return round(seconds * 1000) & 0xFFFFFFFF


def saturated(value: float, bits: int = 32) -> int:
    """Telemetry never fails: what does not fit a signed integer is told as its end, NaN as 0."""
    most = 2 ** (bits - 1) - 1
    return 0 if math.isnan(value) else round(min(max(value, -most), most))


def _write_position(p: telemetry.Position) -> Fields:
    lat, lon = _e7(p.latitude_deg, p.longitude_deg)
    vx, vy, vz = (saturated(v * 100, 16) for v in p.velocity)
    return {
        "time_boot_ms": _millis(p.time_s),
        "lat": lat,
        "lon": lon,
        "alt": saturated(p.altitude * 1000),
        "relative_alt": saturated(p.height * 1000),
        "vx": vx,
        "vy": vy,
        "vz": vz,
        "hdg": saturated(math.degrees(p.yaw) * 100) % 36000,
    }


def _read_position(raw: Any) -> telemetry.Position:
    return telemetry.Position(
        raw.time_boot_ms / 1000,
        raw.lat / 1e7,
        raw.lon / 1e7,
        raw.alt / 1000,
        raw.relative_alt / 1000,
        (raw.vx / 100, raw.vy / 100, raw.vz / 100),
        math.radians(raw.hdg / 100),
    )


def _write_home(h: telemetry.HomePosition) -> Fields:
    lat, lon = _e7(h.latitude_deg, h.longitude_deg)
    zeros = dict.fromkeys(("x", "y", "z", "approach_x", "approach_y", "approach_z"), 0.0)
    return {
        "latitude": lat,
        "longitude": lon,
        "altitude": saturated(h.altitude * 1000),
        **zeros,
        "q": [1.0, 0.0, 0.0, 0.0],
    }


def _write_origin(o: telemetry.GlobalOrigin) -> Fields:
    lat, lon = _e7(o.latitude_deg, o.longitude_deg)
    return {"latitude": lat, "longitude": lon, "altitude": saturated(o.altitude * 1000)}


def _write_gps(g: telemetry.Gps) -> Fields:
    lat, lon = _e7(g.latitude_deg, g.longitude_deg)
    return {
        "time_usec": round(g.time_s * 1e6),
        "fix_type": g.fix_type,
        "lat": lat,
        "lon": lon,
        "alt": saturated(g.altitude * 1000),
        "eph": 80,
        "epv": 120,
        "vel": saturated(g.speed * 100, 16),
        "cog": 0xFFFF,
        "satellites_visible": g.satellites_visible,
    }


def _write_status(s: telemetry.SystemStatus) -> Fields:
    return {
        "onboard_control_sensors_present": s.present,
        "onboard_control_sensors_enabled": s.enabled,
        "onboard_control_sensors_health": s.health,
        "load": 200,
        "voltage_battery": round(s.voltage * 1000),
        "current_battery": round(s.current * 100),
        "battery_remaining": s.battery_remaining,
        **dict.fromkeys(
            ("drop_rate_comm", "errors_comm", "errors_count1", "errors_count2", "errors_count3", "errors_count4"), 0
        ),
    }


def _write_battery(b: telemetry.BatteryStatus) -> Fields:
    volts = [round(b.voltage * 1000), *[NO_CELL] * 9]
    return {"id": b.id, "voltages": volts, "current_battery": round(b.current * 100)}


def _read_battery(raw: Any) -> telemetry.BatteryStatus:
    """The cells of a pack, or all of it in the first ones."""
    cells = [cell for cell in raw.voltages if cell != NO_CELL] + list(raw.voltages_ext)
    return telemetry.BatteryStatus(raw.id, sum(cells) / 1000, raw.current_battery / 100)


LAYOUTS: tuple[Layout[Any], ...] = (
    Layout(
        "AUTOPILOT_VERSION",
        telemetry.AutopilotVersion,
        lambda a: {"capabilities": a.capabilities, "flight_sw_version": a.flight_sw_version, "uid": a.uid},
        lambda raw: telemetry.AutopilotVersion(raw.capabilities, raw.flight_sw_version, raw.uid),
    ),
    Layout(
        "HOME_POSITION",
        telemetry.HomePosition,
        _write_home,
        lambda raw: telemetry.HomePosition(raw.latitude / 1e7, raw.longitude / 1e7, raw.altitude / 1000),
    ),
    Layout(
        "GPS_GLOBAL_ORIGIN",
        telemetry.GlobalOrigin,
        _write_origin,
        lambda raw: telemetry.GlobalOrigin(raw.latitude / 1e7, raw.longitude / 1e7, raw.altitude / 1000),
    ),
    Layout("GLOBAL_POSITION_INT", telemetry.Position, _write_position, _read_position),
    Layout(
        "LOCAL_POSITION_NED",
        telemetry.LocalPosition,
        lambda p: {
            "time_boot_ms": _millis(p.time_s),
            **dict(zip(("x", "y", "z", "vx", "vy", "vz"), (*p.position, *p.velocity), strict=True)),
        },
        lambda raw: telemetry.LocalPosition(raw.time_boot_ms / 1000, (raw.x, raw.y, raw.z), (raw.vx, raw.vy, raw.vz)),
    ),
    Layout(
        "GPS_RAW_INT",
        telemetry.Gps,
        _write_gps,
        lambda raw: telemetry.Gps(
            raw.time_usec / 1e6,
            raw.lat / 1e7,
            raw.lon / 1e7,
            raw.alt / 1000,
            raw.vel / 100,
            raw.fix_type,
            raw.satellites_visible,
        ),
    ),
    Layout(
        "ATTITUDE",
        telemetry.Attitude,
        lambda a: {"time_boot_ms": _millis(a.time_s), "roll": a.roll, "pitch": a.pitch, "yaw": a.yaw},
        lambda raw: telemetry.Attitude(raw.time_boot_ms / 1000, raw.roll, raw.pitch, raw.yaw),
    ),
    plain("VFR_HUD", telemetry.Hud),
    Layout(
        "SYS_STATUS",
        telemetry.SystemStatus,
        _write_status,
        lambda raw: telemetry.SystemStatus(
            raw.onboard_control_sensors_present,
            raw.onboard_control_sensors_enabled,
            raw.onboard_control_sensors_health,
            raw.voltage_battery / 1000,
            raw.battery_remaining,
            raw.current_battery / 100,
        ),
    ),
    Layout("BATTERY_STATUS", telemetry.BatteryStatus, _write_battery, _read_battery),
    plain("EXTENDED_SYS_STATE", telemetry.ExtendedState),
    Layout(
        "SYSTEM_TIME",
        telemetry.SystemTime,
        lambda t: {"time_unix_usec": round(t.unix_s * 1e6), "time_boot_ms": _millis(t.boot_s)},
        lambda raw: telemetry.SystemTime(raw.time_unix_usec / 1e6, raw.time_boot_ms / 1000),
    ),
    plain("RADIO_STATUS", telemetry.RadioStatus),
)
