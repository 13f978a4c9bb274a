#!/bin/sh
# Turf's lineOffset moves a line by half the distance at 60 degrees north.
#
# @turf/line-offset 7.4.0, with @turf/distance 7.4.0 to measure. Guess: parallel legs 100 m apart are 100 m apart
# everywhere. Seen: degrees of longitude count as degrees of latitude. A line to the north is moved 100.0 m at the
# equator, 67.7 m at Zurich, 50.0 m at 60 N: passes of a survey lie closer, a corridor is narrower. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @turf/line-offset@7.4.0 @turf/distance@7.4.0 >/dev/null
cat >offset.mjs <<'JS'
import { distance } from "@turf/distance";
import { lineOffset } from "@turf/line-offset";

const units = { units: "meters" };
const moved = [0, 47.4, 60].map((latitude) => {
  const coordinates = [[8.5, latitude], [8.5, latitude + 0.01]];
  const line = { type: "Feature", properties: {}, geometry: { type: "LineString", coordinates } };
  const [corner] = lineOffset(line, 100, units).geometry.coordinates;
  return distance(coordinates[0], corner, units).toFixed(1);
});
console.log(`lineOffset by 100 m at 0, 47.4 and 60 N: ${moved} m`);
process.exit(`${moved}` === "100.0,67.7,50.0" ? 0 : 1);
JS
node offset.mjs
