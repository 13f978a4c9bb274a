#!/bin/sh
# Turf's cleanCoords and simplify remove a climb over a hill from a straight flight.
#
# @turf/clean-coords 7.4.0, @turf/simplify 7.4.0. Guess: a waypoint at another height is no repetition, and no point on
# a straight line. Seen: of five waypoints on one line, the third at 150 m, only the ends at 30 m are left; of a climb
# on the spot from 30 to 120 m only the lower waypoint is left, so that the climb is spread over the next leg. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @turf/clean-coords@7.4.0 @turf/simplify@7.4.0 >/dev/null
cat >clean.mjs <<'JS'
import { cleanCoords } from "@turf/clean-coords";
import { simplify } from "@turf/simplify";

const line = (coordinates) => ({ type: "Feature", properties: {}, geometry: { type: "LineString", coordinates } });
const heights = (feature) => feature.geometry.coordinates.map((position) => position[2]);
const hill = () => line([30, 30, 150, 30, 30].map((height, n) => [8 + n / 100, 47, height]));
const cleaned = heights(cleanCoords(hill()));
const simplified = heights(simplify(hill(), { tolerance: 0.00001, highQuality: true }));
const onTheSpot = heights(cleanCoords(line([[8, 47, 30], [8, 47, 120], [8.01, 47, 120]])));
console.log(`hill of 150 m: cleanCoords ${cleaned}, simplify ${simplified}; climb on the spot: ${onTheSpot}`);
process.exit(`${cleaned} ${simplified} ${onTheSpot}` === "30,30 30,30 30,120" ? 0 : 1);
JS
node clean.mjs
