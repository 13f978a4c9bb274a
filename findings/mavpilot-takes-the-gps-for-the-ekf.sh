#!/bin/sh
# mavpilot waits for the health of the GPS where it says that it waits for that of the attitude.
#
# mavpilot 0.3.0, Telemetry and wait_until_ready, with pymavlink's SYS_STATUS. Guess: a vehicle whose attitude is
# healthy is ready without GPS, as by optical flow, and one whose attitude has failed is not. Seen: the reverse, as bit
# 32 is that of the GPS and 2097152 that of the AHRS. The error blames the AHRS. A heartbeat of a gimbal in the vehicle
# makes is_armed false in flight. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
"$folder/venv/bin/pip" install -q --no-deps mavpilot==0.3.0
cd "$folder"
./venv/bin/python - <<'PY'
import asyncio
from importlib.metadata import version
from types import SimpleNamespace

from mavpilot.core.safety import SafetyOps
from mavpilot.core.telemetry import Telemetry
from mavpilot.errors import DroneError
from pymavlink.dialects.v20 import common as mavlink

SENSORS = {"AHRS": mavlink.MAV_SYS_STATUS_AHRS, "GPS": mavlink.MAV_SYS_STATUS_SENSOR_GPS}


def heard(telemetry, message, component=1):
    message._header = mavlink.MAVLink_header(message.id, srcSystem=1, srcComponent=component)
    telemetry.handle_message(message)


def readiness(healthy):
    telemetry = Telemetry(SimpleNamespace(target_system=1))
    heard(telemetry, mavlink.MAVLink_sys_status_message(healthy, healthy, healthy, *[0] * 10))
    heard(telemetry, mavlink.MAVLink_local_position_ned_message(0, 0, 0, 0, 0, 0, 0))
    try:
        asyncio.run(SafetyOps(SimpleNamespace(_mock=False, _telemetry=telemetry)).wait_until_ready(0.2))
    except DroneError as error:
        return str(error).split(": ")[1].split(" (")[0]
    return "ready"


def is_armed_after(*beats):
    telemetry = Telemetry(SimpleNamespace(target_system=1))
    for component, kind, mode in beats:
        heard(telemetry, mavlink.MAVLink_heartbeat_message(kind, 12, mode, 0, 4, 3), component)
    return telemetry.is_armed()


seen = {name: readiness(bit) for name, bit in SENSORS.items()}
vehicle = 1, mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_MODE_FLAG_SAFETY_ARMED
gimbal = mavlink.MAV_COMP_ID_GIMBAL, mavlink.MAV_TYPE_GIMBAL, 0
armed = [is_armed_after(vehicle), is_armed_after(vehicle, gimbal)]
print(f"mavpilot {version('mavpilot')}, with one healthy sensor: {seen}; armed before and after a gimbal: {armed}")
is_reversed = seen == {"AHRS": "SYS_STATUS AHRS health bit is not set", "GPS": "ready"}
raise SystemExit(0 if is_reversed and armed == [True, False] else 1)
PY
