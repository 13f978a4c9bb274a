#!/bin/sh
# cfgrib gives a grid that ends at Greenwich longitudes in another order than its values.
#
# cfgrib 0.9.15.1, eccodes 2.50.0. Guess: the coordinate of a grid from 350 to 0 degrees is in the order of the values.
# Seen: the coordinate begins 0, 350, 350.25, the values begin at 350: the value for 0 degrees is that of 350 degrees,
# without a word. eccodes' own key `longitudes` is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cfgrib==0.9.15.1 eccodes==2.50.0 xarray==2026.9.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import eccodes
import numpy as np
import xarray

handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
grid = {"numberOfDataPoints": 41 * 9, "Ni": 41, "Nj": 9, "iDirectionIncrementInDegrees": 0.25}
grid |= {"jDirectionIncrementInDegrees": 0.25, "latitudeOfFirstGridPointInDegrees": 52.0, "discipline": 0}
grid |= {"longitudeOfFirstGridPointInDegrees": 350.0, "latitudeOfLastGridPointInDegrees": 50.0}
grid |= {"longitudeOfLastGridPointInDegrees": 0.0, "parameterCategory": 2, "parameterNumber": 2, "bitsPerValue": 24}
for key, value in {**grid, "typeOfFirstFixedSurface": 103, "level": 10}.items():
    eccodes.codes_set(handle, key, value)
longitudes = eccodes.codes_get_array(handle, "longitudes")
eccodes.codes_set_values(handle, longitudes)  # each value is its own longitude
with open("wind.grib2", "wb") as out:
    eccodes.codes_write(handle, out)
data = xarray.open_dataset("wind.grib2", engine="cfgrib", backend_kwargs={"indexpath": ""}, decode_timedelta=True)
at_greenwich = float(data.u10.sel(longitude=0.0, latitude=51.0))
print(f"cfgrib {version('cfgrib')}: longitudes begin {data.longitude.values[:3]}, value at 0 degrees {at_greenwich:g}")
raise SystemExit(0 if round(at_greenwich) == 350 and np.isclose(longitudes[40], 0.0) else 1)
PY
