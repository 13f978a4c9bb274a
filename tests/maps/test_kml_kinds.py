"""Public reports: placemark/togeojson #104 and mapbox/togeojson #189 (LinearRing), GDAL #4031 (blanks)."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from shapely import Point

from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.maps.areas import Zones, find_zones
from ipoa_mission.maps.map_reader import read_features
from tests.refused import refuses

RING = "8.0,47.0 8.001,47.0 8.001,47.001 8.0,47.001 8.0,47.0"
OTHER = RING.replace("8.00", "8.01").replace("8.0,", "8.01,")
AREA = 76.05 * 111.18  # of the ring [m^2], by pymap3d


def ring(coordinates: str = RING) -> str:
    return f"<LinearRing><coordinates>{coordinates}</coordinates></LinearRing>"


def polygon(coordinates: str = RING) -> str:
    return f"<Polygon><outerBoundaryIs>{ring(coordinates)}</outerBoundaryIs></Polygon>"


def zones_of(tmp_path: Path, frame: LocalFrame, *placemarks: str) -> Zones:
    path = tmp_path / "zones.kml"
    inside = "".join(each if each.startswith("<Net") else f"<Placemark>{each}</Placemark>" for each in placemarks)
    path.write_text(
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>'
        f"{inside}</Document></kml>",
        encoding="utf-8",
    )
    return find_zones(read_features(path), frame, path)


@pytest.mark.parametrize(
    "drawn",
    [
        polygon(),
        ring(),
        f"<MultiGeometry>{ring()}</MultiGeometry>",
        f"<MultiGeometry><MultiGeometry>{ring()}</MultiGeometry></MultiGeometry>",
        f"<LineString><coordinates>{RING}</coordinates></LineString>",
        ring(RING.removesuffix(" 8.0,47.0")),  # not closed
        ring(RING.replace(",", ", ")),
        ring(RING.replace(",", " ,\n").replace(" 8.001 ", "\n\t8.001 ")),
        ring(RING.replace("47.0 ", "47.0,0 ").replace("47.001 ", "47.001, 0 ")),
        "<gx:Track>"
        + "".join(f"<gx:coord>{word.replace(',', ' ')} 0</gx:coord>" for word in RING.split())
        + "</gx:Track>",
    ],
)
def test_a_ring_is_a_zone_however_it_is_drawn(tmp_path: Path, frame: LocalFrame, drawn: str) -> None:
    zones = zones_of(tmp_path, frame, drawn)
    (zone,) = zones.zones
    assert zone.shape.area == pytest.approx(AREA, rel=2e-3)
    assert zones.passed_over == zones.unread == ()


def test_a_ring_beside_a_polygon_in_a_collection_is_a_second_zone(tmp_path: Path, frame: LocalFrame) -> None:
    zones = zones_of(tmp_path, frame, f"<MultiGeometry>{polygon()}{ring(OTHER)}</MultiGeometry>")
    assert [round(zone.shape.centroid.x, -2) for zone in zones.zones] == [0.0, 800.0]


def test_a_link_and_a_body_in_another_file_are_named_as_what_may_be_a_zone(tmp_path: Path, frame: LocalFrame) -> None:
    link = "<NetworkLink><name>more</name><Link><href>more.kml</href></Link></NetworkLink>"
    model = "<Model><Location><longitude>8</longitude><latitude>47</latitude></Location></Model>"
    zones = zones_of(tmp_path, frame, polygon(), link, f"<MultiGeometry>{polygon(OTHER)}{model}</MultiGeometry>")
    assert len(zones.zones) == 2
    assert [(thing.what.partition(",")[0], thing.place, thing.may_limit) for thing in zones.unread] == [
        ("NetworkLink", "Placemark[1]", True),
        ("Model", "Placemark[2]", True),
    ]


def test_an_image_on_the_ground_is_named_where_it_lies(tmp_path: Path, frame: LocalFrame) -> None:
    box = "<north>47.001</north><south>47</south><east>8.001</east><west>8</west>"
    path = tmp_path / "zones.kml"
    path.write_text(
        f"<kml><Document><Placemark>{polygon(OTHER)}</Placemark><GroundOverlay><name>chart</name>"
        f"<LatLonBox>{box}</LatLonBox></GroundOverlay></Document></kml>",
        encoding="utf-8",
    )
    (image,) = [thing for thing in find_zones(read_features(path), frame, path).passed_over if thing.may_be_obstacle]
    assert (image.name, image.code) == ("chart", "not-read")
    assert image.shape.area == pytest.approx(AREA, rel=2e-3)


def test_a_second_kml_in_a_kmz_is_named(tmp_path: Path, frame: LocalFrame) -> None:
    path = tmp_path / "zones.kmz"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("doc.kml", "files/more.kml"):
            archive.writestr(name, f"<kml><Placemark>{polygon()}</Placemark></kml>")
    zones = find_zones(read_features(path), frame, path)
    assert len(zones.zones) == 1
    assert [thing.what for thing in zones.unread] == ["files/more.kml, a second KML"]


@pytest.mark.parametrize("coordinates", [RING.replace(" ", ","), RING.replace(" ", ", "), "8.0 47.0 8.1 47.0 8.1 47.1"])
def test_positions_that_run_together_are_refused(tmp_path: Path, frame: LocalFrame, coordinates: str) -> None:
    with refuses("bad-input", "zones.kml: Placemark[0].LinearRing.coordinates"):
        zones_of(tmp_path, frame, ring(coordinates))


@pytest.mark.parametrize(
    ("tags", "radius"),
    [
        ({"radius": 500}, 500.0),
        ({"Radius": "500 m"}, 500.0),
        ({"radius_nm": 2}, 3704.0),
        ({"radius": "1.5 km"}, 1500.0),
    ],
)
def test_a_point_with_a_radius_is_a_circle(
    write_map: Callable[..., Path], frame: LocalFrame, tags: dict[str, object], radius: float
) -> None:
    """As Leaflet draws them; no side of the polygon is inside of the circle."""
    path = write_map(({"type": "Point", "coordinates": [8.0, 47.0]}, tags))
    (zone,) = find_zones(read_features(path), frame, path).zones
    assert zone.shape.exterior.distance(Point(0, 0)) == pytest.approx(radius, rel=1e-6)
