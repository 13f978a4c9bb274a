#!/bin/sh
# Heights that npm's flatgeobuf writes are lost in GDAL.
#
# flatgeobuf 4.5.0, serialize of GeoJSON; pyogrio 0.13.0 (GDAL 3.12.4) reads. Guess: a climb from 100 to 200 m is there
# for both. Seen: flatgeobuf itself reads it with its heights; GDAL gives a line without, no warning, as the header of
# the file says that there are none. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.2.0 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund flatgeobuf@4.5.0 >/dev/null
cat >write.mjs <<'JS'
import { writeFileSync } from "fs";
import { deserialize, serialize } from "flatgeobuf/lib/mjs/geojson.js";

const geometry = { type: "LineString", coordinates: [[8, 47, 100], [8.1, 47, 200]] };
const features = [{ type: "Feature", properties: { id: 1 }, geometry }];
const bytes = serialize({ type: "FeatureCollection", features });
writeFileSync("climb.fgb", bytes);
for await (const feature of deserialize(bytes)) console.log(JSON.stringify(feature.geometry.coordinates));
JS
own=$(node write.mjs)
read="import pyogrio.raw, shapely; print(shapely.from_wkb(pyogrio.raw.read('climb.fgb')[2][0]).wkt)"
gdal=$(./venv/bin/python -c "$read")
echo "flatgeobuf: $own; GDAL: $gdal"
[ "$own" = "[[8,47,100],[8.1,47,200]]" ] && [ "$gdal" = "LINESTRING (8 47, 8.1 47)" ]
