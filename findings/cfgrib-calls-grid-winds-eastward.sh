#!/bin/sh
# cfgrib names a wind along the axes of a turned grid "eastward_wind".
#
# cfgrib 0.9.15.1, eccodes 2.50.0, on a Lambert grid whose components are along its axes (uvRelativeToGrid 1). Guess:
# the standard_name is x_wind, or the wind is turned. Seen: eastward_wind and northward_wind, unturned. At 123 W the
# grid is turned by 15.9 degrees, and so is the wind that a reader of the CF name takes. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cfgrib==0.9.15.1 eccodes==2.50.0 xarray==2026.9.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import math

import eccodes
import numpy as np
import xarray

grid = {"gridType": "lambert", "Nx": 5, "Ny": 5, "latitudeOfFirstGridPointInDegrees": 37.0, "LaDInDegrees": 38.5}
grid |= {"longitudeOfFirstGridPointInDegrees": 237.0, "LoVInDegrees": 262.5, "DxInMetres": 3000, "DyInMetres": 3000}
grid |= {"Latin1InDegrees": 38.5, "Latin2InDegrees": 38.5, "uvRelativeToGrid": 1, "jScansPositively": 1}
with open("wind.grib2", "wb") as out:
    for number, speed in ((2, 10.0), (3, 0.0)):
        handle = eccodes.codes_grib_new_from_samples("regular_ll_pl_grib2")
        for key, value in {**grid, "discipline": 0, "parameterCategory": 2, "parameterNumber": number}.items():
            eccodes.codes_set(handle, key, value)
        eccodes.codes_set_values(handle, np.full(25, speed))
        eccodes.codes_write(handle, out)
data = xarray.open_dataset("wind.grib2", engine="cfgrib", backend_kwargs={"indexpath": ""}, decode_timedelta=True)
u, v = data.u, data.v
names, turned = (u.standard_name, v.standard_name), (237.0 - 262.5) * math.sin(math.radians(38.5))
wind = float(u[0, 0]), float(v[0, 0])
print(f"{names}: {wind} m/s, uvRelativeToGrid {u.GRIB_uvRelativeToGrid}, grid turned by {turned:.1f} degrees")
is_as_stated = names == ("eastward_wind", "northward_wind") and wind == (10.0, 0.0) and u.GRIB_uvRelativeToGrid == 1
raise SystemExit(0 if is_as_stated else 1)
PY
