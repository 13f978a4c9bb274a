#!/bin/sh
# netcdfjs gives one value too many of packed winds, and not in m/s.
#
# netcdfjs 4.0.0, getDataVariable; scipy 1.17.1 writes the file: three winds of 6, none and 0 m/s, packed in 16 bits
# with scale_factor 0.01, add_offset 5 and _FillValue. Guess: 6, NaN and 0. Seen: 100, -32768 and -500, the packed
# numbers, and a fourth value, which is the padding at the end of the variable. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q scipy==1.17.1 numpy==2.4.6
cd "$folder"
npm install --silent --no-audit --no-fund netcdfjs@4.0.0 >/dev/null
./venv/bin/python - <<'PY'
import numpy as np
from scipy.io import netcdf_file

with netcdf_file("wind.nc", "w") as data:
    data.createDimension("point", 3)
    wind = data.createVariable("u", "h", ("point",))
    wind.scale_factor, wind.add_offset, wind._FillValue, wind.units = 0.01, 5.0, np.int16(-32768), "m s-1"
    wind[:] = np.array([100, -32768, -500], "h")
PY
cat >read.mjs <<'JS'
import { readFileSync } from "fs";
import { NetCDFReader } from "netcdfjs";

const reader = new NetCDFReader(readFileSync("wind.nc"));
const values = reader.getDataVariable("u");
console.log(`${reader.dimensions[0].size} points, ${values.length} values: ${values}`);
process.exit(values.length === 4 && `${values.slice(0, 3)}` === "100,-32768,-500" ? 0 : 1);
JS
node read.mjs
