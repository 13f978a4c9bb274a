#!/bin/sh
# MAVSDK's import of a .plan takes the doJumpId in a DO_JUMP for the number of an item.
#
# mavsdk 4.1.0, import_qgroundcontrol_mission_from_string. A DO_JUMP of a .plan names the doJumpId of an item, which may be
# any number. Guess: the import resolves it to the item's number. Seen: param1 stays 7, where the list has three items;
# a vehicle that takes it jumps elsewhere or nowhere. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavsdk==4.1.0 pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY' 2>/dev/null
import json
from importlib.metadata import version

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from pymavlink.dialects.v20 import common


def item(command, frame, params, jump_id):
    about = {"type": "SimpleItem", "autoContinue": True, "command": command, "frame": frame, "params": params}
    return about | {"doJumpId": jump_id}


place = [0, 0, 0, None, 47.398, 8.5456, 20]
items = [item(22, 3, place, 1), item(16, 3, place, 7), item(177, 2, [7, 2, 0, 0, 0, 0, 0], 9)]
mission = {"version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5, "items": items}
mission |= {"plannedHomePosition": [47.3977, 8.5456, 488], "globalPlanAltitudeMode": 1}
plan = {"fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "mission": mission}
plan |= {"geoFence": {"circles": [], "polygons": [], "version": 2}, "rallyPoints": {"points": [], "version": 2}}
station = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
station.add_any_connection("raw://")
vehicle = common.MAVLink(None, srcSystem=1, srcComponent=1)
heartbeat = vehicle.heartbeat_encode(common.MAV_TYPE_QUADROTOR, common.MAV_AUTOPILOT_PX4, 0, 0, 3)
station.pass_received_raw_bytes(heartbeat.pack(vehicle))
plugin = MissionRaw(station.first_autopilot(10.0))
read = plugin.import_qgroundcontrol_mission_from_string(json.dumps(plan)).mission_items
target, count = read[2].param1, len(read)
plugin.destroy()
station.destroy()
print(f"mavsdk {version('mavsdk')}: DO_JUMP to {target:g} in a list of {count} items; doJumpId 7 is item 2")
raise SystemExit(0 if (target, count) == (7.0, 3) else 1)
PY
