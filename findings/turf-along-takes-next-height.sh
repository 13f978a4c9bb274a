#!/bin/sh
# Turf's along and lineSliceAlong give the whole of a climbing leg the height of its end.
#
# @turf/along 7.4.0, @turf/line-slice-along 7.4.0. Guess: a place between two waypoints has a height between theirs, or
# none. Seen: on a descent from 230 m to 30 m all places but the first have 30 m, also 10 m after its start; a slice of
# the leg is level. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @turf/along@7.4.0 @turf/line-slice-along@7.4.0 >/dev/null
cat >along.mjs <<'JS'
import { along } from "@turf/along";
import { lineSliceAlong } from "@turf/line-slice-along";

const descent = { type: "LineString", coordinates: [[8, 47, 230], [8.04, 47, 30]] };
const meters = { units: "meters" };
const heights = [10, 1500].map((distance) => along(descent, distance, meters).geometry.coordinates[2]);
const slice = lineSliceAlong(descent, 10, 1500, meters).geometry.coordinates.map((position) => position[2]);
console.log(`descent from 230 to 30 m in 3 km: after 10 and 1500 m ${heights} m; slice between them ${slice} m`);
process.exit(`${heights} ${slice}` === "30,30 30,30" ? 0 : 1);
JS
node along.mjs
