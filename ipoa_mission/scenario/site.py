from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.scenario.map_sections import MapSection
from ipoa_mission.scenario.obstacles import ObstacleSection
from ipoa_mission.scenario.place_sections import BoundsSection, FenceSection, Place, TerrainSection
from ipoa_mission.world.frame import LocalFrame

# corners (n, 2), greatest height above ground [m]
Reach: TypeAlias = tuple[NDArray[np.float64], float]
NO_REACH: Reach = (np.zeros((0, 2)), 0.0)


class Layout(Protocol):
    start: Place
    goal: Place
    via: tuple[Place, ...]
    bounds: BoundsSection
    terrain: TerrainSection
    obstacles: tuple[ObstacleSection, ...]
    maps: tuple[MapSection, ...]
    fence: tuple[FenceSection, ...]

    @property
    def frame(self) -> LocalFrame: ...

    @property
    def unix_s(self) -> float | None:
        """Return seconds since 1970."""
        ...

    @property
    def survey_reach(self) -> Reach: ...
