#!/bin/sh
# Cesium flies 8 m too low half-way between two positions that are 20 km apart.
#
# @cesium/engine 26.3.0, SampledPositionProperty, which also plays CZML. Guess: between two samples at 100 m it is at
# 100 m, as a polyline between them is. Seen: 92.2 m, as it interpolates straight through the Earth; 99.5 m for 5 km; of
# PolylinePipeline's arc 100 m. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @cesium/engine@26.3.0 >/dev/null
cat >fly.mjs <<'JS'
import { Cartesian3, Cartographic, JulianDate, PolylinePipeline, SampledPositionProperty } from "@cesium/engine";

const height = (place) => Math.round(Cartographic.fromCartesian(place).height * 10) / 10;
const lowest = (degrees) => {
  const ends = [Cartesian3.fromDegrees(8, 47, 100), Cartesian3.fromDegrees(8 + degrees, 47, 100)];
  const start = JulianDate.fromIso8601("2026-11-29T12:00:00Z");
  const flown = new SampledPositionProperty();
  ends.forEach((place, n) => flown.addSample(JulianDate.addSeconds(start, 1000 * n, new JulianDate()), place));
  const half = flown.getValue(JulianDate.addSeconds(start, 500, new JulianDate()));
  const arc = PolylinePipeline.generateCartesianArc({ positions: ends, height: 100 });
  return [Math.round(Cartesian3.distance(...ends) / 1000), height(half), Math.min(...arc.map(height))];
};
const seen = JSON.stringify([lowest(5 / 76), lowest(20 / 76)]);
console.log(`km, height half-way and of a polyline [m]: ${seen}`);
process.exit(seen === "[[5,99.5,100],[20,92.2,100]]" ? 0 : 1);
JS
node fly.mjs
