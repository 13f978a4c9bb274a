#!/bin/sh
# toGeoJSON gives a KML point 30 m above the ground and one 30 m above the sea the same coordinates.
#
# @tmcw/togeojson 7.1.3 with @xmldom/xmldom 0.9.8. Guess: altitudeMode and extrude become properties, as GDAL makes them.
# Seen: three placemarks of modes relativeToGround, absolute and clampToGround are equal but for the name; a zone that is
# extruded to the ground has no mark of it. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @tmcw/togeojson@7.1.3 @xmldom/xmldom@0.9.8 >/dev/null
cat >read.mjs <<'JS'
import { kml } from "@tmcw/togeojson";
import { DOMParser } from "@xmldom/xmldom";

const point = (mode) =>
  `<Placemark><Point><altitudeMode>${mode}</altitudeMode><coordinates>8.5,47.3,30</coordinates></Point></Placemark>`;
const ring = "<LinearRing><coordinates>8,47,60 9,47,60 9,48,60 8,47,60</coordinates></LinearRing>";
const zone = `<Placemark><Polygon><extrude>1</extrude><outerBoundaryIs>${ring}</outerBoundaryIs></Polygon></Placemark>`;
const text = `<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
${["relativeToGround", "absolute", "clampToGround"].map(point).join("")}${zone}</Document></kml>`;
const { features } = kml(new DOMParser().parseFromString(text, "text/xml"));
const points = new Set(features.slice(0, 3).map((feature) => JSON.stringify(feature)));
console.log([...points].join("\n"), "\nproperties of the extruded zone:", JSON.stringify(features[3].properties));
process.exit(points.size === 1 && Object.keys(features[3].properties).length === 0 ? 0 : 1);
JS
node read.mjs
