#!/bin/sh
# xarray-spatial gives a hillside that faces south as one that faces north where latitudes rise in the file.
#
# xarray-spatial 0.5.3, aspect and hillshade, xarray 2026.9.0. NetCDF files of terrain often begin in the south. Guess:
# the aspect, in degrees from north, goes by the coordinate y, as slope does for the distance. Seen: 180 degrees for a
# grid from north to south, 0 for the same ground from south to north. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q xarray-spatial==0.5.3 xarray==2026.9.0 numpy==2.4.6
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import numpy as np
import xarray
import xrspatial

y, x = np.arange(0.0, 200.0, 10.0), np.arange(0.0, 200.0, 10.0)
south_side = xarray.DataArray(np.tile(y[:, None], (1, 20)), dims=("y", "x"), coords={"y": y, "x": x})


def seen(ground):
    aspect, slope = (float(of(ground).sel(x=100, y=100)) for of in (xrspatial.aspect, xrspatial.slope))
    light = float(xrspatial.hillshade(ground, azimuth=180, angle_altitude=45).sel(x=100, y=100))
    return round(aspect), round(slope), light > 0.5


north_first, south_first = seen(south_side.sortby("y", ascending=False)), seen(south_side)
print(f"xarray-spatial {version('xarray-spatial')}: aspect, slope and whether the sun in the south lights it,")
print(f"north first {north_first}, south first {south_first}")
raise SystemExit(0 if (north_first, south_first) == ((180, 45, True), (0, 45, False)) else 1)
PY
