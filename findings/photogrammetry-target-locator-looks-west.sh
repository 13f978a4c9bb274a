#!/bin/sh
# photogrammetry-target-locator looks west for north, and ignores the heading of a camera that looks straight down.
#
# photogrammetry-target-locator 0.1.2, calculate_target_coordinates from 100 m above level ground, 60 by 45 degrees of
# view; its web service of heights is replaced by 0 m. Guess, pitch -90: the lower side of a picture is south with
# heading 0 and west with 90. Seen: north with each. Guess, pitch -120 as in its README: the center is north of the
# camera with heading 0, east with 90. Seen: 174 m west, and 174 m south. Pitch -45 is an error.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q photogrammetry-target-locator==0.1.2 numpy==2.4.6 pyproj==3.7.2 requests==2.34.2
cd "$folder"
cat >look.py <<'PY'
from importlib.metadata import version

from photogrammetry_target_locator import photogrammetry
from pyproj import Geod

photogrammetry.USGSElevationService.get_elevation = lambda service, lat, lon: 0.0


def look(heading, pitch, x, y):
    camera = {
        "position": {"latitude": 47.0, "longitude": 8.0, "altitude": 100.0, "heading": heading},
        "orientation": {"roll": 0.0, "pitch": pitch, "yaw": 0.0},
        "intrinsics": {
            "field_of_view": {"horizontal_degrees": 60.0, "vertical_degrees": 45.0},
            "sensor_size": {"width": 2000, "height": 1500},
            "principal_point": {"x": 1000.0, "y": 750.0},
        },
    }
    target = {"pixel_coordinates": {"x": x, "y": y}}
    found = photogrammetry.calculate_target_coordinates({"camera": camera, "target": target})
    if not found["success"]:
        return None
    bearing, _, far = Geod(ellps="WGS84").inv(8, 47, found["target"]["longitude"], found["target"]["latitude"])
    return round(bearing) % 360, round(far)


down = [look(heading, -90.0, 1000, 1300) for heading in (0.0, 90.0)]
ahead = [look(heading, -120.0, 1000, 750) for heading in (0.0, 90.0)]
slanted = look(0.0, -45.0, 1000, 750)
print(f"photogrammetry-target-locator {version('photogrammetry-target-locator')}: bearing and meters of the lower side")
print(f"{down}, expected 180 and 270; of the center at -120 {ahead}, expected 0 and 90; at -45 {slanted}")
raise SystemExit(0 if down == [(0, 31), (0, 31)] and ahead == [(270, 174), (180, 174)] and slanted is None else 1)
PY
./venv/bin/python look.py
