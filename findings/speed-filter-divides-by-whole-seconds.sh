#!/bin/sh
# speed-filter keeps two of ten points of a track with five positions a second, as each speed is infinite.
#
# speed-filter 0.0.0, filter() and calcSpeeds(). Guess: a walk at 5 m/s stays between 1 and 20 m/s at each rate. Seen:
# times are cut to whole seconds, so 0.2 s are 0; at 1.9 s the speed is 9.5 m/s. Receivers of vehicles send 5 or 10
# positions a second. gps-filter and vectorize take their speeds from it. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund speed-filter@0.0.0 moment@2.30.1 >/dev/null
cat >track.cjs <<'JS'
const filter = require("speed-filter");

const METER = 180 / Math.PI / 6371000; // degrees

function track(seconds) {
  return Array.from({ length: 10 }, (_, index) => ({
    lat: 47 + 5 * seconds * index * METER,
    lng: 8,
    time: new Date(Date.UTC(2026, 5, 1) + 1000 * seconds * index).toISOString(),
  }));
}

const seen = [1, 0.2, 1.9].map((seconds) => {
  const points = track(seconds);
  return [seconds, filter.calcSpeeds(points)[0].toFixed(1), filter.filter(points, 1, 20).length];
});
console.log(`interval, speed of 5 m/s and points kept of 10: ${JSON.stringify(seen)}`);
process.exit(JSON.stringify(seen) === '[[1,"5.0",10],[0.2,"Infinity",2],[1.9,"9.5",10]]' ? 0 : 1);
JS
node track.cjs
