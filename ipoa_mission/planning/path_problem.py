from dataclasses import dataclass, field, fields, replace
from typing import TypeAlias

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points
from ipoa_mission.scenario.flight_sections import CostSection, OptimizerSection, PlanningSection
from ipoa_mission.scenario.model import Scenario
from ipoa_mission.scenario.path_limits import Limits
from ipoa_mission.world.airspace import Airspace


@dataclass(frozen=True, eq=False)
class PathProblem:
    """A path to plan, from arrays and shapes: `plan_path` takes it like a scenario.

    Attributes:
        airspace: bounds, ground and obstacles.
        limits: limits of the path.
        places: start, places to pass and goal, (k, 3) [m].
        radius: of the hull [m]: threats are measured from it, and `limits.obstacle_distance` includes it.
        cost: as `[cost]` of a scenario.
        planning: as `[planning]`.
        optimizer: as `[optimizer]`.

    Raises:
        BadInput: `places` are not two or more points of three numbers.

    Example:
        >>> from ipoa_mission import Airspace, Bounds, Flat, Limits, PathProblem, Sphere, plan_path
        >>> ball = Sphere("ball", (50.0, 0.0, 30.0), 10.0)
        >>> airspace = Airspace(Bounds((0.0, -50.0, 0.0), (100.0, 50.0, 60.0)), Flat(), (ball,))
        >>> limits = Limits(obstacle_distance=2.0, height_above_ground=5.0)
        >>> plan_path(PathProblem(airspace, limits, [[5.0, 0.0, 30.0], [95.0, 0.0, 30.0]])).proof.is_proved
        True
    """

    airspace: Airspace
    limits: Limits
    places: Points
    radius: float = 0.0
    cost: CostSection = field(default_factory=CostSection)
    planning: PlanningSection = field(default_factory=PlanningSection)
    optimizer: OptimizerSection = field(default_factory=OptimizerSection)

    def __post_init__(self) -> None:
        try:
            places = np.array(self.places, dtype=np.float64)
        except (TypeError, ValueError):
            places = np.empty(0)
        if places.ndim != 2 or places.shape[1] != 3 or len(places) < 2 or not np.isfinite(places).all():
            words = "expected two or more points (east, north, up), finite numbers, as an array (k, 3)"
            raise BadInput(words, place="places")
        object.__setattr__(self, "places", places)

    def tightened(self, above: float, below: float = 0.0, airspace: Airspace | None = None) -> "PathProblem":
        """Return the problem with `above` [m] more above the ground, `below` under the ceiling, and this `airspace`."""
        limits = self.limits.tightened(above, below, self.places, self.airspace)
        return replace(self, limits=limits, airspace=airspace or self.airspace)


PathTask: TypeAlias = PathProblem | Scenario


def problem_of(task: PathTask) -> PathProblem:
    return PathProblem(**{field.name: getattr(task, field.name) for field in fields(PathProblem)})


def place_names(places: Points) -> list[str]:
    return ["start", *(f"via[{n}]" for n in range(len(places) - 2)), "goal"]
