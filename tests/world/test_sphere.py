import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Proj

from ipoa_mission.geodesy import EARTH_RADIUS, from_spherical_plane


@given(  # pyproj rounds the center to some 1e-8 degrees: it is given to MAVLink's resolution
    latitude=st.floats(-85.0, 85.0).map(lambda degrees: round(degrees, 7)),
    longitude=st.floats(-180.0, 180.0).map(lambda degrees: round(degrees, 7)),
    east=st.floats(-1e5, 1e5),
    north=st.floats(-1e5, 1e5),
)
def test_sphere_is_projected_as_proj_s_azimuthal_equidistant_plane(
    latitude: float, longitude: float, east: float, north: float
) -> None:
    lat, lon = from_spherical_plane(latitude, longitude, np.array([east]), np.array([north]))
    assert -180.0 <= lon[0] < 180.0
    there = Proj(proj="aeqd", R=EARTH_RADIUS, lat_0=latitude, lon_0=longitude)(lon[0], lat[0])
    assert there == pytest.approx((east, north), abs=1e-4)


def test_each_point_may_have_a_place_of_its_own() -> None:
    places = np.array([[47.0, 8.0], [-33.0, 151.0]])
    latitude, longitude = from_spherical_plane(places[:, 0], places[:, 1], np.zeros(2), np.array([0.0, 1000.0]))
    assert longitude == pytest.approx(places[:, 1])
    assert latitude == pytest.approx([47.0, -33.0 + np.degrees(1000.0 / EARTH_RADIUS)])
