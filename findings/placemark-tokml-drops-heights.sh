#!/bin/sh
# @placemarkio/tokml writes a flight without its heights.
#
# @placemarkio/tokml 0.3.9. Guess: the third number of a GeoJSON position is the altitude of the KML position, as in
# tokml. Seen: positions of 530 m are written with two numbers, the top of a zone, too; nothing is said. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @placemarkio/tokml@0.3.9 >/dev/null
cat >write.mjs <<'JS'
import { toKML } from "@placemarkio/tokml";

const ring = [[9, 47, 120], [9.1, 47, 120], [9.1, 47.1, 120], [9, 47, 120]];
const geometries = [
  { type: "LineString", coordinates: [[8, 47, 530], [8.5, 47, 530]] },
  { type: "Polygon", coordinates: [ring] },
];
const features = geometries.map((geometry) => ({ type: "Feature", properties: {}, geometry }));
const text = toKML({ type: "FeatureCollection", features });
const written = [...text.matchAll(/<coordinates>([^<]*)</g)].map((match) => match[1].split(/\s+/).join(" "));
console.log(written.join(" | "));
process.exit(`${written}` === "8,47 8.5,47,9,47 9.1,47 9.1,47.1 9,47" ? 0 : 1);
JS
node write.mjs
