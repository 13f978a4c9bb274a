"""The defaults of both autopilots, and the names that the models know."""

from collections.abc import Mapping
from types import MappingProxyType

from ipoa_mission.autopilots.ardupilot import ARDUCOPTER_DEFAULTS
from ipoa_mission.autopilots.px4 import PX4_DEFAULTS
from ipoa_mission.autopilots.renamed import RENAMED
from ipoa_mission.autopilots.vehicle import Autopilot, Parameters

DEFAULT_PARAMETERS: Mapping[Autopilot, Parameters] = MappingProxyType(
    {Autopilot.ARDUPILOT: ARDUCOPTER_DEFAULTS, Autopilot.PX4: PX4_DEFAULTS}
)


def known_parameters() -> frozenset[str]:
    """The names of all parameters that the models of either autopilot use, old names and new ones."""
    return frozenset(name for names in (*DEFAULT_PARAMETERS.values(), RENAMED) for name in names)
