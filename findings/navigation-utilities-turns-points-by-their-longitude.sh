#!/bin/sh
# navigation-utilities puts a point that is 141 m to the north-east at 55 degrees, and in Sydney in the north-west.
#
# navigation-utilities 0.2.2, Gngga.to_coordinate, "bidimensional (x, y) coordinate". Guess: a place 100 m east and 100
# m north of the origin is at (100, 100). Seen: (116, 80) at 47 N 8 E, (-103, 97) at 34 S 151 E, and (0, 141) on the
# meridian of 90 degrees, as the bearing takes the cosine of the longitude for that of the latitude; distances are
# right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q navigation-utilities==0.2.2 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from navigation_utilities.gngga import Gngga

METERS = 6371000 * math.pi / 180


def coordinate(latitude, longitude):
    """Of the place 100 m to the north and to the east, by its GGA sentence."""
    north, east = latitude + 100 / METERS, longitude + 100 / METERS / math.cos(math.radians(latitude))
    fields = []
    for degrees, width, letters in ((north, 2, "NS"), (east, 3, "EW")):
        whole, minutes = divmod(abs(degrees) * 60, 60)
        fields += [f"{int(whole):0{width}}{minutes:010.7f}", letters[degrees < 0]]
    sentence = f"$GNGGA,120000.00,{','.join(fields)},4,12,0.8,500.0,M,47.0,M,,*00"
    place = Gngga(sentence).to_coordinate(latitude, longitude)
    return [round(place.x), round(place.y)]


seen = [coordinate(*origin) for origin in ((47, 8), (-34, 151), (47, 90))]
print(f"navigation-utilities {version('navigation-utilities')}, at 47 N 8 E, 34 S 151 E and 47 N 90 E: {seen}")
raise SystemExit(0 if seen == [[116, 80], [-103, 97], [0, 141]] else 1)
PY
