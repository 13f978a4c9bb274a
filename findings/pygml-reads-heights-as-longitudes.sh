#!/bin/sh
# pygml reads the heights of a line as latitudes and longitudes.
#
# pygml 0.3.2, parse, on GML 3.2 in EPSG:4979, whose srsDimension is an attribute of the line, as the schema allows and
# as it is of a point. Guess: two positions at 100 and 200 m. Seen: three, of which the second is 47 E 100 N, the third
# 200 E 9 N; with the attribute on posList both are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pygml==0.3.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import pygml

NAMES = 'xmlns:gml="http://www.opengis.net/gml/3.2" gml:id="a" srsName="urn:ogc:def:crs:EPSG::4979"'
THREE = 'srsDimension="3"'


def read(of_line, of_list):
    text = f"<gml:LineString {NAMES} {of_line}><gml:posList {of_list}>47 8 100 47 9 200</gml:posList></gml:LineString>"
    return [tuple(position) for position in pygml.parse(text).__geo_interface__["coordinates"]]


line, listed = read(THREE, ""), read("", THREE)
print(f"pygml {version('pygml')}: with the dimension of the line {line}, of the list {listed}")
as_seen = line == [(8, 47), (47, 100), (200, 9)] and listed == [(8, 47, 100), (9, 47, 200)]
raise SystemExit(0 if as_seen else 1)
PY
