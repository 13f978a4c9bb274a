#!/bin/sh
# geojson-to-gml-3 writes a climb so that GDAL reads its heights as longitudes.
#
# geojson-to-gml-3 2.0.2 and pyogrio 0.13.0 (GDAL 3.12.4). Guess: a line with heights gets srsDimension="3", or is
# written without them. Seen: <gml:posList>8 47 100 8.1 47.1 200</gml:posList> without a dimension. GDAL reads pairs:
# three corners, one at 100 E 8.1 N. With {srsDimension: 3} as a parameter both agree. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.1.2 numpy==2.3.5
cd "$folder"
npm install --silent --no-audit --no-fund geojson-to-gml-3@2.0.2 >/dev/null
cat >write.cjs <<'JS'
const { writeFileSync } = require("fs");
const { geomToGml } = require("geojson-to-gml-3");

const climb = { type: "LineString", coordinates: [[8, 47, 100], [8.1, 47.1, 200]] };
const head = '<m xmlns:gml="http://www.opengis.net/gml/3.2"><gml:featureMember><route><geometryProperty>';
const tail = "</geometryProperty></route></gml:featureMember></m>";
for (const [name, parameters] of [["plain", undefined], ["told", { srsDimension: 3 }]])
  writeFileSync(`${name}.gml`, head + geomToGml(climb, null, parameters) + tail);
JS
node write.cjs
./venv/bin/python -W ignore - <<'PY'
import pyogrio
import shapely


def read(name):
    shape = shapely.from_wkb(pyogrio.raw.read(f"{name}.gml")[2][0])
    return shapely.get_coordinates(shape, include_z=shape.has_z).tolist()


plain, told = read("plain"), read("told")
print(f"GDAL {pyogrio.__gdal_version_string__}: {plain}; with a dimension {told}")
as_seen = plain == [[8, 47], [100, 8.1], [47.1, 200]]
raise SystemExit(0 if as_seen and told == [[8, 47, 100], [8.1, 47.1, 200]] else 1)
PY
