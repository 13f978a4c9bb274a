#!/bin/sh
# gribberish puts the winds of a grid that is stored by columns at other places.
#
# gribberish 0.30.3 as xarray's engine, xarray 2026.9.0; eccodes 2.50.0 writes and knows the places. A grid of 3 rows
# and 4 columns with jPointsAreConsecutive, a scanning mode of GRIB2. Guess: the value at each place is that of eccodes,
# as without that flag. Seen: 2 of 12 are; the wind at 47 N 1 W is found at 48 N 0 E, nothing said. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gribberish==0.30.3 eccodes==2.50.0 xarray==2026.9.0 fsspec==2026.2.0 zarr==3.1.6 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import eccodes
import numpy as np
import xarray


def agreeing(by_columns):
    about = {"discipline": 0, "parameterCategory": 2, "parameterNumber": 2, "typeOfFirstFixedSurface": 103, "level": 10}
    about |= {"Ni": 4, "Nj": 3, "iDirectionIncrementInDegrees": 1, "jDirectionIncrementInDegrees": 1}
    about |= {"latitudeOfFirstGridPointInDegrees": 48, "latitudeOfLastGridPointInDegrees": 46}
    about |= {"longitudeOfFirstGridPointInDegrees": 359, "longitudeOfLastGridPointInDegrees": 2}
    handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib2")
    for key, value in {**about, "jPointsAreConsecutive": by_columns}.items():
        eccodes.codes_set(handle, key, value)
    eccodes.codes_set_values(handle, np.arange(12.0))
    with open("wind.grib2", "wb") as out:
        eccodes.codes_write(handle, out)
    places = zip(eccodes.codes_get_array(handle, "latitudes"), eccodes.codes_get_array(handle, "longitudes"))
    (wind,) = xarray.open_dataset("wind.grib2", engine="gribberish").data_vars.values()
    column = {round(float(east)) % 360: n for n, east in enumerate(wind.longitude)}
    row = {round(float(north)): n for n, north in enumerate(wind.latitude)}
    expected = zip(places, eccodes.codes_get_values(handle))
    return sum(float(wind[0, row[round(n)], column[round(e) % 360]]) == value for (n, e), value in expected)


rows, columns = agreeing(0), agreeing(1)
print(f"gribberish {version('gribberish')}: by rows {rows} of 12 winds at their places, by columns {columns}")
raise SystemExit(0 if (rows, columns) == (12, 2) else 1)
PY
