#!/bin/sh
# GDAL's OSM driver draws a building without the corner that an extract lacks, and says nothing.
#
# pyogrio 0.13.0 (GDAL 3.12.4). An extract by bounding box holds a way of four nodes, of which the node 4 lies outside
# of the box and is not in the file, as Overpass and osmium's `simple` strategy write it. Guess: the way is left out, or
# named as incomplete. Seen: a triangle, half of the building's area, and no warning. A flight over the other half meets
# no obstacle on that map. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.2.0 numpy==2.4.1
cat >"$folder/town.osm" <<'OSM'
<osm version="0.6">
 <node id="1" lat="47.000" lon="8.000"/><node id="2" lat="47.000" lon="8.001"/><node id="3" lat="47.001" lon="8.001"/>
 <way id="10"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="building" v="yes"/></way>
</osm>
OSM
cd "$folder"
./venv/bin/python - <<'PY'
import warnings

import pyogrio
import shapely

with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    meta, _, shapes, _ = pyogrio.raw.read("town.osm", layer="multipolygons")
areas = [round(shapely.from_wkb(shape).area * 1e6, 3) for shape in shapes]
print(f"GDAL {pyogrio.__gdal_version_string__}: areas {areas} of 1.0, warnings {[str(one.message) for one in said]}")
raise SystemExit(0 if areas == [0.5] and not said else 1)
PY
