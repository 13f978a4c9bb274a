#!/bin/sh
# exifr and exif-parser put a picture from 420 m below the sea 420 m above it.
#
# exifr 7.1.3 and exif-parser 0.1.12, Pillow 13.0.0 writes. Guess: GPSAltitude is -420.3, as both make a latitude
# negative by its "S". Seen: GPSLatitude or latitude is -31.5, GPSAltitude is 420.3 and its sign is left in
# GPSAltitudeRef. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pillow==13.0.0
cd "$folder"
npm install --silent --no-audit --no-fund exifr@7.1.3 exif-parser@0.1.12 >/dev/null
./venv/bin/python - <<'PY'
from PIL import Image

picture = Image.new("RGB", (8, 8))
exif = picture.getexif()
BELOW_SEA = b"\x01"
place = {1: "S", 2: (31.0, 30.0, 0.0), 3: "E", 4: (35.0, 28.0, 0.0), 5: BELOW_SEA, 6: 420.3}
exif.get_ifd(0x8825).update(place)
picture.save("shore.jpg", exif=exif)
PY
cat >read.mjs <<'JS'
import { readFileSync } from "fs";
import exifr from "exifr";
import parser from "exif-parser";

const picture = readFileSync("shore.jpg");
const one = await exifr.parse(picture, { gps: true });
const other = parser.create(picture).parse().tags;
const seen = JSON.stringify([one.latitude, one.GPSAltitude, other.GPSLatitude, other.GPSAltitude]);
console.log(`latitude and altitude of exifr and exif-parser: ${seen}`);
process.exit(seen === "[-31.5,420.3,-31.5,420.3]" ? 0 : 1);
JS
node read.mjs
