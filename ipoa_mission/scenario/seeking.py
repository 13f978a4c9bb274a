from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, model_validator

from ipoa_mission.scenario.section import NotNegative, Positive, Section


class CostSection(Section):
    """The paper's cost, eqs. (4)-(10)."""

    omega: tuple[NotNegative, NotNegative, NotNegative] = (0.7, 0.15, 0.15)
    """Weights of length, turning and threat, with a sum of 1."""
    a1: NotNegative = 1.0
    """Weight of turning in the turning cost, eq. (8)."""
    a2: NotNegative = 1.0
    """Weight of changes in climb angle, eq. (8)."""
    lambda_obs: NotNegative = 10.0
    """Penalty coefficient of a near obstacle, eq. (9)."""
    d_safe: NotNegative = 5.0
    """Distance beyond which an obstacle is no threat [m], eq. (9)."""
    form: Literal["integral", "nodes"] = "integral"
    """`nodes`: the paper's sums over path nodes. `integral`: over arc length, independent of the number of nodes."""

    @model_validator(mode="after")
    def _weights_sum_to_one(self) -> "CostSection":
        if abs(sum(self.omega) - 1) > 1e-9:
            raise ValueError(f"omega: expected three weights that sum to 1, not to {sum(self.omega):g}")
        return self


class PlanningSection(Section):
    """The search for a path."""

    planner: Literal["default", "paper"] = "default"
    """`paper`: the algorithm as printed, in absolute coordinates, with one long search and no polish."""
    polish: bool = True
    """Refine the best paths found on the smooth problem."""
    encoding: Literal["absolute", "chord", "sine"] | None = None
    """Variables of the search. Default: the planner's own choice."""
    control_points: Annotated[int, Field(ge=2, le=60)] = 8
    """Inner control points of the cubic B-spline."""
    samples: Annotated[int, Field(ge=20, le=2000)] = 100
    """Nodes at which the search evaluates the curve."""
    min_height_above_ground: NotNegative | None = None
    """Default: safety distance plus the vehicle's radius [m]."""
    max_height_above_ground: Positive | None = None
    """Default: no limit [m]."""
    max_climb_angle_deg: Annotated[float, Field(gt=0, le=90)] | None = None
    """Default: no limit."""
    max_descent_angle_deg: Annotated[float, Field(gt=0, le=90)] | None = None
    """Default: no limit."""


class OptimizerSection(Section):
    """The search algorithm by name, and its settings (population, iterations, ...)."""

    model_config = ConfigDict(extra="allow")

    name: str = "ipoa"
    """Name of the algorithm; other keys are its own settings."""

    @property
    def settings(self) -> dict[str, Any]:
        return dict(self.model_extra or {})
