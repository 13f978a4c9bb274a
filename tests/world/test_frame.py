"""Against another library's table (pymap3d, by tools/generate/frame_reference.py of commit b6e82bdb)."""

from pathlib import Path

import numpy as np
import pytest

from ipoa_mission.geodesy import Geodetic, LocalFrame

TABLE = np.genfromtxt(Path(__file__).parent.parent / "data" / "reference" / "enu.csv", delimiter=",", names=True)
MILLIMETER = 1e-3


@pytest.mark.parametrize("row", TABLE, ids=lambda r: f"{r['home_latitude_deg']:g},{r['home_longitude_deg']:g}")
def test_local_coordinates_are_right_to_a_millimeter(row: np.void) -> None:
    frame = LocalFrame(Geodetic(row["home_latitude_deg"], row["home_longitude_deg"], row["home_altitude"]))
    local = frame.local(Geodetic(row["latitude_deg"], row["longitude_deg"], row["altitude"]))
    np.testing.assert_allclose(local, [row["east"], row["north"], row["up"]], atol=MILLIMETER)


@pytest.mark.parametrize("row", TABLE, ids=lambda r: f"{r['home_latitude_deg']:g},{r['home_longitude_deg']:g}")
def test_geodetic_coordinates_are_right_to_a_millimeter(row: np.void) -> None:
    frame = LocalFrame(Geodetic(row["home_latitude_deg"], row["home_longitude_deg"], row["home_altitude"]))
    place = frame.geodetic(np.array([row["east"], row["north"], row["up"]]))
    meters_a_degree = 111_700.0
    assert abs(place.latitude_deg - row["latitude_deg"]) * meters_a_degree < MILLIMETER
    turn = (place.longitude_deg - row["longitude_deg"] + 180) % 360 - 180
    assert abs(turn) * meters_a_degree * np.cos(np.radians(row["latitude_deg"])) < MILLIMETER
    assert abs(place.altitude - row["altitude"]) < MILLIMETER
    assert -180 <= place.longitude_deg < 180
