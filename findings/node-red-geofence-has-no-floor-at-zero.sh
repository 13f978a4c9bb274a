#!/bin/sh
# node-red-node-geofence reports a vehicle on the ground inside of a zone that begins at 50 m.
#
# node-red-node-geofence 0.3.4 (npm), a circle with floor 50 and ceiling 120. Guess: at 0 m a position is outside, as at
# 1 m. Seen: inside at 0 m, and outside from 1 to 49 m, as a height of 0 is taken for none; with a floor of the number
# 0, not of a text, a vehicle at -5 m is inside. A radius of 0.4 is one of 0, as it is rounded to a whole number. Exits
# 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts node-red-node-geofence@0.3.4
cat >fence.cjs <<'JS'
const { version } = require("node-red-node-geofence/package.json");

let Fence;
const handlers = new WeakMap();
const create = (node) => {
  node.on = (_, handler) => handlers.set(node, handler);
};
const RED = { nodes: { createNode: create, registerType: (_, made) => (Fence = made) }, httpAdmin: { get() {} } };
require("node-red-node-geofence/geofence.js")(RED);
const inside = (heights, limits) => {
  const centre = { latitude: 47, longitude: 8 };
  const node = new Fence({ mode: "circle", centre, rad: 100, inside: "both", floor: "50", ceiling: "120", ...limits });
  return heights.map((alt) => {
    let seen;
    const location = { lat: 47, lon: 8.000001, alt };
    handlers.get(node).call(node, { payload: {}, location }, (message) => (seen = message.location.inarea));
    return seen;
  });
};
const heights = inside([0, 1, 49, 60, 130]);
const seen = [heights, inside([-5], { floor: 0 }), inside([-5], { floor: "0" }), inside([60], { rad: 0.4 })];
console.log(`node-red-node-geofence ${version}: inside at 0, 1, 49, 60 and 130 m ${seen[0]};`);
console.log(`at -5 m with floor 0 ${seen[1]}, with floor "0" ${seen[2]}; in a radius of 0.4 m ${seen[3]}`);
const expected = "[[true,false,false,true,false],[true],[false],[false]]";
process.exit(JSON.stringify(seen) === expected ? 0 : 1);
JS
node fence.cjs
