#!/bin/sh
# Three parsers of coordinates turn -0 degrees 7 minutes into +0 degrees 7 minutes.
#
# geo-coordinates-parser 1.7.4, coordinate-parser 1.0.7 and dms-conversion 3.1.4. Guess: the sign of -0 degrees is kept.
# Seen: 51 28' 40", -0 7' 39" is read as 0.1275 degrees east; a place in London moves 17.7 km. dms-conversion adds the
# minutes to any negative degree: -1 7' 39" becomes -0.8725. parse-dms 0.0.5 is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund geo-coordinates-parser@1.7.4 coordinate-parser@1.0.7 dms-conversion@3.1.4 \
  parse-dms@0.0.5 >/dev/null
cat >read.mjs <<'JS'
import CoordinateParser from "coordinate-parser";
import * as dms from "dms-conversion";
import * as parser from "geo-coordinates-parser";
import parseDms from "parse-dms";

const longitudes = (west) => {
  const both = `51° 28' 40", ${west}`;
  return [
    parser.convert(both).decimalLongitude,
    new CoordinateParser(both).getLongitude(),
    (dms.parseDms ?? dms.default.parseDms)(west),
    parseDms(both).lon,
  ].map((degrees) => degrees.toFixed(4));
};
const [zero, one] = [longitudes(`-0° 7' 39"`), longitudes(`-1° 7' 39"`)];
console.log(`-0 degrees: ${zero}\n-1 degree: ${one}`);
const expected = ["0.1275,0.1275,0.1275,-0.1275", "-1.1275,-1.1275,-0.8725,-1.1275"];
process.exit(`${zero}` === expected[0] && `${one}` === expected[1] ? 0 : 1);
JS
node read.mjs
