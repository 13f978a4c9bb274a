"""Geodetic and local east, north, up, by PROJ on WGS 84.

`up` is along home's vertical: 2 km away the Earth has curved 0.3 m below. Heights are AMSL: the geoid's change over a
flight is ignored.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pyproj import Geod, Transformer

from ipoa_mission.geometry import Points, Vector

EARTH_RADIUS = 6_371_000.0  # spherical, as vehicles count heights [m]
_ELLIPSOID = Geod(ellps="WGS84")
REACH = 100_000.0  # [m]


@dataclass(frozen=True)
class Geodetic:
    """A place on the Earth.

    Attributes:
        latitude_deg: on WGS 84 [degrees].
        longitude_deg: [degrees].
        altitude: above mean sea level [m]; of a rally point, above home.

    Example:
        >>> Geodetic(47.397742, 8.545594, 488.0).altitude
        488.0
    """

    latitude_deg: float
    longitude_deg: float
    altitude: float = 0.0


def apart(a: Geodetic, b: Geodetic) -> float:
    """Return the distance over the ground [m]."""
    return float(_ELLIPSOID.inv(a.longitude_deg, a.latitude_deg, b.longitude_deg, b.latitude_deg)[2])


def swap_hint(home: Geodetic, there: Geodetic, name: str) -> str:
    turned = Geodetic(there.longitude_deg, there.latitude_deg)
    fits = abs(turned.latitude_deg) <= 90 and apart(home, turned) <= REACH
    return f": latitude and longitude may be swapped, in home or in {name}" if fits else ""


def radii_of_curvature(latitude_deg: float) -> tuple[float, float]:
    """Return the radii along and across the meridian [m]."""
    squared = 1 - _ELLIPSOID.es * np.sin(np.radians(latitude_deg)) ** 2
    return float(_ELLIPSOID.a * (1 - _ELLIPSOID.es) / squared**1.5), float(_ELLIPSOID.a / np.sqrt(squared))


@dataclass(frozen=True)
class LocalFrame:
    """Meters east, north, up of home; accurate to 1 mm within 50 km, also across the antimeridian."""

    home: Geodetic

    def to_local(self, latitude_deg: Vector, longitude_deg: Vector, altitude: Vector | float) -> Points:
        """Return east, north, up [m]."""
        arrays = (np.atleast_1d(np.asarray(a, float)) for a in (latitude_deg, longitude_deg, altitude))
        lat, lon, alt = np.broadcast_arrays(*arrays)
        return np.column_stack(_topocentric(self.home).transform(lon, lat, alt))

    def to_geodetic(self, points: Points) -> tuple[Vector, Vector, Vector]:
        """Return latitude [deg], longitude [deg, -180 to 180] and altitude [m AMSL], each (n,)."""
        east, north, up = np.atleast_2d(np.asarray(points, float)).T
        lon, lat, alt = _topocentric(self.home).transform(east, north, up, direction="INVERSE")
        return lat, (lon + 180.0) % 360.0 - 180.0, alt

    def local(self, place: Geodetic) -> Vector:
        lon, lat, alt = float(place.longitude_deg), float(place.latitude_deg), float(place.altitude)
        return np.array(_topocentric(self.home).transform(lon, lat, alt))

    def geodetic(self, point: Vector) -> Geodetic:
        east, north, up = point
        lon, lat, alt = _topocentric(self.home).transform(float(east), float(north), float(up), direction="INVERSE")
        return Geodetic(lat, (lon + 180.0) % 360.0 - 180.0, alt)

    def moved(self, points: NDArray[np.float64], other: "LocalFrame") -> NDArray[np.float64]:
        """Return points (..., 3) of another frame [m]."""
        if other.home == self.home:
            return points
        return self.to_local(*other.to_geodetic(points.reshape(-1, 3))).reshape(points.shape)


@lru_cache(maxsize=64)
def _topocentric(home: Geodetic) -> Transformer:
    lat, lon, alt = float(home.latitude_deg), float(home.longitude_deg), float(home.altitude)  # NumPy's repr differs
    return Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lon_0={lon!r} +lat_0={lat!r} +h_0={alt!r}"
    )
