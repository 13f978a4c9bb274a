from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot
from ipoa_mission.errors import BadInput, OptionConflict
from ipoa_mission.scenario import read_scenario
from ipoa_mission.simulator.conditions import USUAL, Conditions
from ipoa_mission.world.frame import Geodetic

ZURICH = (47.397742, 8.545594, 488.0)


@dataclass(frozen=True)
class MockSetup:
    autopilot: Autopilot
    home: Geodetic
    parameters: Mapping[str, float]
    conditions: Conditions = USUAL


def mock_setup(
    scenario: Path | None,
    home: tuple[float, float, float] | None,
    autopilot: Autopilot | None,
    parameters: Mapping[str, float],
) -> MockSetup:
    """Return the scenario's values, replaced by options. Raises BadInput."""
    if home is not None and not (-90 <= home[0] <= 90 and -180 <= home[1] <= 180):
        raise BadInput(f"expected latitude and longitude in degrees, not {home[0]} {home[1]}", place="--home")
    if scenario is None:
        return MockSetup(autopilot or default_autopilot(), Geodetic(*(home or ZURICH)), parameters)
    if home is not None:
        raise OptionConflict("expected without --scenario, which defines home", place="--home")
    world = read_scenario(scenario)
    flies = autopilot or world.vehicle.autopilot
    own = world.vehicle if flies is world.vehicle.autopilot else None
    values = flies.book.overridden(world.vehicle.parameters, parameters) if own else parameters
    about = (own.learned, own.version) if own else ()
    conditions = Conditions(world.wind.air(), world.ground, *about)
    return MockSetup(flies, world.home.geodetic(), values, conditions)
