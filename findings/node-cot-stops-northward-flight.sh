#!/bin/sh
# An aircraft that flies due north loses its course and its speed between GeoJSON and CoT of @tak-ps/node-cot.
#
# @tak-ps/node-cot 14.23.2 (npm), a feature with a course of 0 and a speed of 10 m/s, by from_geojson and to_xml, and
# back by from_xml and to_geojson. Guess: both come back, as with a course of 1 degree. Seen: <track speed="10"/>, as 0
# is taken for none; and back, without a course, the speed is left out too. Of a hover with course 90 the speed 0 comes
# back as NaN. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts @tak-ps/node-cot@14.23.2
cat >north.mjs <<'JS'
import { readFileSync } from "node:fs";
import { CoTParser } from "@tak-ps/node-cot";

const { version } = JSON.parse(readFileSync("node_modules/@tak-ps/node-cot/package.json"));
const event =
  '<event version="2.0" uid="uav" type="a-f-A-M-H-Q" how="m-g" time="2026-06-01T10:00:00Z" ' +
  'start="2026-06-01T10:00:00Z" stale="2026-06-01T10:05:00Z"><point lat="47" lon="8" hae="500" ce="10" le="10"/>' +
  '<detail><contact callsign="uav"/></detail></event>';
const plain = await CoTParser.to_geojson(CoTParser.from_xml(event));
const seen = [];
for (const [course, speed] of [[0, 10], [1, 10], [90, 0]]) {
  const feature = { ...plain, properties: { ...plain.properties, course, speed } };
  const xml = CoTParser.to_xml(await CoTParser.from_geojson(feature));
  const { properties } = await CoTParser.to_geojson(CoTParser.from_xml(xml));
  seen.push([xml.match(/<track[^>]*>/)[0], `${properties.course} ${properties.speed}`]);
}
console.log(`node-cot ${version}: courses and speeds 0 and 10, 1 and 10, 90 and 0 are`);
console.log(JSON.stringify(seen));
const tracks = ['<track speed="10"/>', '<track course="1" speed="10"/>', '<track course="90"/>'];
const back = ["undefined undefined", "1 10", "90 NaN"];
process.exit(seen.every(([track, read], row) => track === tracks[row] && read === back[row]) ? 0 : 1);
JS
node north.mjs
