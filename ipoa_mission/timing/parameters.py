"""Which parameters the models of the two autopilots know."""

from ipoa_mission.timing import copter_parameters, px4_parameters
from ipoa_mission.vehicle import DEFAULT_PARAMETERS, RENAMED


def known_parameters() -> frozenset[str]:
    """The names of all parameters that the models of either autopilot use, old names and new ones."""
    further = (copter_parameters.FURTHER, RENAMED, px4_parameters.FURTHER)
    return frozenset(name for names in (*DEFAULT_PARAMETERS.values(), *further) for name in names)
