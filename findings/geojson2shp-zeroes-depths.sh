#!/bin/sh
# geojson2shp writes small negative heights, and missing ones, so that GDAL reads them as 0.
#
# geojson2shp 0.5.0 (npm), convert; pyogrio 0.13.0 (GDAL 3.12.4) and pyshp 3.1.6 read. Guess: -0.5 m is -0.5 m, and a
# feature without a height has none. Seen: the minus and the digits are 12 blanks apart ("-            0.5"), a missing
# number is a point among blanks. GDAL reads 0 for both, pyshp none; 80.75 and -20.5 are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 pyshp==3.1.6 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts geojson2shp@0.5.0 >/dev/null
cat >write.cjs <<'JS'
const { convert } = require("geojson2shp");

const heights = [{ height: 80.75 }, { height: -0.5 }, {}, { height: -20.5 }];
const features = heights.map((properties, n) => ({
  type: "Feature",
  properties,
  geometry: { type: "Point", coordinates: [8 + n / 10, 47] },
}));
convert(features, "masts.zip", { layer: "masts" });
JS
node write.cjs
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import pyogrio
import shapefile

(values,) = pyogrio.raw.read("/vsizip/masts.zip/masts.shp")[3]
by_gdal = values.tolist()
with shapefile.Reader("masts.zip") as reader:
    by_pyshp = [record.height for record in reader.records()]
print(f"heights 80.75, -0.5, none and -20.5 by pyogrio {version('pyogrio')}: {by_gdal}, by pyshp: {by_pyshp}")
raise SystemExit(0 if by_gdal == [80.75, 0.0, 0.0, -20.5] and by_pyshp == [80.75, None, None, -20.5] else 1)
PY
