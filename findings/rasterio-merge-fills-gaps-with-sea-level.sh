#!/bin/sh
# rasterio's merge makes the ground between two tiles 0 m high.
#
# rasterio 1.4.4, merge.merge. Two tiles of elevation at 500 and 600 m, without a nodata value, with a tile missing
# between them. Guess: the gap is masked, NaN, or named. Seen: it is 0 m, and the result has no nodata value that would
# tell it from ground at sea level. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rasterio==1.4.4 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import numpy as np
import rasterio
from rasterio.merge import merge
from rasterio.transform import from_origin


def tile(path, west, height):
    about = {"driver": "GTiff", "width": 10, "height": 10, "count": 1, "dtype": "float32", "crs": "EPSG:4326"}
    with rasterio.open(path, "w", **about, transform=from_origin(west, 47.0, 0.001, 0.001)) as out:
        out.write(np.full((10, 10), height, "float32"), 1)


tile("west.tif", 8.0, 500.0)
tile("east.tif", 8.02, 600.0)
merge(["west.tif", "east.tif"], dst_path="both.tif")
with rasterio.open("both.tif") as both:
    row, nodata = both.read(1)[0], both.nodata
    masked = int((both.read_masks(1) == 0).sum())
print(f"rasterio {rasterio.__version__}: heights of a row {np.unique(row)}, nodata {nodata}, {masked} cells masked")
raise SystemExit(0 if list(row[10:20]) == [0.0] * 10 and nodata is None and masked == 0 else 1)
PY
