import math
from typing import Any

from ipoa_mission.link import telemetry as t
from ipoa_mission.link.message_layout import MessageLayout, Value, plain


def saturated(value: float, bits: int = 32) -> int:
    """NaN gives 0: telemetry must not fail."""
    most = 2 ** (bits - 1) - 1
    return 0 if math.isnan(value) else round(min(max(value, -most), most))


def _scaled(name: str, by: float, bits: int = 32) -> Value:
    return Value((name,), lambda value: saturated(value * by, bits), lambda raw: raw / by)


def _rounded(name: str, by: float) -> Value:
    return Value((name,), lambda value: round(value * by), lambda raw: raw / by)


_BOOT = Value(("time_boot_ms",), lambda seconds: round(seconds * 1000) & 0xFFFFFFFF, lambda raw: raw / 1000)
_VELOCITY = Value(
    ("vx", "vy", "vz"),
    lambda velocity: tuple(saturated(axis * 100, 16) for axis in velocity),
    lambda raw: tuple(axis / 100 for axis in raw),
)
_HEADING = Value(("hdg",), lambda yaw: saturated(math.degrees(yaw) * 100) % 36000, lambda raw: math.radians(raw / 100))
_PLACE = {"latitude_deg": _scaled("latitude", 1e7), "longitude_deg": _scaled("longitude", 1e7)}
_SHORT_PLACE = {"latitude_deg": _scaled("lat", 1e7), "longitude_deg": _scaled("lon", 1e7)}
_ALTITUDE = {"altitude": _scaled("altitude", 1000)}
_NO_CELL = 0xFFFF
#: Cells, or the total in the first cells.
_CELLS = Value(
    ("voltages", "voltages_ext"),
    lambda voltage: ([round(voltage * 1000), *[_NO_CELL] * 9], [0] * 4),
    lambda raw: sum(cell for cell in (*raw[0], *raw[1]) if cell != _NO_CELL) / 1000,
)
#: Not measured; a charged lithium polymer battery of the whole vehicle.
_BATTERY = {"current_consumed": -1, "energy_consumed": -1, "temperature": 0x7FFF} | {
    "battery_function": 1,
    "type": 1,
    "charge_state": 1,
}
_SENSORS = {name: f"onboard_control_sensors_{name}" for name in ("present", "enabled", "health")}

LAYOUTS: tuple[MessageLayout[Any], ...] = (
    plain("AUTOPILOT_VERSION", t.AutopilotVersion),
    plain("PROTOCOL_VERSION", t.ProtocolVersion),
    plain("HOME_POSITION", t.HomePosition, {"q": [1.0, 0.0, 0.0, 0.0]}, **_PLACE, **_ALTITUDE),
    plain("GPS_GLOBAL_ORIGIN", t.GlobalOrigin, **_PLACE, **_ALTITUDE),
    plain(
        "GLOBAL_POSITION_INT",
        t.Position,
        time_s=_BOOT,
        **_SHORT_PLACE,
        altitude=_scaled("alt", 1000),
        height=_scaled("relative_alt", 1000),
        velocity=_VELOCITY,
        yaw=_HEADING,
    ),
    plain(
        "LOCAL_POSITION_NED",
        t.LocalPosition,
        time_s=_BOOT,
        position=Value(("x", "y", "z")),
        velocity=Value(("vx", "vy", "vz")),
    ),
    plain(
        "GPS_RAW_INT",
        t.Gps,
        {"eph": 80, "epv": 120, "cog": 0xFFFF},
        time_s=_rounded("time_usec", 1e6),
        **_SHORT_PLACE,
        altitude=_scaled("alt", 1000),
        speed=_scaled("vel", 100, 16),
    ),
    plain("ATTITUDE", t.Attitude, time_s=_BOOT),
    plain("VFR_HUD", t.Hud),
    plain(
        "SYS_STATUS",
        t.SystemStatus,
        {"load": 200},
        **_SENSORS,
        voltage=_rounded("voltage_battery", 1000),
        current=_rounded("current_battery", 100),
    ),
    plain("BATTERY_STATUS", t.BatteryStatus, _BATTERY, voltage=_CELLS, current=_rounded("current_battery", 100)),
    plain("WIND", t.WindEstimate, direction_deg="direction"),
    plain("WIND_COV", t.WindVelocity, velocity=Value(("wind_x", "wind_y", "wind_z"))),
    plain("EXTENDED_SYS_STATE", t.ExtendedState),
    plain("SYSTEM_TIME", t.SystemTime, unix_s=_rounded("time_unix_usec", 1e6), boot_s=_BOOT),
    plain("RADIO_STATUS", t.RadioStatus),
)
