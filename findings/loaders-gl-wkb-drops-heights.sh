#!/bin/sh
# @loaders.gl/wkt writes WKB without heights, also where it is asked for them.
#
# @loaders.gl/wkt 4.5.2, WKBWriter. Guess: the height of GeoJSON is written, at least with the option wkb.hasZ. Seen: 21
# bytes, a point in two dimensions, in both cases; its reader keeps a height of WKB, and its WKT has it. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund @loaders.gl/wkt@4.5.2 @loaders.gl/core@4.5.4 >/dev/null
cat >write.mjs <<'JS'
import { encodeSync, encodeTextSync, parseSync } from "@loaders.gl/core";
import { WKBLoader, WKBWriter, WKTWriter } from "@loaders.gl/wkt";

const mast = { type: "Point", coordinates: [8, 47, 100] };
const sizes = [encodeSync(mast, WKBWriter), encodeSync(mast, WKBWriter, { wkb: { hasZ: true } })];
sizes.push(WKBWriter.encodeSync(mast, { wkb: { hasZ: true } }));
const high = new DataView(new ArrayBuffer(29));
high.setUint8(0, 1);
high.setUint32(1, 1001, true);
mast.coordinates.forEach((value, n) => high.setFloat64(5 + 8 * n, value, true));
const read = JSON.stringify(parseSync(high.buffer, WKBLoader).coordinates);
const text = encodeTextSync(mast, WKTWriter);
console.log(`bytes of WKB: ${sizes.map((bytes) => bytes.byteLength)}; one with a height is ${read}; WKT ${text}`);
process.exit(sizes[0].byteLength === 21 && sizes[1].byteLength === 21 && read === "[8,47,100]" ? 0 : 1);
JS
node write.mjs
