"""MAVSDK reads mission files in a process of its own: a JSON request a line in, an answer a line out.

MAVSDK reads for a vehicle it has met: each autopilot sends one HEARTBEAT over `raw://`.
"""

import json
import math
import sys
from typing import Any

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.mission_raw import MissionRaw
from pymavlink.dialects.v20 import common

AUTOPILOTS = {"ardupilot": common.MAV_AUTOPILOT_ARDUPILOTMEGA, "px4": common.MAV_AUTOPILOT_PX4}
FIELDS = ("seq", "frame", "command", "current", "autocontinue", "param1", "param2", "param3", "param4", "x", "y", "z")


def meet(autopilot: str) -> tuple[Mavsdk, MissionRaw]:
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    mavsdk.add_any_connection("raw://")
    vehicle = common.MAVLink(None, srcSystem=1, srcComponent=1)
    heartbeat = vehicle.heartbeat_encode(common.MAV_TYPE_QUADROTOR, AUTOPILOTS[autopilot], 0, 0, 3)
    mavsdk.pass_received_raw_bytes(heartbeat.pack(vehicle))
    system = mavsdk.first_autopilot(10.0)
    return mavsdk, MissionRaw(system)


def answer(plugin: MissionRaw, kind: str, text: str) -> dict[str, Any]:
    read = {
        "plan": plugin.import_qgroundcontrol_mission_from_string,
        "waypoints": plugin.import_mission_planner_mission_from_string,
    }[kind]
    try:
        data = read(text)
    except Exception as error:
        return {"error": str(error)}
    lists = {"mission": data.mission_items, "fence": data.geofence_items, "rally": data.rally_items}
    return {
        name: [[_plain(getattr(item, field)) for field in FIELDS] for item in items] for name, items in lists.items()
    }


def _plain(value: float) -> float | None:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def main() -> None:
    met = {name: meet(name) for name in AUTOPILOTS}
    print(json.dumps({"ready": sorted(met)}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        print(json.dumps(answer(met[request["autopilot"]][1], request["kind"], request["text"])), flush=True)
    for mavsdk, plugin in met.values():
        plugin.destroy()
        mavsdk.destroy()


if __name__ == "__main__":
    main()
