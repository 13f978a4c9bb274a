"""Azimuthal equidistant plane on a sphere, of PX4 and QGroundControl."""

from dataclasses import dataclass

import numpy as np

from ipoa_mission.geometry import Points, Vector

RADIUS = 6_371_000.0  # of their Earth [m]


@dataclass(frozen=True)
class SphericalPlane:
    """About a place [deg], or one per point (n,)."""

    latitude_deg: Vector | float
    longitude_deg: Vector | float

    def to_plane(self, latitude_deg: Vector, longitude_deg: Vector) -> Points:
        """Return east and north, (n, 2) [m]."""
        latitude, middle = np.radians(latitude_deg), np.radians(self.latitude_deg)
        turn = np.radians(np.asarray(longitude_deg) - self.longitude_deg)
        east = np.cos(latitude) * np.sin(turn)
        north = np.cos(middle) * np.sin(latitude) - np.sin(middle) * np.cos(latitude) * np.cos(turn)
        high = np.sin(middle) * np.sin(latitude) + np.cos(middle) * np.cos(latitude) * np.cos(turn)
        away = np.arctan2(np.hypot(east, north), high)
        return np.asarray(np.column_stack([east, north]) * (RADIUS / np.sinc(away / np.pi))[:, None])

    def to_geodetic(self, east: Vector, north: Vector) -> tuple[Vector, Vector]:
        """Return latitude and longitude, each (n,) [deg]."""
        middle = np.radians(self.latitude_deg)
        away = np.hypot(north, east) / RADIUS
        share = np.sinc(away / np.pi) / RADIUS  # of sine to distance
        height = np.cos(away) * np.sin(middle) + north * share * np.cos(middle)
        across = np.cos(middle) * np.cos(away) - north * share * np.sin(middle)
        longitude = self.longitude_deg + np.degrees(np.arctan2(east * share, across))
        return np.degrees(np.arcsin(height)), (longitude + 180.0) % 360.0 - 180.0
