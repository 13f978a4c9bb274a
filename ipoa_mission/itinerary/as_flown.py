"""What an item leaves open, filled in as its firmware does: "here" and "as high as now".

ArduCopter takes latitude and longitude 0 for the place, and altitude 0 for the height, of the item before
(ArduPilot's ModeAuto, since 2014). PX4 flies to what it is given; a null place of its take-off and landing is "here".
"""

import math
from dataclasses import replace

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import FLOWN_TO, Command, Frame, plain_frame
from ipoa_mission.items import Item, Mission

#: What an altitude of 0 is for: the ground is below a landing, and a take-off climbs to it.
TO_THE_GROUND = frozenset({Command.NAV_TAKEOFF, Command.NAV_LAND})


def is_here(item: Item, autopilot: Autopilot) -> bool:
    """Whether ArduCopter does this item where it is: it names latitude 0, longitude 0."""
    return (
        autopilot is Autopilot.ARDUPILOT
        and item.command in FLOWN_TO
        and item.frame != Frame.MISSION
        and (item.latitude_deg, item.longitude_deg) == (0.0, 0.0)
    )


def is_as_high_as_now(item: Item, autopilot: Autopilot) -> bool:
    """Whether ArduCopter keeps its height on the way to this item: it names altitude 0, in whatever frame."""
    return (
        autopilot is Autopilot.ARDUPILOT
        and item.command in FLOWN_TO - TO_THE_GROUND
        and item.frame != Frame.MISSION
        and item.altitude == 0.0
    )


def as_flown(mission: Mission) -> Mission:
    """The mission with a place and a height in every item that is flown to, items taken in their order.

    >>> from ipoa_mission.items import takeoff, waypoint
    >>> from ipoa_mission.world.frame import Geodetic
    >>> home, there = Geodetic(47.397742, 8.545594, 488.0), Geodetic(47.398642, 8.545594)
    >>> items = (takeoff(home, 15.0), waypoint(there, 0.0))
    >>> as_flown(Mission(home, items, Autopilot.ARDUPILOT)).items[1].altitude
    15.0
    """
    if mission.autopilot is not Autopilot.ARDUPILOT:
        return mission
    place = (mission.home.latitude_deg, mission.home.longitude_deg)
    height, frame = 0.0, int(Frame.GLOBAL_RELATIVE_ALT)
    items: list[Item] = []
    for item in mission.items:
        if is_as_high_as_now(item, mission.autopilot):
            item = replace(item, altitude=height, frame=frame)
        if is_here(item, mission.autopilot) and item.command not in TO_THE_GROUND:
            item = replace(item, latitude_deg=place[0], longitude_deg=place[1])
        items.append(item)
        if item.command in FLOWN_TO and item.frame != Frame.MISSION:
            if item.command != Command.NAV_TAKEOFF and item.has_position:
                place = (item.latitude_deg, item.longitude_deg)  # a take-off climbs where the vehicle stands
            if math.isfinite(item.altitude) and item.command != Command.NAV_LAND:
                height, frame = item.altitude, plain_frame(item.frame)
    return replace(mission, items=tuple(items))
