#!/bin/sh
# cjio saves a city that it reprojects to degrees with a scale of 0: each building becomes one point.
#
# cjio 0.10.1 with its extra reproject, crs_reproject 4979 and save. Guess: a building of 20 by 10 m and 11 m height is
# the same in latitude and longitude. Seen: the scale of its transform, 1e-8, is written as 0.000000: by the file all
# corners are at one place on the ground. cjio says nothing, and succeeds. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cjio==0.10.1 pyproj==3.7.2
cd "$folder"
cat >city.json <<'JSON'
{"type": "CityJSON", "version": "2.0",
"transform": {"scale": [0.001, 0.001, 0.001], "translate": [465500, 5250000, 488]},
"metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/32632"},
"CityObjects": {"hall": {"type": "Building",
"geometry": [{"type": "MultiSurface", "lod": "1", "boundaries": [[[0, 1, 2, 3]]]}]}},
"vertices": [[0, 0, 0], [20000, 0, 0], [20000, 10000, 11000], [0, 10000, 11000]]}
JSON
./venv/bin/cjio city.json crs_reproject 4979 save degrees.json >/dev/null
./venv/bin/python - <<'PY'
import json
from importlib.metadata import version

city = json.load(open("degrees.json"))
scale, translate = city["transform"]["scale"], city["transform"]["translate"]
corners = {tuple(s * n + t for s, n, t in zip(scale, corner, translate)) for corner in city["vertices"]}
print(f"cjio {version('cjio')}: scale {scale}, {len(city['vertices'])} corners at {corners}")
raise SystemExit(0 if scale == [0, 0, 0] and len(city["vertices"]) == 4 and len(corners) == 1 else 1)
PY
