#!/bin/sh
# isoxml's grid gives a cell the rate of a zone that covers a twentieth of it.
#
# isoxml 1.11.2 of npm, intersectionBasedGridGenerator, the generator by shares. Guess: a cell has the rate of the zone
# with the largest share, in any order of the zones. Seen: that of the first zone, with 5 or 45 %, too: the share is in
# square meters, what is left of the cell in square degrees, and so less than any. Sorted the other way the same field
# has other rates. By cellCenterBasedGridGenerator, the default, the rate is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund isoxml@1.11.2 >/dev/null
cat >grid.cjs <<'JS'
const { cellCenterBasedGridGenerator, intersectionBasedGridGenerator } = require("isoxml");

const zone = (west, east, rate) => ({
  type: "Feature",
  properties: { rate },
  geometry: { type: "Polygon", coordinates: [[[west, 47], [east, 47], [east, 47.001], [west, 47.001], [west, 47]]] },
});
const cell = { minX: 8, minY: 47, numCols: 1, numRows: 1, cellWidth: 0.001, cellHeight: 0.001 };
const rate = (generator, features) =>
  new Int32Array(generator({ type: "FeatureCollection", features }, ["rate"], cell))[0];
const rates = (generator, share) => {
  const edge = 8 + 0.001 * share;
  const zones = [zone(8, edge, 100), zone(edge, 8.001, 200)];
  return [rate(generator, zones), rate(generator, [...zones].reverse())];
};
const shares = [0.05, 0.45].map((share) => rates(intersectionBasedGridGenerator, share).join(" or ")).join(", ");
const centers = [0.05, 0.45].map((share) => rates(cellCenterBasedGridGenerator, share).join(" or ")).join(", ");
console.log(`rates of a cell, 5 and 45 % of it 100, the rest 200, by order: ${shares}; by its center: ${centers}`);
process.exit(shares === "100 or 200, 100 or 200" && centers === "200 or 200, 200 or 200" ? 0 : 1);
JS
node grid.cjs
