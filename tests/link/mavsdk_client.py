"""MAVSDK in a process of its own, through the backend; results as one line of JSON."""

import json
import signal
import sys
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import upload
from ipoa_mission.link.dialogue import Cancelled, NoAnswer
from ipoa_mission.link.mavsdk_backend import MavsdkVehicle, connect
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.upload import Unflyable
from ipoa_mission.mission.items import FenceCircle, Mission, return_to_launch, takeoff, waypoint
from tests.quick_link import hurry

HOME = Geodetic(47.4, 8.5, 400.0)


def stored_count(vehicle: MavsdkVehicle) -> int:
    """Count the items of its mission; after a cancel PX4 waits for 5 s."""
    for _ in range(3):
        try:
            return len(vehicle.download_items(MissionType.MISSION))
        except NoAnswer:
            continue
    raise NoAnswer("the mission cannot be read any more")


def spoil(vehicle: MavsdkVehicle) -> dict[str, object]:
    """Try a mission that cannot be flown, and one that is cancelled."""
    results: dict[str, object] = {}
    try:
        vehicle.upload(Mission(HOME, (takeoff(HOME, 1.0),), Autopilot.PX4), checked=False)
    except Unflyable as error:
        results["unflyable"] = str(error)
    many = [waypoint(Geodetic(47.4 + 1e-5 * n, 8.5), 30.0) for n in range(500)]
    spell = vehicle._mavsdk_item

    def press(seq: int, *rest: Any) -> Any:
        if seq == len(many):
            signal.raise_signal(signal.SIGINT)
        return spell(seq, *rest)

    vehicle._mavsdk_item = press  # type: ignore[assignment,method-assign]
    try:
        vehicle.upload(Mission(HOME, (takeoff(HOME, 20.0), *many), Autopilot.PX4))
    except Cancelled as cancelled:
        results["cancelled_as_told"] = stored_count(vehicle) == (1 if "keeps" in str(cancelled) else len(many) + 1)
    vehicle._mavsdk_item = spell  # type: ignore[method-assign]
    return results


def main(url: str) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    hurry()
    upload.VERDICT_S = 0.3
    legs = [waypoint(Geodetic(47.4 + 0.0002 * n, 8.5), 30.0) for n in (1, 2, 3)]
    fence, rally = (FenceCircle((47.4, 8.5), 500.0),), (Geodetic(47.4005, 8.5, 25.0),)
    with connect(url) as vehicle:
        assert isinstance(vehicle, MavsdkVehicle)
        results = spoil(vehicle) if vehicle.autopilot is Autopilot.PX4 else {}
        items = (takeoff(HOME, 20.0), *legs, return_to_launch())
        sent = Mission(HOME, items, vehicle.autopilot, fence=fence, rally=rally)
        vehicle.upload(sent)
        read = vehicle.download()
        vehicle.prepare()
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
            **results,
        }
    sys.stdout.write("RESULT " + json.dumps(result) + "\n")


main(sys.argv[1])
