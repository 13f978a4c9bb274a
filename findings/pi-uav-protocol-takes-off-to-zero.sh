#!/bin/sh
# pi-uav-protocol sends a takeoff to 0 m where the height is called "alt", as its own description has it.
#
# pi-uav-protocol 0.2.0, ControlCommand, whose params "can have meaningful names" as alt, to a MAVLink command. Guess: a
# takeoff with alt 30 is NAV_TAKEOFF to 30 m, or an error. Seen: to 0 m, as only "altitude" is read; a GOTO with lat and
# lon goes to latitude 0, longitude 0. A heading of 65535, which MAVLink defines as unknown, becomes a yaw of 655.35
# degrees of true north. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pi-uav-protocol==0.2.0 pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from pi_uav_protocol.adapters.mavlink.converter import mavlink_to_telemetry
from pi_uav_protocol.adapters.mavlink.profile import ArduPilotProfile
from pi_uav_protocol.domain.commands import ControlCommand
from pi_uav_protocol.domain.enums import ControlMethod
from pymavlink.dialects.v20.common import MAVLink_global_position_int_message


def sent(method, **params):
    frame = ArduPilotProfile("copter").build_command(ControlCommand("uav", method, params)).frame
    return frame.params[6] if method is ControlMethod.TAKEOFF else (frame.x, frame.y, frame.z)


heights = [sent(ControlMethod.TAKEOFF, **{name: 30}) for name in ("alt", "altitude")]
place = sent(ControlMethod.GOTO, lat=47.4, lon=8.5, alt=30)
unknown = MAVLink_global_position_int_message(0, 474000000, 85000000, 500000, 30000, 0, 0, 0, 65535)
yaw = mavlink_to_telemetry(unknown, "uav").yaw
print(f"pi-uav-protocol {version('pi-uav-protocol')}: takeoffs with alt and altitude 30 to {heights} m; goto {place};")
named = '"alt"' in ControlCommand.__doc__
print(f"an unknown heading is a yaw of {yaw} degrees; alt is in its description: {named}")
as_seen = heights == [0, 30] and place == (0, 0, 0) and yaw == 655.35
raise SystemExit(0 if as_seen and named else 1)
PY
