#!/bin/sh
# tokml writes the heights of GeoJSON into a KML that says to ignore them.
#
# tokml 0.4.0. Guess: a third coordinate comes with an altitudeMode, or a property of that name sets it. Seen: no
# altitudeMode is written; its default is clampToGround, so that a viewer draws a flight at 530 m on the ground. The
# property becomes a row of ExtendedData. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund tokml@0.4.0 >/dev/null
cat >write.cjs <<'JS'
const tokml = require("tokml");
const geometry = { type: "LineString", coordinates: [[8.5, 47.3, 530], [8.6, 47.3, 530]] };
const text = tokml({ type: "Feature", properties: { altitudeMode: "absolute" }, geometry });
console.log(text);
const mode = text.includes("<altitudeMode>");
process.exit(!mode && text.includes("8.5,47.3,530") && text.includes('<Data name="altitudeMode">') ? 0 : 1);
JS
node write.cjs
