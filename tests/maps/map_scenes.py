"""Write small maps in every format, and change them: other wrapping, key or unit, a part dropped, a cut."""

import json
import random
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import shapely

Place = list[float]
Row = tuple[dict[str, Any], dict[str, Any]]  # geometry and properties, as in GeoJSON
DEGREE = 76.05e3, 111.18e3  # meters in a degree at 47 north


def at(east: float, north: float) -> Place:
    """Return a position near 47 N, 8 E."""
    return [round(8.0 + east / DEGREE[0], 8), round(47.0 + north / DEGREE[1], 8)]


def square(east: float, north: float, side: float) -> list[Place]:
    """Return a closed ring, counter-clockwise."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    return [at(east + side * x, north + side * y) for x, y in corners]


def scene(chance: random.Random) -> list[Row]:
    """Return some obstacles, 80 m apart."""
    rows: list[Row] = []
    for n in range(chance.randint(2, 5)):
        east, side = 80.0 * n, chance.uniform(8, 30)
        height = round(chance.uniform(12, 200), 1)
        area = {"type": "Polygon", "coordinates": [square(east, 0, side)]}
        holed = {"type": "Polygon", "coordinates": [square(east, 0, 30), square(east + 10, 10, 8)[::-1]]}
        point = {"type": "Point", "coordinates": at(east, 0)}
        line = {"type": "LineString", "coordinates": [at(east, 0), at(east, 30), at(east + 20, 60)]}
        kinds: list[Row] = [
            (area, {"building": "yes", "height": f"{height}"}),
            (holed, {"building": "yes", "height": f"{height} m"}),
            (area, {"building": "yes", "building:levels": f"{height // 3:.0f}", "roof:levels": "1"}),
            (area, {"building:part": "yes", "height": f"{height}", "min_height": "6"}),
            (area, {"building": "yes"}),
            (point, {"power": "generator", "generator:source": "wind", "height:hub": "80"}),
            (point, {"power": "generator", "generator:source": "wind", "height": "99", "rotor:diameter": "90"}),
            (point, {"man_made": "mast", "height": f"{height}"}),
            (point, {"natural": "tree", "height": "22", "diameter_crown": "9"}),
            (line, {"power": "line", "voltage": "110000"}),
            (line, {"barrier": "wall", "height": "15", "width": "3"}),
        ]
        rows.append(chance.choice(kinds))
    return rows


# --- changes of a row: the same object in another form, or less of it


def wrap(row: Row, chance: random.Random) -> None:
    """Write the geometry in another form."""
    shape, _ = row
    for ring in _rings(shape):
        if chance.random() < 0.5:
            ring.reverse()
        if chance.random() < 0.5:
            ring.insert(1, list(ring[0]))
        if chance.random() < 0.3:
            ring[:] = [[*position, 430.0] for position in ring]
    inner = dict(shape)
    kind = chance.choice(["as it is", "Multi", "GeometryCollection", "deep", "line"])
    if kind == "Multi":
        shape |= {"type": f"Multi{inner['type']}", "coordinates": [inner["coordinates"]]}
    elif kind in ("GeometryCollection", "deep"):
        shape.clear()
        shape |= {"type": "GeometryCollection", "geometries": [inner]}
        if kind == "deep":
            shape["geometries"] = [{"type": "GeometryCollection", "geometries": [inner]}]
    elif kind == "line" and inner["type"] == "Polygon" and len(inner["coordinates"]) == 1:
        shape |= {"type": "LineString", "coordinates": inner["coordinates"][0]}


OTHER_KEYS = {
    "height": ["Height", "HEIGHT", "est_height", "building:height", "height:max", "building_height", "measuredHeight"],
    "building:levels": ["building_levels", "Building:Levels", "num_floors", "levels", "storeysAboveGround"],
    "roof:levels": ["roof_levels", "building:roof:levels", "ROOF_LEVELS"],
    "rotor:diameter": ["rotor_diameter", "generator:rotor:diameter", "Rotor:Diameter"],
    "height:hub": ["hub_height", "hub:height", "height_hub", "generator:height:hub"],
    "building": ["BUILDING", "Building"],
    "generator:source": ["generator_source", "GENERATOR:SOURCE"],
    "man_made": ["MAN_MADE", "disused:man_made", "Man_Made"],
    "diameter_crown": ["crown_diameter", "crown:diameter", "canopy_diameter"],
    "min_height": ["min_hgt", "building:min_height", "MIN_HEIGHT"],
}


def rename(row: Row, chance: random.Random) -> None:
    """Replace a key by one of other maps."""
    _, tags = row
    if known := [key for key in tags if key in OTHER_KEYS]:
        key = chance.choice(known)
        tags[chance.choice(OTHER_KEYS[key])] = tags.pop(key)


LENGTHS = ("height", "height:hub", "rotor:diameter", "diameter_crown", "width", "min_height")
SPELLINGS: list[Callable[[float], str]] = [
    lambda m: f"{m:g} m", lambda m: f"{m:g}m", lambda m: f"~{m:g}", lambda m: f"{m:g} m (AGL)", lambda m: f"{m:g}+",
    lambda m: f"{m / 0.3048:.3f} ft", lambda m: f"{m / 0.0254:.2f} in", lambda m: f"{m * 100:.1f} cm",
    lambda m: f"{m / 0.9144:.4f} yd", lambda m: f"{m / 1000:.5f} km", lambda m: f"{m:.1f}".replace(".", ","),
    lambda m: f"{m - 5:g}-{m:g}", lambda m: f"{m - 5:g};{m:g} m", lambda m: f"{m:g} cubits", lambda m: f"about {m:g}",
    lambda m: f"{m * 1000:,.0f} mm", lambda m: f"{m:g} meters (roof)", lambda m: f"{int(m / 0.3048)}' 12\"",
]  # fmt: skip


def respell(row: Row, chance: random.Random) -> None:
    """Write a length in another unit or spelling."""
    _, tags = row
    if known := [key for key in LENGTHS if key in tags]:
        key = chance.choice(known)
        tags[key] = chance.choice(SPELLINGS)(float(str(tags[key]).removesuffix(" m")))


def pack(row: Row, chance: random.Random) -> None:
    """Put the tags under one property, as exporters do."""
    _, tags = row
    inner = dict(tags)
    hstore = ",".join(f'"{key}"=>"{value}"' for key, value in inner.items())
    tags.clear()
    tags |= chance.choice([{"tags": inner}, {"other_tags": hstore}, {"all_tags": json.dumps(inner)}])
    if chance.random() < 0.2 and "other_tags" in tags:
        tags["other_tags"] = hstore[: chance.randrange(len(hstore) - 3)]


def drop(row: Row, chance: random.Random) -> None:
    """Remove a tag or the geometry, or make a value empty."""
    shape, tags = row
    if chance.random() < 0.2:
        shape.clear()
        return
    key = chance.choice(list(tags))
    if chance.random() < 0.5:
        del tags[key]
    else:
        tags[key] = chance.choice(["", "unknown", "-1", None, "yes"])


CHANGES = (wrap, rename, respell, pack, drop)


def _rings(shape: dict[str, Any]) -> list[Any]:
    return list(shape["coordinates"]) if shape.get("type") == "Polygon" else []


# --- formats


def geojson(rows: list[Row]) -> str:
    return json.dumps({"type": "FeatureCollection", "features": [_feature(row) for row in rows]})


def lines(rows: list[Row]) -> str:
    """Write one feature a line."""
    return "".join(json.dumps(_feature(row)) + "\n" for row in rows)


def _feature(row: Row) -> dict[str, Any]:
    return {"type": "Feature", "geometry": row[0] or None, "properties": row[1]}


def _simple(rows: list[Row]) -> Iterator[tuple[int, list[Place], dict[str, Any]]]:
    """Yield the nodes and ways of the rows; None replaces a geometry that OpenStreetMap does not have."""
    for number, (shape, tags) in enumerate(rows, 1):
        for part in _parts(shape):
            places = part["coordinates"]
            yield number, {"Point": [places], "LineString": places}.get(part["type"]) or places[0], tags


def _parts(shape: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if shape.get("type") == "GeometryCollection":
        for member in shape["geometries"]:
            yield from _parts(member)
    elif str(shape.get("type")).startswith("Multi"):
        for places in shape["coordinates"]:
            yield {"type": shape["type"].removeprefix("Multi"), "coordinates": places}
    elif shape:
        yield shape


def _texts(tags: dict[str, Any]) -> dict[str, str]:
    return {key: str(value) for key, value in tags.items() if isinstance(value, str) and value}


def overpass(rows: list[Row]) -> str:
    """Write Overpass's JSON by `out geom`."""
    elements: list[dict[str, Any]] = []
    for number, places, tags in _simple(rows):
        where = [{"lon": place[0], "lat": place[1]} for place in places]
        element = where[0] | {"type": "node"} if len(places) == 1 else {"type": "way", "geometry": where}
        elements.append(element | {"id": number, "tags": _texts(tags)})
    return json.dumps({"version": 0.6, "elements": elements})


def osm(rows: list[Row]) -> str:
    """Write OpenStreetMap's XML; a way refers to nodes by position."""
    nodes, ways = dict[str, str](), list[str]()
    for number, places, tags in _simple(rows):
        inside = "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in _texts(tags).items())
        if len(places) == 1:
            nodes[f"9{number}"] = f'<node id="9{number}" lon="{places[0][0]}" lat="{places[0][1]}">{inside}</node>'
            continue
        numbers = [str(abs(hash((place[0], place[1]))) % 10**12 + 10**12) for place in places]
        for name, place in zip(numbers, places, strict=True):
            nodes[name] = f'<node id="{name}" lon="{place[0]}" lat="{place[1]}"/>'
        refs = "".join(f'<nd ref="{name}"/>' for name in numbers)
        ways.append(f'<way id="{number}">{refs}{inside}</way>')
    return f"<osm>{''.join(nodes.values())}{''.join(ways)}</osm>"


def kml(rows: list[Row]) -> str:
    """Write polygons, rings and lines of a KML at random places, for zones."""
    marks = []
    for number, places, _ in _simple(rows):
        text = " ".join(",".join(map(str, place)) for place in places)
        if number % 2:
            text = text.replace(",", ", ")
        ring = f"<LinearRing><coordinates>{text}</coordinates></LinearRing>"
        polygon = f"<Polygon><outerBoundaryIs>{ring}</outerBoundaryIs></Polygon>"
        drawn = [polygon, ring, f"<MultiGeometry>{ring}</MultiGeometry>"][number % 3]
        marks.append(f"<Placemark><name>{escape(str(number))}</name>{drawn}</Placemark>")
    return f"<kml><Document>{''.join(marks)}</Document></kml>"


TEXTS = {".geojson": geojson, ".geojsonl": lines, ".json": overpass, ".osm": osm, ".kml": kml}
DRIVERS = {".shp": "ESRI Shapefile", ".fgb": "FlatGeobuf", ".gpkg": "GPKG"}


def write(rows: list[Row], path: Path) -> None:
    """Write a map in the format of its suffix; a table gets the polygons alone."""
    if path.suffix in TEXTS:
        path.write_text(TEXTS[path.suffix](deepcopy(rows)), encoding="utf-8")
        return
    import pyogrio  # with pandas: 0.5 s

    fields = sorted({key for _, tags in rows for key in tags})
    shapes = np.array([shapely.to_wkb(shapely.from_geojson(json.dumps(shape))) for shape, _ in rows], object)
    columns = [np.array([_text(tags.get(key)) for _, tags in rows], object) for key in fields]
    pyogrio.raw.write(
        path, shapes, columns, fields, geometry_type="Unknown" if path.suffix != ".shp" else "Polygon",
        crs="EPSG:4326", driver=DRIVERS[path.suffix],
    )  # fmt: skip


def _text(value: Any) -> str | None:
    return json.dumps(value) if isinstance(value, dict) else value
