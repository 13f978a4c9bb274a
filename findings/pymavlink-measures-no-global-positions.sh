#!/bin/sh
# pymavlink puts two GLOBAL_POSITION_INT that are 100 m apart 778 km apart, and no distance has a climb.
#
# pymavlink 2.4.50, mavextra's distance_two and distance_from, which graphs of MAVExplorer call. Guess: two positions
# are 100 m apart, as GPS_RAW_INT and as GLOBAL_POSITION_INT, and 141 m with 100 m of height and horizontal=False. Seen:
# only those of GPS_RAW_INT are 100 m apart. In the other message 473977418, in 1e-7 degrees, is taken for degrees; from
# a place given in degrees it is 16559 km. With horizontal=False it is 100 m, too, for the option goes nowhere. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from pymavlink import mavextra
from pymavlink.dialects.v20 import common as mavlink

START, NORTH = 473977418, 473977418 + 8993


def raw(latitude, height):
    return mavlink.MAVLink_gps_raw_int_message(0, 3, latitude, 85455941, height, 0, 0, 0, 0, 10)


def fused(latitude, height):
    return mavlink.MAVLink_global_position_int_message(0, latitude, 85455941, height, 0, 0, 0, 0, 0)


def apart(message, **options):
    return round(mavextra.distance_two(message(START, 500000), message(NORTH, 600000), **options))


place = START / 1e7, 8.5455941
seen = {message.__name__: [apart(message), apart(message, horizontal=False)] for message in (raw, fused)}
away = [round(mavextra.distance_from(message(NORTH, 600000), *place)) for message in (raw, fused)]
print(f"pymavlink {version('pymavlink')}: distances in m, level and with the climb: {seen}; from a place: {away}")
as_seen = seen == {"raw": [100, 100], "fused": [778364, 778364]} and away == [100, 16558858]
raise SystemExit(0 if as_seen else 1)
PY
