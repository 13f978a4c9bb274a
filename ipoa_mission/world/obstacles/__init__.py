"""Kinds of obstacles, one a file."""

from ipoa_mission.world.obstacles.cylinder import Cylinder, RoundZone
from ipoa_mission.world.obstacles.nearest import straightened
from ipoa_mission.world.obstacles.obstacle import Obstacle
from ipoa_mission.world.obstacles.prism import Prism, Zone, box
from ipoa_mission.world.obstacles.sphere import Sphere

__all__ = ["Cylinder", "Obstacle", "Prism", "RoundZone", "Sphere", "Zone", "box", "straightened"]
