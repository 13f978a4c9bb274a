"""MAVSDK in a process of its own, through the backend: a whole session, its results as one line of JSON."""

import json
import sys

from ipoa_mission.link.mavsdk_backend import connect
from ipoa_mission.mission.items import FenceCircle, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.world.frame import Geodetic

HOME = Geodetic(47.4, 8.5, 400.0)


def main(url: str) -> None:
    legs = [waypoint(Geodetic(47.4 + 0.0002 * n, 8.5), 30.0) for n in (1, 2, 3)]
    fence, rally = (FenceCircle((47.4, 8.5), 500.0),), (Geodetic(47.4005, 8.5, 25.0),)
    with connect(url) as vehicle:
        items = (takeoff(HOME, 20.0), *legs, return_to_launch())
        sent = Mission(HOME, items, vehicle.autopilot, fence=fence, rally=rally)
        vehicle.upload(sent)
        read = vehicle.download()
        vehicle.arm()
        vehicle.start()
        record = vehicle.watch()
        result = {
            "autopilot": str(vehicle.autopilot),
            "items": len(read.items),
            "fence_is_kept": read.fence == fence,
            "rally_is_kept": read.rally == rally,
            "reached": sorted(record.item_reached_s),
            "completed": record.completed,
            "samples": len(record.path),
        }
    sys.stdout.write("RESULT " + json.dumps(result) + "\n")


main(sys.argv[1])
