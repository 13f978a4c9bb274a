"""What the planner is asked: an airspace, limits, places to pass, and how a path is judged; no file is needed."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ipoa_mission.errors import BadInput
from ipoa_mission.geometry import Points
from ipoa_mission.scenario.limits import Limits
from ipoa_mission.scenario.model import CostSection, OptimizerSection, PlanningSection
from ipoa_mission.world.airspace import Airspace


class PathTask(Protocol):
    """What the planner looks at: a `PathProblem`, or a `Scenario`, which has the same and more."""

    @property
    def airspace(self) -> Airspace:
        """Bounds, terrain and obstacles."""
        ...

    @property
    def limits(self) -> Limits:
        """What the path must keep."""
        ...

    @property
    def places(self) -> Points:
        """Start, places to pass, goal, (k, 3) [m]."""
        ...

    @property
    def radius(self) -> float:
        """Radius of the vehicle's hull [m]."""
        ...

    @property
    def cost(self) -> CostSection:
        """How a path is judged."""
        ...

    @property
    def planning(self) -> PlanningSection:
        """How the path is sought."""
        ...

    @property
    def optimizer(self) -> OptimizerSection:
        """The search algorithm."""
        ...


@dataclass(frozen=True, eq=False)
class PathProblem:
    """A path to be planned, from arrays and shapes: `plan_path` takes it as it takes a scenario.

    Attributes:
        airspace: bounds, ground and obstacles.
        limits: what the path must keep.
        places: start, places to pass and goal, two at least, (k, 3) [m].
        radius: of the vehicle's hull [m]: the threat of obstacles is counted from it, and it is part of
            `limits.obstacle_distance`.
        cost: how a path is judged, as `[cost]` of a scenario.
        planning: how it is sought, as `[planning]`.
        optimizer: the search algorithm, as `[optimizer]`.

    Raises:
        BadInput: `places` are not two or more points of three numbers.

    Example:
        >>> from ipoa_mission import Airspace, Bounds, Flat, Limits, PathProblem, Sphere, plan_path
        >>> ball = Sphere("ball", (50.0, 0.0, 30.0), 10.0)
        >>> airspace = Airspace(Bounds((0.0, -50.0, 0.0), (100.0, 50.0, 60.0)), Flat(), (ball,))
        >>> limits = Limits(obstacle_distance=2.0, height_above_ground=5.0)
        >>> plan_path(PathProblem(airspace, limits, [[5.0, 0.0, 30.0], [95.0, 0.0, 30.0]])).proof.holds
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
        """Take lists as arrays.

        Raises:
            BadInput: the places are not two or more points of three numbers.
        """
        try:
            places = np.array(self.places, dtype=np.float64)
        except (TypeError, ValueError):
            places = np.empty(0)
        if places.ndim != 2 or places.shape[1] != 3 or len(places) < 2 or not np.isfinite(places).all():
            raise BadInput("places: expected two or more points (east, north, up), finite numbers, as an array (k, 3)")
        object.__setattr__(self, "places", places)
