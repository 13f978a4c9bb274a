from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, field_validator, model_validator

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.wind_levels import ForecastWind
from ipoa_mission.rules import expect_ignorable
from ipoa_mission.scenario.section import NotNegative, Positive, Section, existing_file
from ipoa_mission.wind import MAX_LEVELS, Wind


class SafetySection(Section):
    """Confidence in the clearance."""

    confidence: Annotated[float, Field(ge=0.5, le=0.999, strict=True)] | Literal["nominal"] = 0.99
    """Share of flights that keep the required clearance, by this autopilot's lateral deviation from its predicted path.
    `nominal`: clearance of the predicted path, as in the paper."""
    returns: Literal["planned", "warn"] = "warn"
    """`planned`: RTL, SmartRTL and holding are clear from every second of the flight. Another path, a return altitude
    or rally points achieve it; otherwise the flight is refused. LAND must be clear too where `vehicle.parameters` make
    a failsafe land although it could return. `warn`: an RTL without clearance is only a warning. `ipoa-mission new`
    writes `planned`."""
    ignore: tuple[str, ...] = ()
    """Codes of findings to ignore. Findings that may mean a crash are reported anyway."""

    @field_validator("ignore")
    @classmethod
    def _may_be_ignored(cls, codes: tuple[str, ...]) -> tuple[str, ...]:
        try:
            expect_ignorable(codes)
        except BadInput as error:
            raise ValueError(str(error)) from error
        return codes

    @property
    def ignored(self) -> frozenset[str]:
        return frozenset(self.ignore)

    @property
    def chance(self) -> float | None:
        """Return the accepted probability of less clearance."""
        return None if self.confidence == "nominal" else 1.0 - self.confidence


class WindSection(Section):
    """Wind of the flight, used for the route, the deviation bound and the times."""

    speed: NotNegative = 0.0
    """Speed above `gradient_height` [m/s]."""
    from_deg: Annotated[float, Field(ge=-360, le=360, strict=True)] = 0.0
    """Direction that it blows from, clockwise from north."""
    exponent: NotNegative = 0.0
    """Wind shear: speed × (height / `gradient_height`)^exponent below `gradient_height`."""
    gradient_height: NotNegative = 0.0
    """Height up to which it grows [m above home]."""
    heights: tuple[NotNegative, ...] = ()
    """A profile in place of the numbers above: two to eight ascending heights above home [m]. Wind is linear between
    them and constant beyond them."""
    speeds: tuple[NotNegative, ...] = ()
    """Speed at each of `heights` [m/s]."""
    directions: tuple[Annotated[float, Field(ge=-360, le=360, strict=True)], ...] = ()
    """Direction that it blows from at each of `heights`, clockwise from north."""
    file: Annotated[Path | None, existing_file("a forecast of winds")] = None
    """A weather forecast (NetCDF or GRIB, extra `wind`) in place of all numbers: the wind at home from `time` on. Its
    deviations over members and hours are the spread. Without a CF standard name of heights, the datum with the stronger
    wind counts."""
    spread: NotNegative = 0.0
    """Greatest deviation of the wind, gusts included [m/s]. It counts for the deviation bound and the greatest energy.
    A flight that it would push off its path is refused."""
    _air: Wind | None = PrivateAttr(None)
    _forecast: ForecastWind | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _one_wind(self) -> "WindSection":
        if self.file is not None and self.model_fields_set != {"file"}:
            raise ValueError("expected either a file, or numbers")
        numbers = {len(self.heights), len(self.speeds), len(self.directions)}
        if self.exponent and not self.gradient_height:
            raise ValueError("expected a gradient_height above 0 with the exponent, which has no effect without one")
        if numbers == {0}:
            return self
        if len(numbers) > 1 or not 2 <= len(self.heights) <= MAX_LEVELS:
            raise ValueError(f"expected as many speeds and directions as heights, two to {MAX_LEVELS}")
        if any(above <= below for below, above in pairwise(self.heights)):
            raise ValueError("expected ascending heights")
        if self.speed or self.exponent or self.gradient_height:
            raise ValueError("expected either speed, exponent and gradient_height, or heights, speeds and directions")
        return self

    def air(self) -> Wind:
        if self._air is not None:
            return self._air
        if self.file is not None:
            words = "expected a scenario from read_scenario or Scenario.from_dict, which read the file"
            raise BadInput(words, place="wind.file")
        if self.heights:
            return Wind.of_profile(self.heights, self.speeds, self.directions, self.spread)
        return Wind(self.speed, self.from_deg, self.exponent, self.gradient_height, self.spread)

    @classmethod
    def of(cls, wind: Wind, forecast: ForecastWind | None = None, file: Path | None = None) -> "WindSection":
        section = cls.model_construct(file=file)
        section._air = wind
        section._forecast = forecast
        return section

    @property
    def forecast(self) -> ForecastWind | None:
        return self._forecast

    @property
    def strongest(self) -> float:
        return self.air().strongest


class RouteSection(Section):
    """Waypoints of the curve, and the end of the mission."""

    mode: Literal["even", "corridor", "spline", "fastest"] = "fastest"
    """`even`: a waypoint every `spacing` meters. `corridor`: fewest waypoints with legs within `tolerance`. `spline`:
    spline waypoints every `spacing` meters (ArduPilot). `fastest`: least flight time with a lateral deviation within
    `tolerance`. Of routes within half a per cent it takes the greatest clearance."""
    spacing: Positive = 10.0
    """Greatest distance between waypoints of `even` and `spline` [m]."""
    tolerance: Positive = 4.0
    """Greatest distance of the legs (`corridor`), or lateral deviation of the predicted path (`fastest`), from the
    curve [m]."""
    ending: Literal["rtl", "land"] = "rtl"
    """`rtl`: return to home and land, after a climb over the goal if needed for clearance. `land`: land at the goal."""


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
    max_climb_angle_deg: Annotated[float, Field(gt=0, le=90, strict=True)] | None = None
    """Default: no limit."""
    max_descent_angle_deg: Annotated[float, Field(gt=0, le=90, strict=True)] | None = None
    """Default: no limit."""


class OptimizerSection(Section):
    """The search algorithm by name, and its settings (population, iterations, ...)."""

    model_config = ConfigDict(extra="allow")

    name: str = "ipoa"
    """Name of the algorithm; other keys are its own settings."""

    @property
    def settings(self) -> dict[str, Any]:
        return dict(self.model_extra or {})
