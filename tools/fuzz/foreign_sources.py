"""Provide valid maps and logs to damage, and probe damaged ones."""

import io
import json
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pyogrio
import shapely

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.learn.witness import witness_of
from ipoa_mission.logs.flight_log import read_flights
from ipoa_mission.logs.vehicle_file import read_vehicle, write_vehicle
from ipoa_mission.maps.areas import find_zones
from ipoa_mission.maps.building_rules import BuildingRules
from ipoa_mission.maps.buildings import find_buildings
from ipoa_mission.maps.feature import Feature
from ipoa_mission.maps.map_reader import READERS, read_features
from ipoa_mission.maps.standing import raise_buildings
from ipoa_mission.world.frame import Geodetic, LocalFrame
from ipoa_mission.world.ground import Ground
from ipoa_mission.world.terrain import Flat
from tools import REPOSITORY

FRAME = LocalFrame(Geodetic(47.0, 8.0, 500.0))
VEHICLE = LearnedVehicle(
    Autopilot.ARDUPILOT,
    drag=Learned(1.5, 1.2, 1.8),
    landing_delay=Learned(-1.0, -2.0, 0.5),
    hover_power=Learned(266.0, 260.0, 272.0),
)
TIME = 1.8e9  # of a flight [s since 1970]
RING = [[8.0, 47.0], [8.001, 47.0], [8.001, 47.001], [8.0, 47.001], [8.0, 47.0]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}
TIMES = [
    {
        "startDateTime": "2026-01-01T00:00:00Z",
        "endDateTime": "2027-01-01T00:00:00Z",
        "schedule": [{"day": ["MON", "ANY"], "startTime": "08:00:00+01:00", "endTime": "17:00:00Z"}],
    }
]
ED318 = {"identifier": "LS1", "restriction": "PROHIBITED", "limitedApplicability": TIMES}
GEOJSON = {
    "type": "FeatureCollection",
    "crs": {"type": "name", "properties": {"name": "EPSG:4326"}},
    "features": [
        {"type": "Feature", "properties": {"building": "yes", "height": "12 m"}, "geometry": POLYGON},
        {"type": "Feature", "properties": {"height": None, "num_floors": 3}, "geometry": POLYGON},
        {
            "type": "Feature",
            "properties": ED318,
            "geometry": {
                "type": "Point",
                "coordinates": [8.0, 47.0],
                "extent": {"subType": "Circle", "radius": 50},
                "layer": {"lower": 0, "lowerReference": "AGL", "upper": 120, "upperReference": "AMSL", "uom": "FT"},
            },
        },
    ],
}
ED269 = {
    "title": "zones",
    "features": [
        {
            "identifier": "LS1",
            "restriction": "PROHIBITED",
            "applicability": [{"permanent": "NO", **TIMES[0]}],
            "geometry": [
                {
                    "uomDimensions": "M",
                    "lowerLimit": 0,
                    "lowerVerticalReference": "AGL",
                    "upperLimit": 120,
                    "upperVerticalReference": "AGL",
                    "horizontalProjection": {"type": "Circle", "center": [8.0, 47.0], "radius": 50},
                }
            ],
        }
    ],
}
CITYJSON = {
    "type": "CityJSON",
    "version": "2.0",
    "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/2056"},
    "transform": {"scale": [0.001, 0.001, 0.001], "translate": [2642000.0, 1205000.0, 500.0]},
    "vertices": [[x, y, z] for z in (0, 9000) for x, y in ((0, 0), (20000, 0), (20000, 20000), (0, 20000))],
    "CityObjects": {
        "b": {"type": "Building", "children": ["p"], "attributes": {"name": "hall", "measuredHeight": 9}},
        "p": {
            "type": "BuildingPart",
            "parents": ["b"],
            "geometry": [{"type": "Solid", "lod": "1", "boundaries": [[[[0, 1, 2, 3]], [[4, 5, 6, 7]]]]}],
        },
        "t": {"type": "TINRelief", "geometry": [{"type": "CompositeSurface", "boundaries": [[[0, 1, 2]]]}]},
    },
}
KML = (
    "<kml><Document><Folder><Placemark><name>hall</name><Polygon><extrude>1</extrude>"
    "<altitudeMode>relativeToGround</altitudeMode><outerBoundaryIs><LinearRing><coordinates>"
    + " ".join(f"{x},{y},12" for x, y in RING)
    + "</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark><Placemark><LineString><coordinates>"
    "8,47 8.001,47.001</coordinates></LineString></Placemark></Folder></Document></kml>"
).encode()
STYLE = {
    "CameraCalc": {
        "AdjustedFootprintFrontal": 20,
        "AdjustedFootprintSide": 30,
        "DistanceToSurface": 50,
        "DistanceMode": 1,
    },
    "TurnAroundDistance": 10,
    "CameraTriggerInTurnAround": True,
    "FollowTerrain": False,
}
SCANS = [
    {"complexItemType": "survey", "angle": 30, "entryLocation": 1, "polygon": [[y, x] for x, y in RING]},
    {"complexItemType": "CorridorScan", "CorridorWidth": 60, "EntryPoint": 2, "polyline": [[47, 8], [47.001, 8.002]]},
    {
        "complexItemType": "StructureScan",
        "CameraCalc": STYLE["CameraCalc"],
        "polygon": [[y, x] for x, y in RING[:4]],
        **{"EntranceAltitude": 40, "GimbalPitch": 0, "ScanBottomAlt": 10, "StartFromTop": True, "StructureHeight": 50},
    },
]
SCAN_PLAN = {
    "fileType": "Plan",
    "version": 1,
    "mission": {
        "version": 2,
        "firmwareType": 12,
        "plannedHomePosition": [47.0, 8.0, 500.0],
        "items": [{"type": "ComplexItem", "TransectStyleComplexItem": STYLE, **scan} for scan in SCANS],
    },
}


def sources() -> list[tuple[str, bytes]]:
    """Return suffix and content of a valid file of each kind."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as kmz:
        kmz.writestr("doc.kml", KML)
    documents = [(".geojson", GEOJSON), (".json", ED269), (".json", CITYJSON), (".plan", SCAN_PLAN)]
    texts = [(suffix, json.dumps(document).encode()) for suffix, document in documents]
    tests = REPOSITORY / "tests"
    recorded = [*sorted((tests / "logs").glob("sitl-*")), *sorted((tests / "logs").glob("other_vehicle-0.*"))]
    logs = [(path.suffix, path.read_bytes()) for path in recorded]
    vehicle = (".toml", write_vehicle(VEHICLE).encode())
    return [*texts, *texts, (".kml", KML), (".kmz", archive.getvalue()), vehicle, *_tables(), *logs]


def _tables() -> list[tuple[str, bytes]]:
    """Return a polygon as GDAL writes it: shapefile (main file), FlatGeobuf, GeoPackage."""
    shape = np.array([shapely.to_wkb(shapely.Polygon(RING))], dtype=object)
    height = [np.array([12.0])]
    tables = []
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".shp", ".fgb", ".gpkg"):
            path = Path(folder) / f"table{suffix}"
            pyogrio.raw.write(path, shape, height, ["height"], geometry_type="Polygon", crs="EPSG:4326")
            tables.append((suffix, path.read_bytes()))
    return tables


def probe_foreign(path: Path) -> str:
    """Read one map or log: `refused` or `read`.

    Raises:
        AssertionError: a refusal does not begin with the file.
    """
    try:
        if path.suffix == ".toml":
            read_vehicle(path)
            return "read"
        if path.suffix not in READERS:
            for flight in read_flights(path).flights:
                flight.record(flight.mission)
                witness_of(flight)
            return "read"
        features = read_features(path)
    except BadInput as error:
        if not str(error).startswith(f"{path}: "):
            raise AssertionError(f"does not begin with the file: {error}") from error
        return "refused"
    except MissionError:
        return "refused"
    for use in (_as_buildings, _as_zones):
        try:
            use(path, features)
        except BadInput as error:
            if not str(error).startswith(f"{path}: "):
                raise AssertionError(f"does not begin with the file: {error}") from error
    return "read"


def _as_buildings(path: Path, features: tuple[Feature, ...]) -> None:
    raise_buildings(find_buildings(features, BuildingRules(), FRAME, path).standing, Ground(Flat(0.0)))


def _as_zones(path: Path, features: tuple[Feature, ...]) -> None:
    find_zones(features, FRAME, path, time=TIME)
