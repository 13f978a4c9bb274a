#!/bin/sh
# swiftnav-gnss gives a receiver at the North Pole a latitude of 1.57 degrees.
#
# swiftnav-gnss 0.5.1, llh_from_ecef, whose result is in degrees, and azimuth_elevation_from_ecef. Guess: the pole in
# ECEF is at 90 degrees, as a place 1 m beside it, and a satellite above it has an elevation of 90 degrees. Seen: the
# latitude is 1.5708, in radians, and -1.5708 at the South Pole; the elevation is 1.57 degrees. Beside the pole both are
# right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q swiftnav-gnss==0.5.1 numpy==1.26.4 pandas==2.3.3
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from gnss.coord_system import azimuth_elevation_from_ecef, llh_from_ecef

POLE = 6356752.314245179
latitudes = [round(float(llh_from_ecef((x, 0.0, z))[0]), 4) for x, z in ((0.0, POLE), (0.0, -POLE), (1.0, POLE))]
above = (0.0, 0.0, 26.6e6)
elevations = [round(float(azimuth_elevation_from_ecef(above, (x, 0.0, POLE))[1]), 2) for x in (0.0, 1.0)]
print(f"swiftnav-gnss {version('swiftnav-gnss')}: latitudes at both poles and 1 m beside one {latitudes};")
print(f"elevations of a satellite above the pole, from it and from 1 m beside {elevations}")
raise SystemExit(0 if latitudes == [1.5708, -1.5708, 90] and elevations == [1.57, 90] else 1)
PY
