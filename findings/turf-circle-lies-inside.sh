#!/bin/sh
# A place inside of a round zone is outside of Turf's circle.
#
# @turf/circle 7.4.0, with @turf/destination and @turf/boolean-point-in-polygon 7.4.0. Guess: circle(center, radius)
# encloses all places within the radius. Seen: its corners lie on the radius, its 64 edges inside: at 5 km a place 4.997
# km away is outside. The zone is up to 6 m narrower, 0.12 % of its radius. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @turf/circle@7.4.0 @turf/destination@7.4.0 \
  @turf/boolean-point-in-polygon@7.4.0 >/dev/null
cat >circle.mjs <<'JS'
import { booleanPointInPolygon } from "@turf/boolean-point-in-polygon";
import { circle } from "@turf/circle";
import { destination } from "@turf/destination";

const units = { units: "meters" };
const zone = circle([8, 47], 5000, units);
const between = 360 / 64 / 2; // degrees, halfway between two corners
const inside = [4990, 4997].map((away) => booleanPointInPolygon(destination([8, 47], away, between, units), zone));
const edges = zone.geometry.coordinates[0].length - 1;
console.log(`circle of 5000 m with ${edges} edges: 4990 and 4997 m inside: ${inside}`);
process.exit(`${inside}` === "true,false" ? 0 : 1);
JS
node circle.mjs
