"""Make the maps of missions/oldtown.toml: an invented small town in the formats of real maps.

    python -m tools.generate.oldtown_maps

Writes oldtown.geojson (buildings as Overpass turbo exports them), oldtown-zones.kml (two no-fly zones),
oldtown-area.geojson (the flight area) and oldtown.tif (an elevation model in UTM), all of them synthetic.
"""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import rasterio
from pyproj import Transformer

from ipoa_mission.files import write_atomically
from ipoa_mission.world.frame import Geodetic, LocalFrame
from tools import REPOSITORY, command_line

MISSIONS = REPOSITORY / "missions"
HOME = Geodetic(46.4400, 9.8400, 1720.0)  # an empty meadow
FRAME = LocalFrame(HOME)
SYNTHETIC = "Synthetic: no such place exists. Made by tools/generate/oldtown_maps.py."


def main() -> None:
    command_line(__doc__).parse_args()
    rng = np.random.default_rng(46)
    write_json("oldtown.geojson", [*houses(rng), *landmarks(), *trees(rng)])
    area = [(-90, -70), (420, -90), (480, 150), (430, 380), (120, 400), (-80, 300)]
    write_json("oldtown-area.geojson", [feature(polygon(area), {"name": "flight area"})])
    write_kml()
    write_model()


def houses(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return rows of houses along bent lanes: some with height, some with levels, some with neither."""
    found = []
    for row in range(6):
        for column in range(9):
            east = 30 + 42 * column + 6 * np.sin(row) + rng.uniform(-3, 3)
            north = 20 + 52 * row + 10 * np.sin(column / 2) + rng.uniform(-3, 3)
            if (row, column) in {(2, 4), (2, 5), (3, 4), (3, 5)}:
                continue  # the market square
            width, depth, heading = rng.uniform(16, 28), rng.uniform(14, 22), rng.uniform(-0.2, 0.2)
            storeys = int(rng.integers(2, 9))
            tags: dict[str, Any] = {"@id": f"way/{100 + 10 * row + column}", "building": "yes"}
            match int(rng.integers(4)):
                case 0:
                    tags["height"] = f"{3.2 * storeys:.1f}"
                case 1:
                    tags["height"] = f"{round(3.2 * storeys / 0.3048)} ft"
                case 2:
                    tags |= {"building:levels": str(storeys), "roof:levels": "1"}
            found.append(feature(rectangle(east, north, width, depth, heading), tags))
    return found


def landmarks() -> list[dict[str, Any]]:
    """Return a town hall with a courtyard, a church, an arch over a lane, a mast, and an invalid ring."""
    hall = polygon([(195, 125), (235, 125), (235, 165), (195, 165)], [(207, 137), (223, 137), (223, 153), (207, 153)])
    church = {
        "type": "MultiPolygon",
        "coordinates": [rectangle(250, 195, 14, 30, 0.1)["coordinates"], rectangle(262, 215, 9, 9, 0.1)["coordinates"]],
    }
    arch = polygon([(176, 140), (195, 140), (195, 147), (176, 147)])
    twisted = polygon([(300, 330), (330, 350), (330, 330), (300, 350)])
    return [
        feature(hall, {"@id": "relation/1", "building": "civic", "name": "town hall", "height": "24 m"}),
        feature(church, {"@id": "relation/2", "building": "church", "name": "church", "height": "41"}),
        feature(arch, {"@id": "way/3", "building": "bridge", "name": "arch", "height": "14", "min_height": "6"}),
        feature(twisted, {"@id": "way/4", "building": "barn", "name": "barn", "building:levels": "2"}),
        feature(point(150, 190), {"@id": "node/5", "man_made": "mast", "name": "mast", "height": "55"}),
        feature(line([(-60, 60), (90, 380)]), {"@id": "way/6", "power": "minor_line", "name": "20 kV line"}),
    ]


def trees(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return trees on the market square and by the river."""
    places = [(205 + 12 * i, 178.0) for i in range(3)] + [(20 + 45.0 * i, 345 + rng.uniform(-5, 5)) for i in range(6)]
    return [
        feature(point(east, north), {"@id": f"node/{900 + i}", "natural": "tree", "diameter_crown": "6"})
        for i, (east, north) in enumerate(places)
    ]


def write_model() -> None:
    """Write a valley with a hill, posts every 20 m in UTM zone 32 N, whole decimeters, one hole far from the town."""
    there = Transformer.from_crs("EPSG:4326", "EPSG:32632", always_xy=True)
    x, y = there.transform(HOME.longitude_deg, HOME.latitude_deg)
    left, top, size = round(x, -1) - 400.0, round(y, -1) + 800.0, 60
    columns, rows = np.meshgrid(left + 20 * (np.arange(size) + 0.5), top - 20 * (np.arange(size) + 0.5))
    east, north = columns - x, rows - y
    hill = 38 * np.exp(-(((east - 330) / 130) ** 2) - ((north - 260) / 150) ** 2)
    heights = HOME.altitude - 0.4 + hill + 0.03 * north + 0.8 * np.sin(east / 55) * np.cos(north / 70)
    decimetres = np.round(heights * 10).astype("int16")
    decimetres[2:4, 50:53] = -32768
    path = MISSIONS / "oldtown.tif"
    profile = {"driver": "GTiff", "dtype": "int16", "nodata": -32768, "compress": "deflate", "predictor": 2}
    transform = rasterio.Affine(20, 0, left, 0, -20, top)
    with rasterio.open(
        path, "w", width=size, height=size, count=1, crs="EPSG:32632", transform=transform, **profile
    ) as file:
        file.write(decimetres, 1)
        file.scales, file.units = (0.1,), ("metre",)
        file.update_tags(TIFFTAG_IMAGEDESCRIPTION=SYNTHETIC)


def write_kml() -> None:
    zones = {
        "hospital landing site": [(60, 118), (118, 112), (122, 160), (64, 168)],
        "school": [(330, 40), (372, 36), (378, 80), (334, 84)],
    }
    placemarks = "".join(
        f"""
    <Placemark>
      <name>{name}</name>
      <Polygon><outerBoundaryIs><LinearRing><coordinates>
        {" ".join(f"{lon},{lat},0" for lon, lat in polygon(ring)["coordinates"][0])}
      </coordinates></LinearRing></outerBoundaryIs></Polygon>
    </Placemark>"""
        for name, ring in zones.items()
    )
    write_atomically(
        MISSIONS / "oldtown-zones.kml",
        f"""<?xml version="1.0" encoding="UTF-8"?>
<!-- {SYNTHETIC} -->
<kml xmlns="http://www.opengis.net/kml/2.2">
  <Document>
    <name>No-fly zones of a town that does not exist</name>{placemarks}
  </Document>
</kml>
""",
    )


def write_json(name: str, features: list[dict[str, Any]]) -> None:
    rows = ",\n".join("    " + json.dumps(each) for each in features)
    head = f'"type": "FeatureCollection",\n  "note": {json.dumps(SYNTHETIC)},\n  "features": [\n'
    write_atomically(MISSIONS / name, f"{{\n  {head}{rows}\n  ]\n}}\n")


def feature(geometry: dict[str, Any], tags: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": tags, "geometry": geometry}


def rectangle(east: float, north: float, width: float, depth: float, heading: float) -> dict[str, Any]:
    c, s = np.cos(heading), np.sin(heading)
    corners = [(x * width / 2, y * depth / 2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return polygon([(east + c * x - s * y, north + s * x + c * y) for x, y in corners])


def polygon(*rings: Sequence[tuple[float, float]]) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [degrees([*ring, ring[0]]) for ring in rings]}


def line(corners: list[tuple[float, float]]) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": degrees(corners)}


def point(east: float, north: float) -> dict[str, Any]:
    return {"type": "Point", "coordinates": degrees([(east, north)])[0]}


def degrees(corners: list[tuple[float, float]]) -> list[list[float]]:
    latitude, longitude, _ = FRAME.to_geodetic(np.array([(east, north, 0.0) for east, north in corners]))
    return [[round(float(lon), 7), round(float(lat), 7)] for lon, lat in zip(longitude, latitude, strict=True)]


if __name__ == "__main__":
    main()
