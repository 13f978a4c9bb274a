#!/bin/sh
# geotiff.js and rasterio place the posts of one elevation model half a cell apart.
#
# geotiff 3.0.5 (npm) and rasterio 1.4.4, on a GeoTIFF whose values belong to points (RasterPixelIsPoint, as Copernicus
# DEM). Guess: getBoundingBox() and rasterio's bounds agree. Seen: with cells of one arc second geotiff.js lies 0.5 cell
# further east and south, 15.4 m south; a pixel-is-area GeoTIFF agrees. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rasterio==1.4.4 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund geotiff@3.0.5 >/dev/null
./venv/bin/python - >bounds.json <<'PY'
import json

import numpy as np
import rasterio
from rasterio.transform import from_origin

profile = {"driver": "GTiff", "width": 20, "height": 10, "count": 1, "dtype": "float32", "crs": "EPSG:4326"}
bounds = {}
for kind in ("Area", "Point"):
    with rasterio.open(f"{kind}.tif", "w", transform=from_origin(8, 48, 1 / 3600, 1 / 3600), **profile) as model:
        model.update_tags(AREA_OR_POINT=kind)
        model.write(np.full((1, 10, 20), 500, "float32"))
    with rasterio.open(f"{kind}.tif") as model:
        bounds[kind] = list(model.bounds)
print(json.dumps(bounds))
PY
cat >read.mjs <<'JS'
import { readFileSync } from "fs";
import { fromFile } from "geotiff";

const bounds = JSON.parse(readFileSync("bounds.json", "utf8"));
const seen = {};
for (const kind of ["Area", "Point"]) {
  const image = await (await fromFile(`${kind}.tif`)).getImage();
  const cells = image.getBoundingBox().map((degrees, side) => (degrees - bounds[kind][side]) * 3600);
  seen[kind] = cells.map((cell) => Math.round(cell * 1000) / 1000 + 0).join(" ");
}
console.log("geotiff.js less rasterio [cells: west, south, east, north]:", seen);
process.exit(seen.Area === "0 0 0 0" && seen.Point === "0.5 -0.5 0.5 -0.5" ? 0 : 1);
JS
node read.mjs
