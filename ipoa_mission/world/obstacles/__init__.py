"""Obstacles: the interface, and each kind."""

from ipoa_mission.world.obstacles.kinds import Cylinder, Prism, RoundZone, Sphere, Zone, straightened
from ipoa_mission.world.obstacles.obstacle import Obstacle

__all__ = ["Cylinder", "Obstacle", "Prism", "RoundZone", "Sphere", "Zone", "straightened"]
