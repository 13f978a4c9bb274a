#!/bin/sh
# node-geo-distance calls back twice for a leg of no length, with 0 and then NaN.
#
# node-geo-distance 1.2.0 (npm), vincenty(from, to, callback) over a route of three legs, the second a hover at one
# position. Guess: three calls, the second with 0. Seen: four, with "11117.182", 0, "NaN" and "11117.377"; lengths
# but 0 are texts, so that a sum of them is one. vincentySync gives 0 once. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund node-geo-distance@1.2.0
cat >legs.cjs <<'JS'
const measure = require("node-geo-distance");
const { version } = require("node-geo-distance/package.json");
const route = [47, 47.1, 47.1, 47.2].map((latitude) => ({ latitude, longitude: 8 }));
const called = [];
for (let leg = 0; leg < 3; leg++) measure.vincenty(route[leg], route[leg + 1], (length) => called.push(length));
const sync = [0, 1, 2].map((leg) => measure.vincentySync(route[leg], route[leg + 1]));
const sum = called.reduce((total, length) => total + length, 0);
console.log(`node-geo-distance ${version}: called with ${JSON.stringify(called)}, sum ${JSON.stringify(sum)};`);
console.log(`sync ${JSON.stringify(sync)}`);
const asSeen = JSON.stringify(called) === '["11117.182",0,"NaN","11117.377"]' && sum === "011117.1820NaN11117.377";
process.exit(asSeen && JSON.stringify(sync) === '["11117.182",0,"11117.377"]' ? 0 : 1);
JS
node legs.cjs
