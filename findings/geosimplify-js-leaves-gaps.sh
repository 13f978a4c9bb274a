#!/bin/sh
# @mapbox/geosimplify-js removes all points of a straight flight, whatever gap it is told to keep.
#
# @mapbox/geosimplify-js 0.1.0, simplify(points, offsetThreshold, gapThreshold). Its README: a point stays if a segment
# longer than the gap threshold would follow. Guess: of 11 points 100 m apart on a line, enough stay for 250 m. Seen:
# two, 1 km apart, with a gap of 250 m, 1 m or none; its function of distances returns nothing. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @mapbox/geosimplify-js@0.1.0 >/dev/null
cat >line.cjs <<'JS'
const simplify = require("@mapbox/geosimplify-js");

const points = Array.from({ length: 11 }, (_, index) => [8, 47 + (100 * index) / 111194.9]);
const bent = points.map(([longitude, latitude], index) => [longitude + (index === 5 ? 0.001 : 0), latitude]);
const seen = [250, 1, Infinity].map((gap) => simplify(points, 5, gap).length);
console.log(`points of 11 with gaps of 250, 1 and any meters: ${seen}; with a bend ${simplify(bent, 5, 250).length}`);
process.exit(String(seen) === "2,2,2" && simplify(bent, 5, 250).length > 2 ? 0 : 1);
JS
node line.cjs
