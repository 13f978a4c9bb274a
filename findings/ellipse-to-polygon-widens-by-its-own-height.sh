#!/bin/sh
# ellipse-to-polygon's ellipse of 200 by 80 m is 785 m wide, and one of 200 by 89 m 7.8 km.
#
# ellipse-to-polygon 0.0.6, at 47 N, half axes of 200 m to the east and of 50 to 100 m to the north. Guess: the width is
# 200 m each time. Seen: 212, 785, 7816 and 785 m. The degrees to the east are divided by the cosine of the other half
# axis, its meters read as degrees, and not of the latitude; at 90 m no map holds the zone. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund ellipse-to-polygon@0.0.6 >/dev/null
cat >ellipse.cjs <<'JS'
const ellipseToPolygon = require("ellipse-to-polygon");

const METERS = 111195; // a degree of latitude on Turf's sphere
const half = (values, meters) => Math.round(((Math.max(...values) - Math.min(...values)) / 2) * meters);
const axes = (north) => {
  const corners = ellipseToPolygon([8, 47], 200, north, 0, 360);
  const width = half(corners.map((corner) => corner[0]), METERS * Math.cos((47 * Math.PI) / 180));
  return `${width} by ${half(corners.map((corner) => corner[1]), METERS)}`;
};
const seen = [50, 80, 89, 100].map(axes).join(", ");
console.log(`half axes in m of 200 by 50, 80, 89 and 100: ${seen}`);
process.exit(seen === "212 by 50, 785 by 80, 7816 by 89, 785 by 100" ? 0 : 1);
JS
node ellipse.cjs
