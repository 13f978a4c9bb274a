from pathlib import Path

import pytest
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.map_reader import read_features

QGC, FIELDS, INTERUSS = "DonLakeFlyer+qgroundcontrol/test", "Fields2Cover+Fields2Cover/data", "interuss+monitoring"
RID = "monitoring/uss_qualifier/test_data"
#: Files, numbers of zones and of other features.
ACCEPTED = {
    f"{QGC}/MissionManager/PolygonGood.kml": (1, 0),
    f"{QGC}/MissionManager/PolygonAreaTest.kml": (1, 0),
    f"{QGC}/Utilities/Geo/polygon.kml": (1, 0),
    f"{QGC}/Utilities/Geo/polyline.kml": (1, 0),  # the line is closed
    f"{FIELDS}/test.json": (1, 0),
    f"{FIELDS}/test_ring.json": (1, 0),
    f"{FIELDS}/test_2_cell.json": (2, 0),
    f"{FIELDS}/strips.geojson": (6, 0),  # three bow ties
    f"{INTERUSS}/{RID}/che/rid/zurich.kml": (10, 4),
    f"{INTERUSS}/{RID}/usa/kentland/rid.kml": (10, 4),
    f"{INTERUSS}/geo-awareness-che-1.json": (9, 1),
}
REFUSED = {
    f"{QGC}/MissionManager/PolygonBadXml.kml": "line 1: expected well-formed XML",
    f"{QGC}/MissionManager/PolygonBadCoordinatesNode.kml": "line 1: expected well-formed XML",
    f"{QGC}/MissionManager/PolygonMissingNode.kml": "expected a polygon, but there is none among 1 features",
    f"{FIELDS}/swaths.geojson": "expected a polygon, but there is none among 3 features",  # lines
    f"{FIELDS}/Envelope.xml": "not in .xml",
}


def zones_of(path: Path) -> tuple[int, int]:
    features = read_features(path)
    west, south, east, north = shapely.total_bounds([feature.shape for feature in features])
    zones = find_zones(features, LocalFrame(Geodetic((south + north) / 2, (west + east) / 2)), path)
    return len(zones.zones), len(zones.passed_over)


@pytest.mark.parametrize("name", ACCEPTED)
def test_a_map_of_zones_is_read(samples: Path, name: str) -> None:
    assert zones_of(samples / name) == ACCEPTED[name]


@pytest.mark.parametrize("name", REFUSED)
def test_a_map_that_is_none_is_refused_in_words(samples: Path, name: str) -> None:
    with pytest.raises(BadInput) as caught:
        zones_of(samples / name)
    assert str(caught.value).endswith(REFUSED[name])
