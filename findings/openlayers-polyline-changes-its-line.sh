#!/bin/sh
# OpenLayers moves a line off the Earth when it writes it as an encoded polyline.
#
# ol 10.11.0, format/Polyline.writeGeometry. Guess: the line is the same after it was written. Seen: its coordinates are
# exchanged and multiplied by 100,000, 8 E 47 N is at 9400000 E 1600000 N, and a second text is another. With heights
# the text has three numbers a point, and its own reader takes them for pairs: two points are three, the last at 108 E.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund ol@10.11.0 >/dev/null
cat >write.mjs <<'JS'
import Polyline from "ol/format/Polyline.js";
import LineString from "ol/geom/LineString.js";

const format = new Polyline();
const line = new LineString([[8, 47], [8.1, 47.2]]);
const texts = [format.writeGeometry(line)];
const after = JSON.stringify(line.getCoordinates());
texts.push(format.writeGeometry(line));
const climb = JSON.stringify(
  format.readGeometry(format.writeGeometry(new LineString([[8, 47, 0], [8.1, 47.2, 100]]))).getCoordinates(),
);
console.log(`after writing: ${after}; the same text again: ${texts[0] === texts[1]}; a climb is read as ${climb}`);
const asSeen = after === "[[9400000,1600000],[40000,20000]]" && climb === "[[8,47],[8.2,47],[108.2,47.1]]";
process.exit(asSeen && texts[0] !== texts[1] ? 0 : 1);
JS
node write.mjs
