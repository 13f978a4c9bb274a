"""What all kinds of scans have: corners on the Earth, and a camera that is triggered by distance."""

import numpy as np

from ipoa_mission.geometry import Points
from ipoa_mission.mission.commands import Command, Frame
from ipoa_mission.mission.document import Node
from ipoa_mission.mission.items import Item
from ipoa_mission.world.sphere import SphericalPlane

FARTHEST = 100_000.0  # any length of a scan [m]


def length_of(node: Node) -> float:
    """A length; one that no vehicle could fly is refused, before it is multiplied with others."""
    length = node.number("metres")
    if abs(length) > FARTHEST:
        raise node.wrong(f"metres, {FARTHEST:.0f} at most")
    return length


def corners_of(node: Node, least: int) -> Points:
    """Latitude and longitude, (n, 2)."""
    places = [each.array(2, "numbers (latitude, longitude)") for each in node.array()]
    corners = np.array([[value.number("degrees") for value in place] for place in places]).reshape(-1, 2)
    if len(corners) < least or (np.abs(corners) > (90.0, 180.0)).any():
        raise node.wrong(f"{least} corners or more, as latitude and longitude in degrees")
    if np.ptp(corners, axis=0).max() > 1.0:
        raise node.wrong("corners within a degree of each other")
    return corners


def plane_about(corners: Points) -> SphericalPlane:
    """QGroundControl's plane about the first of the corners (n, 2)."""
    return SphericalPlane(*corners[0].tolist())


def trigger(distance: float, at_once: bool = True) -> Item:
    """The camera's trigger, every so many metres; 0: no more; `at_once`: and now."""
    return Item(Command.DO_SET_CAM_TRIGG_DIST, Frame.MISSION, (distance, 0.0, float(at_once), 0.0))
