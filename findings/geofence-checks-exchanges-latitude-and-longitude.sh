#!/bin/sh
# geofence-checks lays a fence near Lucerne into the Gulf of Aden.
#
# geofence-checks 0.1.1, detect_geofence_check_events, a fence from 47.00 to 47.01 N and from 8.00 to 8.01 E. Guess: a
# vehicle at 47.005 N 8.005 E enters it, in each of the three forms that are taken. Seen: no event in any form, without
# an error. A vehicle at 8.005 N 47.005 E enters it, as h3 3.7.6, which it requires, takes latitudes first. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q h3==3.7.6 pandas==2.3.3 numpy==1.26.4 shapely==2.1.2
"$folder/venv/bin/pip" install -q --no-deps geofence-checks==0.1.1
cd "$folder"
./venv/bin/python - <<'PY'
import json
from importlib.metadata import version

import pandas as pd
from geofence_checks import detect_geofence_check_events
from shapely.geometry import Polygon

RING = [[8.0, 47.0], [8.01, 47.0], [8.01, 47.01], [8.0, 47.01], [8.0, 47.0]]
FORMS = {"shapely": Polygon(RING), "GeoJSON": {"type": "Polygon", "coordinates": [RING]}}
FORMS["list"] = json.dumps([{"lat": latitude, "lng": longitude} for longitude, latitude in RING])


def events(form, latitude, longitude):
    times = pd.to_datetime(["2026-01-01 10:00", "2026-01-01 10:01"])
    track = {"truck_no": ["one"] * 2, "latitude": [latitude] * 2, "longitude": [longitude] * 2, "timestamp": times}
    fence = {"geofence_name": "site", "geofence_coordinates": form, "dept_code": "d", "plant_code": "p"}
    fence["geofence_type"] = {"label": "site"}
    return len(detect_geofence_check_events(pd.DataFrame(track), pd.DataFrame([fence]), h3_res=11)[0])


inside = {name: events(form, 47.005, 8.005) for name, form in FORMS.items()}
exchanged = {name: events(form, 8.005, 47.005) for name, form in FORMS.items()}
print(f"geofence-checks {version('geofence-checks')}, h3 {version('h3')}: events inside {inside},")
print(f"at the exchanged place {exchanged}")
raise SystemExit(0 if set(inside.values()) == {0} and set(exchanged.values()) == {1} else 1)
PY
