#!/bin/sh
# ahrs (npm) has NaN for the attitude of a level vehicle that points north, or never turns a level one.
#
# ahrs 1.3.3, Madgwick and Mahony with readings of a vehicle at rest, x to the north, y to the west, z up. Guess: both
# give 0, 0, 0 to the north, 90 to the west, and 10, 20, 30. Seen: Madgwick has NaN after one reading that agrees with
# its attitude, and NaN ever after. Mahony stays at 0 to the west: an acceleration of exactly 0 along an axis, as of a
# level vehicle, counts as no reading. With 10, 20, 30 both agree. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund ahrs@1.3.3 >/dev/null
cat >rest.cjs <<'JS'
const AHRS = require("ahrs");

const RADIANS = Math.PI / 180;

/** A vector of the world as a vehicle of these angles measures it. */
function measured([roll, pitch, yaw], [north, west, up]) {
  const turn = (angle, a, b) => [a * Math.cos(angle) + b * Math.sin(angle), b * Math.cos(angle) - a * Math.sin(angle)];
  [north, west] = turn(yaw * RADIANS, north, west);
  [up, north] = turn(pitch * RADIANS, up, north);
  [west, up] = turn(roll * RADIANS, west, up);
  return [north, west, up];
}

function angles(algorithm, attitude) {
  const filter = new AHRS({ sampleInterval: 20, algorithm, kp: 2 });
  const gravity = measured(attitude, [0, 0, 1]);
  const field = measured(attitude, [0.5, 0, -0.8]);
  for (let step = 0; step < 4000; step++) filter.update(0, 0, 0, ...gravity, ...field);
  const { roll, pitch, heading } = filter.getEulerAngles();
  return [roll, pitch, heading].map((value) => Math.round(value / RADIANS)).join(" ");
}

const seen = {};
for (const algorithm of ["Madgwick", "Mahony"])
  seen[algorithm] = [[0, 0, 0], [0, 0, 90], [10, 20, 30]].map((attitude) => angles(algorithm, attitude));
console.log(`north, west, and 10 20 30: ${JSON.stringify(seen)}`);
const as_seen = { Madgwick: ["NaN NaN NaN", "0 0 90", "10 20 30"], Mahony: ["0 0 0", "0 0 0", "10 20 30"] };
process.exit(JSON.stringify(seen) === JSON.stringify(as_seen) ? 0 : 1);
JS
node rest.cjs
