"""The wind in the scenario: one speed and direction, or a profile by height."""

from itertools import pairwise
from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, model_validator

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.wind_levels import ForecastWind
from ipoa_mission.scenario.section import NotNegative, Section, beside
from ipoa_mission.wind import MOST_LEVELS, Wind


class WindSection(Section):
    """The wind that the flight is planned for: it counts for the choice of the route, the tube and the times."""

    speed: NotNegative = 0.0
    """How strong it is above `gradient_height` [m/s]."""
    from_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Where it blows from, clockwise from north."""
    exponent: NotNegative = 0.0
    """Below `gradient_height` it is (height / gradient_height)^exponent as strong."""
    gradient_height: NotNegative = 0.0
    """Up to where it grows [m above home]."""
    heights: tuple[NotNegative, ...] = ()
    """A profile in place of the numbers above: two to eight heights above home [m], upwards; between them the wind
    changes in straight lines, beyond them it is as at the nearest one."""
    speeds: tuple[NotNegative, ...] = ()
    """How strong it is at each of `heights` [m/s]."""
    directions: tuple[Annotated[float, Field(ge=-360, le=360)], ...] = ()
    """Where it blows from at each of `heights`, clockwise from north."""
    file: Annotated[Path | None, beside("a forecast of winds")] = None
    """A weather forecast (NetCDF or GRIB, extra `wind`) in place of all numbers: the wind at home from `time` on; what
    members and hours differ by is the spread. Heights without a CF standard name get the stronger wind."""
    spread: NotNegative = 0.0
    """By so much it may be stronger or weaker, gusts and all [m/s]: it counts for the tube, for the most energy, and a
    flight that it would push off its path is refused."""
    _forecast: ForecastWind | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _one_wind(self) -> "WindSection":
        if self.file is not None and self.model_fields_set != {"file"}:
            raise ValueError("expected either a file, or numbers")
        numbers = {len(self.heights), len(self.speeds), len(self.directions)}
        if numbers == {0}:
            return self
        if len(numbers) > 1 or not 2 <= len(self.heights) <= MOST_LEVELS:
            raise ValueError(f"expected as many speeds and directions as heights, two to {MOST_LEVELS}")
        if any(above <= below for below, above in pairwise(self.heights)):
            raise ValueError("expected heights that grow")
        if self.speed or self.exponent or self.gradient_height:
            raise ValueError("expected either speed, exponent and gradient_height, or heights, speeds and directions")
        return self

    def air(self) -> Wind:
        """The wind as the models have it."""
        if self.file is not None:
            words = "expected to be read with its scenario, by read_scenario or Scenario.from_dict"
            raise BadInput(words, place="wind.file")
        if self.heights:
            return Wind.of_profile(self.heights, self.speeds, self.directions, self.spread)
        return Wind(self.speed, self.from_deg, self.exponent, self.gradient_height, self.spread)

    @classmethod
    def of(cls, wind: Wind, forecast: ForecastWind | None = None) -> "WindSection":
        """The section that says so; `forecast` is what it was read from."""
        section = cls._of(wind)
        section._forecast = forecast
        return section

    @property
    def forecast(self) -> ForecastWind | None:
        """What it was read from: its remarks, and what of it was not read."""
        return self._forecast

    @classmethod
    def _of(cls, wind: Wind) -> "WindSection":
        if not wind.levels:
            plain = ("speed", "from_deg", "exponent", "gradient_height", "spread")
            return cls(**{name: getattr(wind, name) for name in plain})
        blowing = [Wind.towards_north_east(level.north, level.east) for level in wind.levels]
        return cls(
            heights=tuple(level.height for level in wind.levels),
            speeds=tuple(one.speed for one in blowing),
            directions=tuple(one.from_deg for one in blowing),
            spread=wind.spread,
        )

    @property
    def strongest(self) -> float:
        """The most that is to be reckoned with at any height [m/s]."""
        return self.air().strongest
