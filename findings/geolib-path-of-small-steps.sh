#!/bin/sh
# geolib measures a flight logged ten times a second as 0 m.
#
# geolib 3.3.14, getPathLength. Guess: the length of a path is that of its legs, with decimals. Seen: each leg is
# rounded to a whole meter before the sum. A flight of 300 m at 3 m/s, one position each 0.1 s, is 0 m long; one
# position a second gives 300 m. A limit on the length flown is never reached. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund geolib@3.3.14 >/dev/null
cat >length.cjs <<'JS'
const { getPathLength } = require("geolib");
const meter = 1 / 111319.49; // degrees of latitude on geolib's sphere
const path = (step, count) => Array.from({ length: count + 1 }, (_, n) => [47 + n * step * meter, 8]);
const lengths = [getPathLength(path(0.3, 1000)), getPathLength(path(3, 100))];
console.log(`300 m in steps of 0.3 m and of 3 m: ${lengths} m`);
process.exit(`${lengths}` === "0,300" ? 0 : 1);
JS
node length.cjs
