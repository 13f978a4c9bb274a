"""A mission as it is flown in the world of a scenario: by its vehicle, over its ground."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipoa_mission.items import Mission
from ipoa_mission.timing.estimate import EARTH_RADIUS
from ipoa_mission.world.ground import LEVEL, Ground

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario


def flown_in(mission: Mission, scenario: "Scenario") -> Mission:
    """The mission over the scenario's ground, on a vehicle with those of its parameters that it does not name itself.

    What was learned of the vehicle comes with the mission, else with the scenario.

    Raises:
        BadInput: the mission is of another place than the scenario.
    """
    scenario.expect_here(mission.home)
    flown = mission.assuming(scenario.vehicle.autopilot_parameters())
    return replace(flown, ground=ground_of(scenario), vehicle=mission.vehicle or scenario.vehicle.learned)


def ground_of(scenario: "Scenario") -> Ground:
    """How high the ground is above home, as an autopilot counts: from where it stands, on a round Earth."""
    from ipoa_mission.scenario.places import FlatTerrain

    if isinstance(scenario.terrain, FlatTerrain):
        return LEVEL
    terrain = scenario.airspace.terrain
    return Ground(terrain, float(terrain.height(np.zeros((1, 2)))[0]), EARTH_RADIUS)
