#!/bin/sh
# adsb-tools has no nearest aircraft for a receiver at Greenwich, and bearings of 24 degrees for 16 beside it.
#
# adsb-tools 0.1.55, Aircraft with a receiver at 51.48 N and a list of two aircraft. Guess: both have a distance at each
# longitude of the receiver. Seen: at 0 degrees there is none, as 0 counts as no longitude; at 0.001 there are both. The
# bearing of 24 degrees is one between degrees of latitude and longitude; that of the ground is 16. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q adsb-tools==0.1.55 pyproj==3.7.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from adsb_tools.aircraft import Aircraft
from pyproj import Geod

PLACES = [(51.48, 0.1), (51.5, 0.01)]


class Received(Aircraft):
    """Aircraft of a list in place of a receiver's page."""

    def get_aircraft_list(self):
        return [{"hex": f"400a0{index}", "lat": lat, "lon": lon} for index, (lat, lon) in enumerate(PLACES)]


def nearest(longitude):
    return Received("", 51.48, longitude).nearest_aircraft


beside = nearest(0.001)
seen = beside["distance"]["degrees"]
expected = Geod(ellps="WGS84").inv(0.001, 51.48, PLACES[1][1], PLACES[1][0])[0]
print(f"adsb-tools {version('adsb-tools')}: at 0 degrees {nearest(0.0)}, at 0.001 {beside['hex']}")
print(f"bearing {seen:.0f} degrees, of PROJ {expected:.0f}")
raise SystemExit(0 if nearest(0.0) == {} and round(seen) == 24 and round(expected) == 16 else 1)
PY
