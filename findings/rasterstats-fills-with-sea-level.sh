#!/bin/sh
# rasterstats counts cells beyond the edge of an elevation model as ground at 0 m.
#
# rasterstats 0.21.0, rasterio 1.4.4, zonal_stats on a GeoTIFF without a nodata value, all of it at 1500 m. Guess: what
# is outside does not count, or is None. Seen: the lowest ground of an area half outside is 0 m, its mean 750 m; far
# away from the raster the highest ground is 0 m, of 100 cells. Only a warning of a nodata value of -999 is given; 0 is
# not that. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rasterstats==0.21.0 rasterio==1.4.4 shapely==2.2.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY' 2>/dev/null
from importlib.metadata import version

import numpy as np
import rasterio
import shapely
from rasterio.transform import from_origin
from rasterstats import zonal_stats

about = {"driver": "GTiff", "width": 10, "height": 10, "count": 1, "dtype": "int16", "crs": "EPSG:4326"}
with rasterio.open("ground.tif", "w", transform=from_origin(8, 47, 0.01, 0.01), **about) as out:
    out.write(np.full((1, 10, 10), 1500, "int16"))
areas = shapely.box(8.05, 46.92, 8.15, 46.98), shapely.box(9, 46.9, 9.1, 47)
half, outside = zonal_stats(areas, "ground.tif", stats="min max mean count")
print(f"rasterstats {version('rasterstats')}: half outside {half}, outside {outside}")
as_seen = (half["min"], half["max"], half["mean"], outside["max"], outside["count"]) == (0, 1500, 750, 0, 100)
raise SystemExit(0 if as_seen else 1)
PY
