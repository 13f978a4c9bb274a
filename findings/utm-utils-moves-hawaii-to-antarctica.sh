#!/bin/sh
# utm-utils gives Hawaii's UTM zone 4 the code of a map of Antarctica.
#
# utm-utils 0.6.1, getCodeFromProjString and getCodeFromEsriWKT; pyproj 3.7.2 names the codes. Guess: getProjString of
# 32604, "+proj=utm +zone=4", has that code again. Seen: 3264, "WGS 84 / SCAR IMW ST17-20" at 76 to 80 S. The zero of
# zones 1 to 9 is left out; zone 4 of NAD83 is 2694, a zone of Russia. 10 to 60 are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyproj==3.7.2
cd "$folder"
npm install --silent --no-audit --no-fund utm-utils@0.6.1 >/dev/null
cat >codes.cjs <<'JS'
const { getCodeFromEsriWKT, getCodeFromProjString, getProjString } = require("utm-utils");

const back = (code) => getCodeFromProjString(getProjString(code));
const esri = getCodeFromEsriWKT('PROJCS["WGS_1984_UTM_Zone_4N",GEOGCS["GCS_WGS_1984"]]');
console.log([back(32604), esri, back(26904), back(32632), back(32756)].join(" "));
JS
codes=$(node codes.cjs)
# shellcheck disable=SC2086
names=$(./venv/bin/python - $codes <<'PY'
import sys

import pyproj

print("; ".join(pyproj.CRS(int(code)).name for code in sys.argv[1:]))
PY
)
echo "32604, zone 4 of ESRI, 26904, 32632 and 32756 are $codes: $names"
[ "$codes" = "3264 3264 2694 32632 32756" ]
