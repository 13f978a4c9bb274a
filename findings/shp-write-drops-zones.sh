#!/bin/sh
# @mapbox/shp-write loses all single zones of a map that has a zone of two parts, too.
#
# @mapbox/shp-write 0.4.3, zip; shpjs 6.2.0 reads. Guess: three zones, of which one is a MultiPolygon, are three records
# of a shapefile. Seen: one. Polygon and MultiPolygon are written to one name in the archive, the second over the first,
# and lines likewise; nothing is said. Each kind by itself is whole. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @mapbox/shp-write@0.4.3 shpjs@6.2.0 >/dev/null
cat >zones.mjs <<'JS'
import write from "@mapbox/shp-write";
import read from "shpjs";

const square = (east) => [[[east, 47], [east, 48], [east + 1, 48], [east + 1, 47], [east, 47]]];
const zone = (name, type, coordinates) => ({ type: "Feature", properties: { name }, geometry: { type, coordinates } });
const names = async (features) => {
  const options = { outputType: "arraybuffer", compression: "STORE" };
  const archive = await write.zip({ type: "FeatureCollection", features }, options);
  const layers = [await read(archive)].flat();
  return layers.flatMap((layer) => layer.features.map((feature) => feature.properties.name)).join();
};
const single = [zone("airport", "Polygon", square(0)), zone("prison", "Polygon", square(2))];
const double = zone("park", "MultiPolygon", [square(4), square(6)]);
const lines = [zone("cable", "LineString", square(0)[0]), zone("fence", "MultiLineString", square(2))];
const seen = [await names(single), await names([...single, double]), await names(lines)];
console.log(`zones read back: ${seen[0]} of 2, ${seen[1]} of 3; lines: ${seen[2]} of 2`);
process.exit(seen.join(";") === "airport,prison;park;fence" ? 0 : 1);
JS
node zones.mjs
