"""A MAVSDK MissionRawServer in a process of its own: prints each mission as JSON."""

import json
import sys
import time
from typing import Any

import mavsdk
from mavsdk.plugins.mission_raw_server import MissionRawServer


def main(url: str, seconds: float) -> None:
    instance = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.AUTOPILOT))
    server = MissionRawServer(instance.server_component_by_type(mavsdk.ComponentType.AUTOPILOT))

    def show(result: Any, plan: Any, _: object) -> None:
        items = [[i.seq, i.frame, i.command, i.param1, i.param2, i.x, i.y, i.z] for i in plan.mission_items]
        sys.stderr.write(json.dumps({"result": result.name, "items": items}) + "\n")
        sys.stderr.flush()

    server.subscribe_incoming_mission(show)
    assert instance.add_any_connection(url).name == "SUCCESS"
    time.sleep(seconds)
    instance.destroy()


main(sys.argv[1], float(sys.argv[2]))
