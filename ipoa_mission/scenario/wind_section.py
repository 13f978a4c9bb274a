from itertools import pairwise
from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, model_validator

from ipoa_mission.errors import BadInput
from ipoa_mission.maps.wind_levels import ForecastWind
from ipoa_mission.scenario.section import NotNegative, Section, existing_file
from ipoa_mission.wind import MAX_LEVELS, Wind


class WindSection(Section):
    """Wind of the flight, used for the route, the deviation bound and the times."""

    speed: NotNegative = 0.0
    """Speed above `gradient_height` [m/s]."""
    from_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
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
    directions: tuple[Annotated[float, Field(ge=-360, le=360)], ...] = ()
    """Direction that it blows from at each of `heights`, clockwise from north."""
    file: Annotated[Path | None, existing_file("a forecast of winds")] = None
    """A weather forecast (NetCDF or GRIB, extra `wind`) in place of all numbers: the wind at home from `time` on. Its
    deviations over members and hours are the spread. Without a CF standard name of heights, the datum with the stronger
    wind counts."""
    spread: NotNegative = 0.0
    """Greatest deviation of the wind, gusts included [m/s]. It counts for the deviation bound and the greatest energy.
    A flight that it would push off its path is refused."""
    _forecast: ForecastWind | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _one_wind(self) -> "WindSection":
        if self.file is not None and self.model_fields_set != {"file"}:
            raise ValueError("expected either a file, or numbers")
        numbers = {len(self.heights), len(self.speeds), len(self.directions)}
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
        if self.file is not None:
            words = "expected a scenario from read_scenario or Scenario.from_dict, which read the file"
            raise BadInput(words, place="wind.file")
        if self.heights:
            return Wind.of_profile(self.heights, self.speeds, self.directions, self.spread)
        return Wind(self.speed, self.from_deg, self.exponent, self.gradient_height, self.spread)

    @classmethod
    def of(cls, wind: Wind, forecast: ForecastWind | None = None) -> "WindSection":
        section = cls._of(wind)
        section._forecast = forecast
        return section

    @property
    def forecast(self) -> ForecastWind | None:
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
        return self.air().strongest
