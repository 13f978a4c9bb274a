#!/bin/sh
# aerocore's distance along a parallel at 60 N is half of the true one, and its ECEF places are 7 km too deep.
#
# aerocore 0.2.2, geo.distance, "Haversine great circle distance", and lla_to_ecef, "equivalent to epsg:4979 +proj=cart
# +ellps=WGS84". Guess: within 0.5 % of an ellipsoid, and within 1 mm of PROJ. Seen: 100 km to the east are 49.8 km at
# 60 N and 68.0 km at 47 N, as the cosines are squared, too; to the north 100.0. A place comes out 7.1 km below its own,
# as the mean radius is taken for the equatorial one. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q aerocore==0.2.2 typing_extensions==4.15.0 pyproj==3.7.2 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from aerocore import geo
from pyproj import Geod, Transformer

WGS84 = Geod(ellps="WGS84")


def kilometers(latitude, course):
    """aerocore's distance, in km, of the place 100 km away."""
    longitude, other, _ = WGS84.fwd(8, latitude, course, 100_000)
    radians = (math.radians(angle) for angle in (8, latitude, longitude, other))
    return round(geo.distance(*radians, xp=None) / 1000, 1)


east = [kilometers(latitude, 90) for latitude in (0, 47, 60)]
north = kilometers(47, 0)
place = geo.lla_to_ecef(math.radians(8), math.radians(47), 500.0, xp=None)
true = Transformer.from_crs(4979, 4978, always_xy=True).transform(8, 47, 500)
deep = round(math.dist(place, true) / 1000, 1)
print(f"aerocore {version('aerocore')}: 100 km east at 0, 47 and 60 N are {east} km, north {north}; ECEF {deep} km off")
raise SystemExit(0 if east == [99.9, 68.0, 49.8] and north == 100.0 and deep == 7.1 else 1)
PY
