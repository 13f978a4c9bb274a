from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.errors import TooFar, TooLarge
from ipoa_mission.geodesy import REACH, LocalFrame

Box: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]  # lower and upper corner (2,) [m]


class Degrees(NamedTuple):
    """A box [deg], maybe beyond longitude 180."""

    west: float
    south: float
    east: float
    north: float

    def meets(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Compare boxes (n, 4) west, south, east, north, with longitudes wrapped."""
        west, south, east, north = boxes.T
        level = (south <= self.north) & (north >= self.south)
        turns = (-360.0, 0.0, 360.0)
        return np.asarray(level & np.any([(west <= self.east + t) & (east >= self.west + t) for t in turns], axis=0))


def window_of(box: Box, frame: LocalFrame) -> Degrees:
    """Return a wider box on a grid, so that small changes keep it."""
    margin, grid = 0.001, 0.02
    east, north = np.meshgrid(*(np.linspace(low, high, 5) for low, high in zip(*box, strict=True)))
    latitude, longitude, _ = frame.to_geodetic(np.column_stack([east.ravel(), north.ravel(), np.zeros(east.size)]))
    home = frame.home.longitude_deg
    longitude = home + (longitude - home + 180.0) % 360.0 - 180.0
    if np.abs(latitude).max() > 89.0:  # around a pole: all longitudes
        longitude = np.array([home - 180.0, home + 180.0])
    low = np.floor((np.array([longitude.min(), latitude.min()]) - margin) / grid) * grid
    high = np.ceil((np.array([longitude.max(), latitude.max()]) + margin) / grid) * grid
    return Degrees(*low.tolist(), *high.tolist())


@dataclass
class MapWindow:
    """Selects features in `window` (None: all), counts `elsewhere`; one must be `near`, within 100 km of home."""

    window: Degrees | None = None
    near: Degrees | None = None
    elsewhere: int = 0
    _found_near: bool = False
    _turned_near: bool = False

    def __post_init__(self) -> None:
        self._box = np.array([np.inf, np.inf, -np.inf, -np.inf])

    @classmethod
    def of(cls, frame: LocalFrame, within: Box | None = None) -> Self:
        latitude = float(frame.home.latitude_deg)
        longitude = float(frame.home.longitude_deg)
        high = float(np.degrees(REACH / 6.36e6))  # [m]: a lower bound of the radius of the Earth
        wide = min(high / max(float(np.cos(np.radians(latitude))), 1e-9), 180.0)
        near = Degrees(longitude - wide, latitude - high, longitude + wide, latitude + high)
        return cls(near if within is None else window_of(within, frame), near)

    def are_near(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which boxes (n, 4) [deg] are near home, (n,), as those of NaN are."""
        if self.near is None:
            return np.ones(len(boxes), bool)
        near = self.near.meets(boxes)
        self._found_near |= bool(near.any())
        self._turned_near |= bool(self.near.meets(boxes[:, [1, 0, 3, 2]]).any())
        self._box[:2] = np.fmin(self._box[:2], np.fmin.reduce(boxes[:, :2], initial=np.inf))
        self._box[2:] = np.fmax(self._box[2:], np.fmax.reduce(boxes[:, 2:], initial=-np.inf))
        return np.asarray(near | np.isnan(boxes).any(axis=1))

    def wants(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which boxes (n, 4) [deg] are wanted, (n,), as those of NaN are."""
        near = self.are_near(boxes)
        if self.window is None:
            return near
        is_wanted = np.isnan(boxes).any(axis=1) | self.window.meets(boxes)
        self.elsewhere += int((~is_wanted).sum())
        return np.asarray(is_wanted)

    def expect_near(self, path: Path) -> None:
        if self.near is None or self._found_near or not np.isfinite(self._box).all():
            return
        west, south, east, north = self._box.tolist()
        home = [(self.near.south + self.near.north) / 2, (self.near.west + self.near.east) / 2]
        turned = "in its coordinates longitude must come before latitude"
        raise TooFar(
            f"expected places within {REACH / 1000:g} km of home ({home[0]:.4f}, {home[1]:.4f}), not only "
            f"from {south:.4f}, {west:.4f} to {north:.4f}, {east:.4f}",
            hint=turned if self._turned_near else "check that it is the map of this place",
            place=path,
        )


def expect_size(path: Path, largest: int, window: Degrees | None, command: str) -> None:
    """Refuse a file of more bytes, with the command that cuts the window out of it."""
    size = path.stat().st_size if path.is_file() else 0
    if size > largest:
        sides = ("W", "S", "E", "N") if window is None else (f"{side:.2f}" for side in window)
        raise TooLarge(
            f"expected a map of at most {largest / 1e6:.0f} MB, not {size / 1e6:.0f} MB",
            hint=f"cut out the surroundings of the flight: {command.format(*sides, file=path.name)}",
            place=path,
        )
