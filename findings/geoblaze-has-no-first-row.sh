#!/bin/sh
# geoblaze finds no value in the first row and the first column of an elevation model, and -32767 m at a void.
#
# geoblaze 2.8.0, identify, with georaster 1.6.0; rasterio 1.4.4 writes 10 rows of 10 posts, from 500 to 599 m. Guess:
# the height at the center of each cell, and none at a void. Seen: null for 19 of 100, all of the first row and the
# first column; -32767 at a post that is the file's nodata value. Its statistics have all of them, and leave the void
# out. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rasterio==1.4.4 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts geoblaze@2.8.0 georaster@1.6.0 >/dev/null
./venv/bin/python - <<'PY'
import numpy as np
import rasterio

heights = np.arange(500, 600, dtype="float32").reshape(10, 10)
heights[5, 5] = -32767
grid = {"crs": "EPSG:4326", "transform": rasterio.transform.from_origin(8, 48, 0.1, 0.1), "nodata": -32767}
with rasterio.open("h.tif", "w", driver="GTiff", width=10, height=10, count=1, dtype="float32", **grid) as out:
    out.write(heights, 1)
PY
cat >heights.cjs <<'JS'
const { identify, min, max } = require("geoblaze");
const parse = require("georaster");
const bytes = require("fs").readFileSync("h.tif");

(async () => {
  const raster = await parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const missing = [];
  for (let row = 0; row < 10; row++)
    for (let column = 0; column < 10; column++)
      if ((await identify(raster, [8.05 + column / 10, 47.95 - row / 10])) === null) missing.push([row, column]);
  const [hole] = await identify(raster, [8.55, 47.45]);
  const ends = [...(await min(raster)), ...(await max(raster))];
  console.log(`posts without a value: ${missing.length}; at the void ${hole} m; least and most ${ends} m`);
  const edges = missing.length === 19 && missing.every(([row, column]) => row === 0 || column === 0);
  process.exit(edges && hole === -32767 && ends.join() === "500,599" ? 0 : 1);
})();
JS
node heights.cjs
