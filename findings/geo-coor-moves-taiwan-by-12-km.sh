#!/bin/sh
# geo-coor moves a place in Taiwan by 11 to 12 km between degrees and TWD97.
#
# geo-coor 0.0.0, wgs84_2_twd97 and twd97_2_wgs84, and pyproj 3.7.2 (EPSG:3826). Guess: Taipei is within 1 m. Seen: 12.5
# km too far to the north, 11.4 km at 22 N, as each degree of latitude counts 111.133 km; the way back errs as much to
# the south. Both ways agree with each other, so a test back and forth shows nothing. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q geo-coor==0.0.0 pyproj==3.7.2 pandas==2.3.3 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from geo_coor.core import GeoCoordinate
from pyproj import Transformer

to_grid = Transformer.from_crs(4326, 3826, always_xy=True).transform
own = GeoCoordinate()


def errors(longitude, latitude):
    """Kilometers between both libraries, to the grid and back."""
    grid = to_grid(longitude, latitude)
    there = math.dist(grid, own.wgs84_2_twd97(longitude, latitude))
    back = math.dist(grid, to_grid(*own.twd97_2_wgs84(*grid)))
    return round(there / 1000, 1), round(back / 1000, 1)


seen = {"Taipei, 25 N": errors(121.5, 25), "22 N": errors(121, 22)}
print(f"geo-coor {version('geo-coor')}, kilometers off: {seen}")
raise SystemExit(0 if list(seen.values()) == [(12.5, 12.4), (11.4, 11.3)] else 1)
PY
