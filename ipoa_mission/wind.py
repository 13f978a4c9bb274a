"""Wind by height."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from typing import Annotated, NamedTuple

from ipoa_mission.errors import BadInput

MAX_LEVELS = 8


class WindLevel(NamedTuple):
    """Eastward and northward components at a height above home [m/s]."""

    height: float
    east: float
    north: float


class WindTable(NamedTuple):
    """A wind for kernels, by its velocity; `levels` are used if the first is below the last."""

    east: float
    north: float
    exponent: float
    gradient_height: float
    base: float
    levels: Annotated[Sequence[WindLevel], MAX_LEVELS]


def wind_velocity(height: float, wind: WindTable) -> tuple[float, float]:
    """Return eastward and northward components: by the power law, or between levels and constant beyond them [m/s]."""
    levels = wind.levels
    share = 1.0
    if levels[0].height == levels[MAX_LEVELS - 1].height:
        above = max(height - wind.base, 0.0)
        if above < wind.gradient_height and wind.gradient_height > 0.0:
            share = (above / wind.gradient_height) ** wind.exponent
        return share * wind.east, share * wind.north
    upper = 0
    while upper < MAX_LEVELS - 1 and levels[upper].height < height:
        upper += 1
    low, high = levels[max(upper - 1, 0)], levels[upper]
    if high.height > low.height:
        share = min(max((height - low.height) / (high.height - low.height), 0.0), 1.0)
    return low.east + share * (high.east - low.east), low.north + share * (high.north - low.north)


@dataclass(frozen=True)
class Wind:
    """A wind that is constant in time and place, except for its height.

    Below `gradient_height` the speed is speed (height / gradient_height)^`exponent`. Between `levels` the wind is
    interpolated linearly; `speed` and `from_deg` are then those of the strongest.

    Attributes:
        speed: [m/s].
        from_deg: direction of origin, clockwise: 0 north, 90 east [degrees].
        exponent: of the power law.
        gradient_height: [m above `base`].
        spread: uncertainty of the speed, up and down [m/s].
        levels: by height, upwards, at most eight.
        base: ground of the power law [m above home].

    Example:
        >>> west = Wind(6.0, from_deg=270.0)
        >>> round(west.east, 3), round(abs(west.north), 3)
        (6.0, 0.0)
        >>> Wind(6.0, 270.0, exponent=0.5, gradient_height=20.0).speed_at(5.0)
        3.0
        >>> Wind.of_profile([10.0, 110.0], [2.0, 8.0], [270.0, 270.0]).speed_at(60.0)
        5.0
    """

    speed: float = 0.0
    from_deg: float = 0.0
    exponent: float = 0.0
    gradient_height: float = 0.0
    spread: float = 0.0
    levels: tuple[WindLevel, ...] = ()
    base: float = 0.0

    def __post_init__(self) -> None:
        for name in ("speed", "exponent", "gradient_height", "spread"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise BadInput(f"expected a wind with a finite {name} of 0 or more, not {value:g}")
        if not math.isfinite(self.from_deg + self.base):
            raise BadInput(f"expected a wind with a finite from_deg and base, not {self.from_deg:g}, {self.base:g}")
        heights = [level.height for level in self.levels]
        if len(heights) > MAX_LEVELS or not all(low < high for low, high in pairwise(heights)):
            raise BadInput(f"expected 1 to {MAX_LEVELS} increasing heights, not {heights}")
        if not all(map(math.isfinite, chain(*self.levels))):
            raise BadInput(f"expected a wind with finite levels, not {[*map(tuple, self.levels)]}")

    @classmethod
    def of_profile(
        cls, heights: Sequence[float], speeds: Sequence[float], from_deg: Sequence[float], spread: float = 0.0
    ) -> "Wind":
        """Return a profile of at most eight levels.

        `heights` are above home, increasing [m], `speeds` [m/s] and `from_deg` [degrees].
        """
        if not heights:
            raise BadInput(f"expected 1 to {MAX_LEVELS} increasing heights, not {list(heights)}")
        if not len(heights) == len(speeds) == len(from_deg):
            raise BadInput(f"expected {len(heights)} speeds and directions, not {len(speeds)} and {len(from_deg)}")
        winds = [cls(speed, angle) for speed, angle in zip(speeds, from_deg, strict=True)]
        levels = tuple(WindLevel(up, wind.east, wind.north) for up, wind in zip(heights, winds, strict=True))
        strongest = max(winds, key=lambda wind: wind.speed)
        return cls(strongest.speed, strongest.from_deg, spread=spread, levels=levels)

    @classmethod
    def of_velocity(cls, east: float, north: float) -> "Wind":
        return cls(math.hypot(north, east), math.degrees(math.atan2(-east, -north)) % 360.0)

    def speed_at(self, height: float) -> float:
        """Return the speed at a height above home [m/s]."""
        return math.hypot(*self.velocity(height))

    def velocity(self, height: float) -> tuple[float, float]:
        """Return eastward and northward components at a height above home [m/s]."""
        return wind_velocity(height, self.table)

    @cached_property
    def table(self) -> WindTable:
        given = [WindLevel(*map(float, level)) for level in self.levels] or [WindLevel(0.0, 0.0, 0.0)]
        levels = given + given[-1:] * (MAX_LEVELS - len(given))
        law = float(self.exponent), float(self.gradient_height), float(self.base)
        return WindTable(self.east, self.north, *law, levels)

    @property
    def strongest(self) -> float:
        return self.speed + self.spread

    def __str__(self) -> str:
        words = f"{self.speed:.3g} m/s from {round(self.from_deg) % 360} deg"
        if self.levels:
            blowing = [(level.height, Wind.of_velocity(level.east, level.north)) for level in self.levels]
            each = [f"{wind.speed:.3g} m/s from {round(wind.from_deg) % 360} deg at {up:.0f} m" for up, wind in blowing]
            words = f"{each[0]} to {each[-1]} above home"
        elif self.gradient_height > 0 and self.exponent > 0:
            words += f" from {self.gradient_height:g} m above home up, less below"
        return words + (f", {self.spread:.3g} m/s more or less" if self.spread else "")

    def as_json(self) -> dict[str, object]:
        about: dict[str, object] = {"speed_m_s": round(self.speed, 3), "from_deg": round(self.from_deg, 3) % 360}
        about["spread_m_s"] = round(self.spread, 3)
        if self.exponent > 0.0 and self.gradient_height > 0.0:
            about |= {"exponent": self.exponent, "gradient_height_m": self.gradient_height}
        if self.levels:
            about["levels"] = [level._asdict() for level in self.levels]
        return about

    def as_strong_as_may_be(self) -> "Wind":
        """Return the wind with `spread` at each level, at a calm one from the direction of the strongest."""
        if not self.spread:
            return self
        levels = list[WindLevel]()
        for height, east, north in self.levels:
            calm = east == north == 0.0
            from_deg = self.from_deg if calm else Wind.of_velocity(east, north).from_deg
            gusting = Wind(math.hypot(east, north) + self.spread, from_deg)
            levels.append(WindLevel(height, gusting.east, gusting.north))
        return Wind(self.strongest, self.from_deg, self.exponent, self.gradient_height, 0.0, tuple(levels), self.base)

    @property
    def east(self) -> float:
        return -self.speed * math.sin(math.radians(self.from_deg))

    @property
    def north(self) -> float:
        return -self.speed * math.cos(math.radians(self.from_deg))

    def along(self, east: float, north: float) -> float:
        """Return the component along a direction (`east`, `north`) of any length [m/s]; 0 for a zero vector."""
        length = math.hypot(east, north)
        return (self.east * east + self.north * north) / length if length > 0 else 0.0


CALM = Wind()
