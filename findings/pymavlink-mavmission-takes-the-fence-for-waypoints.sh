#!/bin/sh
# pymavlink's mavmission writes the corners of a fence over the first waypoints of a mission.
#
# pymavlink 2.4.50, mavmission.py of a telemetry log in which a station reads the mission of a vehicle, and then its
# fence, as each does on connecting. Guess: the mission, as items have a mission_type. Seen: of a mission of home,
# takeoff, three waypoints and a return, items 0 to 3 are the four corners of the fence, items 4 and 5 are kept;
# uploaded, this is no mission. "Saved 6 waypoints" is said. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
cat >log.py <<'PY'
import struct
from pathlib import Path

from pymavlink.dialects.v20 import ardupilotmega as dialect

vehicle = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
log = b""


def add(message):
    global log
    log += struct.pack(">Q", 1_780_000_000_000_000 + 1000 * len(log)) + message.pack(vehicle)


def items(kind, rows):
    for number, (command, frame, latitude, longitude, height) in enumerate(rows):
        place = int(latitude * 1e7), int(longitude * 1e7), height
        add(vehicle.mission_item_int_encode(255, 190, number, frame, command, 0, 1, 0, 0, 0, 0, *place, kind))


add(vehicle.heartbeat_encode(2, 3, 81, 0, 3))
points = [(16, 3, 47 + step / 1000, 8, 50) for step in range(3)]
items(dialect.MAV_MISSION_TYPE_MISSION, [(16, 0, 47, 8, 488), (22, 3, 0, 0, 30), *points, (20, 2, 0, 0, 0)])
corners = [(5001, 0, 47 + north / 50, 8 + east / 50, 0) for north, east in ((0, 0), (0, 1), (1, 1), (1, 0))]
items(dialect.MAV_MISSION_TYPE_FENCE, corners)
Path("flight.tlog").write_bytes(log)
PY
./venv/bin/python log.py
MAVLINK20=1 ./venv/bin/mavmission.py --output mission.txt flight.tlog >said
commands=$(tail -n +2 mission.txt | cut -f 4 | tr '\n' ' ')
echo "$(cat said); commands: $commands"
[ "$commands" = "5001 5001 5001 5001 16 20 " ] && grep -q "Saved 6 waypoints" said
