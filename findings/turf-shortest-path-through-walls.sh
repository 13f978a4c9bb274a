#!/bin/sh
# Turf's shortestPath goes straight through obstacles that are narrower than its grid.
#
# @turf/shortest-path 7.4.0. Guess: the path is round each obstacle, or there is none. Seen: points of a grid are
# tested, not the way between them. With a resolution of 20 m a wall of 8 m by 900 m is crossed 415 m from its end, with
# 5 m the corner is cut. Without a resolution, which is 100 km, a block of 150 m is crossed. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @turf/shortest-path@7.4.0 >/dev/null
cat >path.mjs <<'JS'
import { shortestPath } from "@turf/shortest-path";

const crossedFromEnd = (width, options) => {
  const [west, east, south, north] = [8.005, 8.005 + width, 47.001, 47.009];
  const ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
  const obstacle = { type: "Feature", properties: {}, geometry: { type: "Polygon", coordinates: [ring] } };
  const obstacles = { type: "FeatureCollection", features: [obstacle] };
  const { coordinates } = shortestPath([8, 47.0053], [8.01, 47.0053], { obstacles, ...options }).geometry;
  const middle = (west + east) / 2;
  const n = coordinates.findIndex(([x]) => x > middle);
  const [[fromX, fromY], [x, y]] = coordinates.slice(n - 1, n + 1);
  return (111195 * (north - fromY - ((y - fromY) * (middle - fromX)) / (x - fromX))).toFixed(1);
};
const meters = (resolution) => ({ resolution, units: "meters" });
const seen = [crossedFromEnd(0.0001, meters(20)), crossedFromEnd(0.0001, meters(5)), crossedFromEnd(0.002, {})];
console.log(`m from the end: wall with 20 m ${seen[0]}, with 5 m ${seen[1]}; block of 150 m by default ${seen[2]}`);
process.exit(seen[0] > 400 && seen[1] > 0 && seen[1] < 5 && seen[2] > 400 ? 0 : 1);
JS
node path.mjs
