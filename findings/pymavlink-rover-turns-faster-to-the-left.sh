#!/bin/sh
# pymavlink's rover turns at 204 degrees a second to the right and 276 to the left, with the same steering.
#
# pymavlink 2.4.50, mavextra's rover_yaw_rate and rover_lat_accel, for graphs of a log. Guess: at 2 m/s both sides have
# one rate, about that of a wheelbase of 0.335 m with wheels at 20 degrees, 125 degrees a second. Seen: the radius of
# the turn is taken for its diameter, and half of the track is added to it with the sign of a right turn only. The
# lateral acceleration is 7.1 to the right and 9.6 to the left, for 4.4 m/s2. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version
from math import degrees, radians, tan

from pymavlink import mavextra
from pymavlink.dialects.v20 import common as mavlink

WHEELBASE, SPEED, WHEELS = 0.335, 2.0, 20
hud = mavlink.MAVLink_vfr_hud_message(SPEED, SPEED, 0, 0, 0, 0)


def steering(side):
    pulse = 1500 + side * round(400 * WHEELS / 35)
    return mavlink.MAVLink_servo_output_raw_message(0, 0, pulse, *[1500] * 7)


rates = [round(mavextra.rover_yaw_rate(hud, steering(side))) for side in (1, -1)]
sideways = [round(mavextra.rover_lat_accel(hud, steering(side)), 1) for side in (1, -1)]
model = degrees(SPEED * tan(radians(WHEELS)) / WHEELBASE)
print(f"pymavlink {version('pymavlink')}: degrees a second to the right and left {rates}, by the wheels {model:.0f};")
print(f"lateral acceleration in m/s2 {sideways}")
raise SystemExit(0 if rates == [204, -276] and sideways == [7.1, -9.6] else 1)
PY
