#!/bin/sh
# gpx-parse moves a waypoint on the meridian of Greenwich one degree to the west.
#
# gpx-parse 0.10.4 (npm). Guess: lat="0", lon="0" and <ele>0</ele> are zeros. Seen: each zero becomes -1: longitude 0 is
# -1, 69 km away at 51.5 N, the equator is 1 S, and sea level is 1 m below it. 0.0001 stays. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund gpx-parse@0.10.4 >/dev/null 2>&1
cat >parse.cjs <<'JS'
const { parseGpx } = require("gpx-parse");
const point = (lat, lon, ele) => `<wpt lat="${lat}" lon="${lon}"><ele>${ele}</ele></wpt>`;
const points = [point(51.5, 0, 12.5), point(0, 8.5, 0), point(51.5, 0.0001, 12.5)].join("");
const text = `<gpx version="1.1" creator="a" xmlns="http://www.topografix.com/GPX/1/1">${points}</gpx>`;
parseGpx(text, (error, { waypoints }) => {
  const read = waypoints.map(({ lat, lon, elevation }) => `${lat} ${lon} ${elevation}`);
  console.log(`51.5 0 12.5, 0 8.5 0, 51.5 0.0001 12.5 are read as ${read.join(", ")}`);
  process.exit(`${read}` === "51.5 -1 12.5,-1 8.5 -1,51.5 0.0001 12.5" ? 0 : 1);
});
JS
node parse.cjs
