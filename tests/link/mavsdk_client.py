"""MAVSDK in a process of its own, through the backend; results as one line of JSON."""

import json
import signal
import sys
from collections.abc import Sequence

import mavsdk
from mavsdk.plugins import mission_raw

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link import upload
from ipoa_mission.link.dialogue import Cancelled, NoAnswer
from ipoa_mission.link.mavsdk_backend import MavsdkVehicle, connect
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.upload import Unflyable
from ipoa_mission.link.wire import coordinate
from ipoa_mission.mission.items import FenceCircle, Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.stored_mission import to_wire
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
        vehicle.upload(Mission(HOME, (takeoff(HOME, 0.0),), Autopilot.PX4), checked=False)
    except Unflyable as error:
        results["unflyable"] = str(error)
    many = [waypoint(Geodetic(47.4 + 1e-5 * n, 8.5), 30.0) for n in range(500)]

    def press(share: float, words: str) -> None:
        if words == "400 of 501":
            signal.raise_signal(signal.SIGINT)

    try:
        vehicle.upload(Mission(HOME, (takeoff(HOME, 20.0), *many), Autopilot.PX4), press)
    except Cancelled as cancelled:
        results["cancelled_as_told"] = stored_count(vehicle) == (1 if "keeps" in str(cancelled) else len(many) + 1)
    return results


def transfer_by_mavsdk_alone(url: str, items: Sequence[Item]) -> bool:
    """Return whether its own transfers bring a mission to the vehicle and back."""
    instance = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    instance.add_any_connection(url.replace(":", "://", 1))
    system = instance.first_autopilot(10.0)
    raw = mission_raw.MissionRaw(system)
    rows = []
    for seq, item in enumerate(items):
        place = (coordinate(item.latitude_deg, item.frame), coordinate(item.longitude_deg, item.frame))
        numbers = (seq, item.frame, item.command, int(seq == 0), int(item.autocontinue), *item.params)
        rows.append(mission_raw.MissionItem(*numbers, *place, item.altitude, 0))
    raw.upload_mission(rows)
    stored = [(row.command, row.x, row.y) for row in raw.download_mission()]
    instance.destroy()
    first = len(stored) - len(items[1:])  # ArduPilot's home is its own
    return stored[first:] == [(row.command, row.x, row.y) for row in rows[1:]]


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
    result["by_mavsdk_alone"] = transfer_by_mavsdk_alone(url, to_wire(sent))
    sys.stdout.write("RESULT " + json.dumps(result) + "\n")


main(sys.argv[1])
