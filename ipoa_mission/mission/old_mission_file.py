"""QGroundControl's `.mission` of before 2016: the items of a mission in JSON, without fence or rally points."""

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.items import Mission
from ipoa_mission.mission.document import Node
from ipoa_mission.mission.firmware import settle_frames
from ipoa_mission.mission.plan_file import autopilot_in, read_item
from ipoa_mission.world.frame import Geodetic


def is_old_mission(document: Node) -> bool:
    """Whether a JSON document is such a file: it says neither its type nor has it a mission apart."""
    return isinstance(document.value, dict) and "MAV_AUTOPILOT" in document.value and "items" in document.value


def parse_old_mission(document: Node, autopilot: Autopilot | None = None) -> Mission:
    """The mission in such a document; a jump counts the items from 1, as in the file.

    Raises:
        BadInput: the message names the place.
    """
    autopilot = autopilot or autopilot_in(document["MAV_AUTOPILOT"])
    latitude, longitude, altitude = (
        node.number("a number") for node in document["plannedHomePosition"]["coordinate"].array(3, "numbers")
    )
    items = [read_item(node).item for node in document["items"].array()]
    if (complex_items := document.get("complexItems")) and complex_items.value:
        complex_items.note("surveys of this format are not read")
    home = Geodetic(latitude, longitude, altitude)
    return Mission(home, settle_frames(items, autopilot), autopilot, findings=tuple(document.findings))
