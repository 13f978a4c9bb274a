#!/bin/sh
# vectorize turns a flight to the north-east at 60 N to 63 degrees.
#
# vectorize 0.1.1, toPositions, which gives meters. Guess: 100 m to the north and 100 m to the east are x 100, y 100 m
# at each latitude. Seen: 126 and 63 m, as the course is that of degrees, while the length is that of meters. At the
# equator it is right. gps-filter removes its sharp turns by these courses. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund vectorize@0.1.1 moment@2.30.1 >/dev/null
cat >course.cjs <<'JS'
const vectorize = require("vectorize");

const METER = 180 / Math.PI / 6371000; // degrees

function leg(latitude, meters) {
  const step = meters * METER;
  return [
    { lat: latitude, lng: 8 },
    { lat: latitude + step, lng: 8 + step / Math.cos((latitude * Math.PI) / 180) },
  ];
}

function part(vectors) {
  return [vectors[0].x, vectors[0].y].map((value) => Math.round(value));
}

const seen = [0, 60].map((latitude) => part(vectorize.toPositions(leg(latitude, 100))));
console.log(`100 m to the north-east at 0 and 60 N: ${JSON.stringify(seen)}`);
process.exit(JSON.stringify(seen) === "[[100,100],[126,63]]" ? 0 : 1);
JS
node course.cjs
