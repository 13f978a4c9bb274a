#!/bin/sh
# MAVSDK's import of a Mission Planner file flies to home first, and moves the target of a jump by one item.
#
# mavsdk 4.1.0, import_mission_planner_mission_from_string. Line 0 of a `QGC WPL 110` file is home, not an item to fly.
# Guess: home is left out, or is item 0 once. Seen: for ArduPilot home is there twice, as item 0 and as a waypoint at
# the height of the ground before the takeoff; the DO_JUMP to line 2, a waypoint, now points at the takeoff. For PX4
# home is the first waypoint. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavsdk==4.1.0 pymavlink==2.4.50
cd "$folder"
cat >read.py <<'PY'
import sys

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from pymavlink.dialects.v20 import common

place = "47.3987 8.5"
rows = ["1 0 16 0 0 0 0 47.3977 8.5 488 1", f"0 3 22 0 0 0 0 {place} 30 1", f"0 3 16 0 0 0 0 {place} 40 1"]
rows += ["0 3 177 2 3 0 0 0 0 0 1"]
text = "QGC WPL 110\n" + "".join("\t".join(f"{n} {row}".split()) + "\n" for n, row in enumerate(rows))
station = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
station.add_any_connection("raw://")
vehicle = common.MAVLink(None, srcSystem=1, srcComponent=1)
heartbeat = vehicle.heartbeat_encode(common.MAV_TYPE_QUADROTOR, int(sys.argv[1]), 0, 0, 3)
station.pass_received_raw_bytes(heartbeat.pack(vehicle))
plugin = MissionRaw(station.first_autopilot(10.0))
items = plugin.import_mission_planner_mission_from_string(text).mission_items
print([(item.command, item.z) for item in items], f"jump to {items[-1].param1:g}")
plugin.destroy()
station.destroy()
PY
ardupilot=$(./venv/bin/python read.py 3 2>/dev/null | tail -1)
px4=$(./venv/bin/python read.py 12 2>/dev/null | tail -1)
echo "ArduPilot: $ardupilot"
echo "PX4: $px4"
[ "$ardupilot" = "[(16, 488.0), (16, 488.0), (22, 30.0), (16, 40.0), (177, 0.0)] jump to 2" ] &&
  [ "$px4" = "[(16, 488.0), (22, 30.0), (16, 40.0), (177, 0.0)] jump to 2" ]
