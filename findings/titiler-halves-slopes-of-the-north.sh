#!/bin/sh
# TiTiler's slope of a hillside of 45 degrees is 27 degrees at 60 N.
#
# titiler-core 2.4.0, the algorithm "slope" ("degrees of slope") of a tile by rio-tiler 9.4.12, as its map tiles are
# made. Guess: 45 degrees, as the elevation model has it in meters. Seen: a pixel is taken for as wide as it is in Web
# Mercator, twice its width on the ground at 60 N; at the equator it is 45. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q titiler-core==2.4.0 rio-tiler==9.4.12 rasterio==1.4.4 pyproj==3.7.2 numpy==2.4.6
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import morecantile
import numpy as np
import pyproj
import rasterio
from rio_tiler.io import Reader
from titiler.core.algorithm import algorithms

PIXELS = 800  # of 5 m


def slope(latitude):
    east, north = pyproj.Transformer.from_crs(4326, 32632, always_xy=True).transform(9, latitude)
    place = rasterio.transform.from_origin(east - 2000, north + 2000, 5, 5)
    about = {"width": PIXELS, "height": PIXELS, "count": 1, "dtype": "float32", "crs": "EPSG:32632", "transform": place}
    with rasterio.open("hillside.tif", "w", driver="GTiff", **about) as hillside:
        hillside.write(np.tile(np.arange(PIXELS, dtype="float32") * 5, (PIXELS, 1)), 1)
    tile = morecantile.tms.get("WebMercatorQuad").tile(9, latitude, 14)
    with Reader("hillside.tif") as read:
        image = read.tile(tile.x, tile.y, 14, buffer=3, resampling_method="bilinear", reproject_method="bilinear")
    return round(float(np.ma.median(algorithms.get("slope")()(image).array)))


equator, north = slope(0), slope(60)
print(f"titiler-core {version('titiler-core')}, slope of 45 degrees: {equator} at the equator, {north} at 60 N")
raise SystemExit(0 if (equator, north) == (45, 27) else 1)
PY
