"""What of a scenario its world is made from, for those who make it."""

from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.scenario.map_sections import MapSection
from ipoa_mission.scenario.obstacles import ObstacleSection
from ipoa_mission.scenario.place_sections import BoundsSection, FenceSection, Place, TerrainSection
from ipoa_mission.world.frame import LocalFrame

#: Where a survey is flown, corners (n, 2), and how high above the ground at most [m]; without one, nowhere.
Reach: TypeAlias = tuple[NDArray[np.float64], float]
NO_REACH: Reach = (np.zeros((0, 2)), 0.0)


class Layout(Protocol):
    """What of a scenario its world is made from."""

    start: Place
    goal: Place
    via: tuple[Place, ...]
    bounds: BoundsSection
    terrain: TerrainSection
    obstacles: tuple[ObstacleSection, ...]
    maps: tuple[MapSection, ...]
    fence: tuple[FenceSection, ...]

    @property
    def frame(self) -> LocalFrame:
        """The local frame at home."""
        ...

    @property
    def unix_s(self) -> float | None:
        """When it takes off [s since 1970]."""
        ...

    @property
    def survey_reach(self) -> Reach:
        """Where a survey is flown, and how high above the ground at most."""
        ...
