#!/bin/sh
# osm2geojson leaves out a building that is the outline of a relation of type building with a tag building.
#
# osm2geojson 0.3.2, json2geojson on Overpass JSON. Guess: a way with tags of its own is a feature, whatever relation it
# is a member of. Seen: alone the way is a polygon of 30 m; as the outline of a relation with type=building alone, too;
# with building=yes on the relation neither the way nor the relation is a feature. Nothing is raised. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q osm2geojson==0.3.2 shapely==2.2.0
cd "$folder"
./venv/bin/python - <<'PY'
from copy import deepcopy

from osm2geojson import json2geojson

corners = (47.0, 8.0), (47.0, 8.001), (47.001, 8.001), (47.001, 8.0)
nodes = [{"type": "node", "id": n, "lat": lat, "lon": lon} for n, (lat, lon) in enumerate(corners, 1)]
way = {"type": "way", "id": 12, "nodes": [1, 2, 3, 4, 1], "tags": {"building": "yes", "height": "30"}}
relation = {"type": "relation", "id": 21, "members": [{"type": "way", "ref": 12, "role": "outline"}]}


def heights(*elements):
    features = json2geojson(deepcopy({"elements": [*nodes, *elements]}))["features"]
    return [feature["properties"]["tags"].get("height") for feature in features]


seen = [heights(way)]
seen += [heights(way, relation | {"tags": tags}) for tags in ({"type": "building"}, {"type": "building", "building": "yes"})]
print("heights alone, with type=building, with building=yes on it:", *seen)
raise SystemExit(0 if seen == [["30"], ["30", None], []] else 1)
PY
