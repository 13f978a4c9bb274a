#!/bin/sh
# osm2geojson writes a mark into the elements that it is given: the next conversion of them has fewer buildings.
#
# osm2geojson 0.3.2, json2geojson. Guess: the same elements give the same features each time, as a map that is converted
# whole and then in parts. Seen: after a conversion with a multipolygon the way of its ring has a key `used`, and a
# conversion without the relation leaves the building out. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q osm2geojson==0.3.2 shapely==2.2.0
cd "$folder"
./venv/bin/python - <<'PY'
from osm2geojson import json2geojson

corners = (47.0, 8.0), (47.0, 8.001), (47.001, 8.001), (47.001, 8.0)
nodes = [{"type": "node", "id": n, "lat": lat, "lon": lon} for n, (lat, lon) in enumerate(corners, 1)]
way = {"type": "way", "id": 12, "nodes": [1, 2, 3, 4, 1], "tags": {"building": "yes", "height": "30"}}
tags = {"type": "multipolygon", "landuse": "residential"}
relation = {"type": "relation", "id": 21, "tags": tags, "members": [{"type": "way", "ref": 12, "role": "outer"}]}


def tagged(*elements):
    features = json2geojson({"elements": [*nodes, *elements]})["features"]
    return sum("building" in feature["properties"]["tags"] for feature in features)


counts = tagged(way), tagged(way, relation), tagged(way)
print("buildings before, with the relation, after:", counts, " keys of the way:", *way)
raise SystemExit(0 if counts[0] == 1 and counts[2] == 0 and "used" in way else 1)
PY
