"""List the kernels to compile, with example arguments for their types."""

import importlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ipoa_mission.compiled import compiled, records
from ipoa_mission.planning.obstacle_grid import (
    ControlPointShifts,
    NodeBasis,
    Nodes,
    ObstacleGrid,
    PolishInputs,
    Raster,
    Rules,
    Smoothing,
)
from ipoa_mission.survey.times import LegTimeTable, Ways
from ipoa_mission.vehicles.arducopter.braking import braking_displacement
from ipoa_mission.vehicles.arducopter.dynamics.motion import ARDUPILOT_SIMULATOR, NO_LEG, CopterLeg, State, tuning
from ipoa_mission.vehicles.arducopter.dynamics.steps import fly_leg
from ipoa_mission.vehicles.arducopter.limits import copter_limits
from ipoa_mission.vehicles.px4_multicopter.dynamics.flight import at_start, fly
from ipoa_mission.vehicles.px4_multicopter.dynamics.state import Motion, SimulationConstants
from ipoa_mission.wind import CALM

MODULES = {
    "path_costs": "planning._kernels",
    "slack_and_threat": "planning._kernels",
    "centered": "planning._kernels",
    "minimize_path_model": "planning._path_model",
    "lattice_costs": "planning._kernels",
    "solve_banded": "planning.banded",
    "extreme": "world._analytic",
    "least_heights": "world._analytic",
    "fewest_legs": "routing._corridor",
    "far_points": "routing._corridor",
    "nearest": "world.obstacles._prism",
    "balance": "world._polygon",
    "distances": "world._polygon",
    "path_seconds": "survey._kernels",
    "straight_ways": "survey._kernels",
    "ways_between": "survey._kernels",
    "search_order": "survey._kernels",
}


class Kernel(NamedTuple):
    name: str
    dispatcher: Any
    arguments: tuple[Any, ...]


def part(number: int) -> list[Kernel]:
    """Return the kernels of flying and surveying, or all others: each is half of the work."""
    flying = ("ipoa_mission.survey.", "ipoa_mission.vehicles.")
    return [kernel for kernel in kernels() if kernel.name.startswith(flying) == (number == 1)]


def _numbers(dimensions: int, kind: type = np.float64) -> Any:
    return np.zeros((1,) * dimensions, kind)


def kernels() -> Iterator[Kernel]:
    raster = Raster(0.0, 0.0, 1.0, 2, 2)
    lists, kinds = (_numbers(1, np.int32),) * 2, _numbers(1, np.int8)
    low_zones = _numbers(2)
    grid = ObstacleGrid(
        raster, *lists, _numbers(1), _numbers(2), kinds, _numbers(2), _numbers(2), raster, _numbers(2),
        _numbers(1), _numbers(1), 1.0, low_zones,
    )  # fmt: skip
    rules = Rules._make([*[1.0] * 11, False, 1.0, 1.0])
    nodes = Nodes(_numbers(3), _numbers(3), _numbers(2), _numbers(1))
    smoothing, basis = Smoothing._make([1.0] * len(Smoothing._fields)), NodeBasis(_numbers(1, np.int64), _numbers(3))
    shifts = ControlPointShifts(1, 0, *(_numbers(1, np.int64),) * 2, _numbers(1))
    inputs = PolishInputs(basis, shifts, 1.0)
    ways = Ways(_numbers(2), *(_numbers(1, np.int64),) * 2)
    leg_times = LegTimeTable(_numbers(1), _numbers(2), 1.0, 1.0)
    examples = {
        "path_costs": (_numbers(3), grid, rules),
        "slack_and_threat": (_numbers(2), grid, rules),
        "centered": (_numbers(2), _numbers(3), (_numbers(1), _numbers(1), 1.0), grid, rules),
        "minimize_path_model": (_numbers(2), _numbers(2), inputs, grid, rules, smoothing, 1, 1.0),
        "solve_banded": (_numbers(2), _numbers(1)),
        "extreme": (_numbers(2), (1.0,) * 8, _numbers(2), True, 1.0),
        "least_heights": (_numbers(3), (1.0,) * 8, _numbers(2), 1.0),
        "fewest_legs": (_numbers(2), _numbers(3), _numbers(1, np.int64), 1.0),
        "far_points": (*(_numbers(2),) * 2, 1.0),
        "nearest": (_numbers(2), _numbers(2), 0.0, 1.0, _numbers(1), _numbers(1)),
        "balance": (*(_numbers(2),) * 3, *(_numbers(1),) * 2, True),
        "distances": (_numbers(2),) * 3,
        "path_seconds": (leg_times, _numbers(2)),
        "straight_ways": (_numbers(2),) * 5,
        "ways_between": (leg_times, *(_numbers(2),) * 2, *(ways,) * 2, _numbers(2), 1.0),
        "search_order": (_numbers(2), _numbers(1), 0),
        "lattice_costs": (nodes, (_numbers(2, np.int64), _numbers(1)), True, (0, 0, 1.0), grid, rules),
    }
    for name, arguments in examples.items():
        module = f"ipoa_mission.{MODULES[name]}"
        yield Kernel(f"{module}.{name}", getattr(importlib.import_module(module), name), arguments)
    leg, still = records([NO_LEG], CopterLeg), tuning(copter_limits({}), ARDUPILOT_SIMULATOR, CALM)
    flown = {
        fly_leg: (records([State()], State), leg, leg, leg, still, _numbers(2)),
        braking_displacement: (*(_numbers(1, np.complex128),) * 2, 1.0, 1.0),
        fly: (records([], Motion), records([], SimulationConstants), at_start(0.0, 1), 1.0, 0),
    }
    for function, given in flown.items():
        yield Kernel(f"{function.__module__}.{function.__name__}", compiled(function), given)
