#!/bin/sh
# @watergis/terrain-rgb reads the ground 13 km to the north of a place at 47 N at zoom 5, its least.
#
# @watergis/terrain-rgb 2.1.1, pixels2rgba, on a tile of terrain whose pixels hold their row. Guess: the pixel is that
# of the place in Web Mercator. Seen: rows are counted by latitude and not by its projection. At 47 N the pixel is 4
# rows to the north at zoom 5, 13 km, and 2 rows at zoom 6. At 50 N it is 2 rows at zoom 7, 1.6 km. At zoom 13 it is
# right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @watergis/terrain-rgb@2.1.1 >/dev/null
cat >rows.mjs <<'JS'
import { readFileSync } from "node:fs";
import { TerrainRGB } from "@watergis/terrain-rgb";

const { version } = JSON.parse(readFileSync("node_modules/@watergis/terrain-rgb/package.json"));
const SIZE = 256;
const pixels = new Uint8Array(SIZE * SIZE * 4);
for (let row = 0; row < SIZE; row += 1) pixels.fill(row, row * SIZE * 4, (row + 1) * SIZE * 4);
const ground = new TerrainRGB("tiles/{z}/{x}/{y}.png", SIZE);
const above = (latitude, zoom) => {
  const angle = (latitude * Math.PI) / 180;
  const down = ((1 - Math.asinh(Math.tan(angle)) / Math.PI) / 2) * 2 ** zoom;
  const tile = [Math.floor((188 / 360) * 2 ** zoom), Math.floor(down), zoom];
  const rows = Math.floor((down % 1) * SIZE) - ground.pixels2rgba(pixels, tile, 8, latitude)[0];
  const meters = (rows * 40075017 * Math.cos(angle)) / (SIZE * 2 ** zoom);
  return [rows, Math.round(meters / 10) * 10];
};
const seen = [[47, 5], [47, 6], [50, 7], [47, 13]].map(([latitude, zoom]) => above(latitude, zoom));
console.log(`@watergis/terrain-rgb ${version}: rows and meters to the north at 47 N by zoom 5 and 6, at 50 N by 7 and`);
console.log(`at 47 N by 13: ${JSON.stringify(seen)}`);
process.exit(JSON.stringify(seen) === "[[4,13350],[2,3340],[2,1570],[0,0]]" ? 0 : 1);
JS
node rows.mjs
