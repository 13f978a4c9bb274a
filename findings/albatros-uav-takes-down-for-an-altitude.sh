#!/bin/sh
# albatros-uav puts a point 50 m above its reference 50 m below the sea, and lowers a vehicle that climbs.
#
# albatros-uav 0.16.0, ned2geo with a PositionNED, whose down is "meters from reference point in down", and
# UAV.get_corrected_position. Guess: down -50 from 100 m is an altitude of 150 m; a vehicle at 50 m that climbs 4 m/s
# is at 54 m one second later. Seen: -50 m, without the reference's altitude; 46 m. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q albatros-uav==0.16.0 pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import time
from importlib.metadata import version
from types import SimpleNamespace

from albatros import uav
from albatros.nav.position import PositionGPS, PositionNED, ned2geo

above = ned2geo(PositionGPS(47, 8, 100), PositionNED(10, 0, -50)).alt_m
now = time.time()
uav.time = SimpleNamespace(time=lambda: now)
message = {"lat": 470000000, "lon": 80000000, "relative_alt": 50_000, "vx": 0, "vy": 0, "vz": -400}
last = SimpleNamespace(timestamp_ms=(now - 1) * 1000, **message)
vehicle = SimpleNamespace(data=SimpleNamespace(global_position_int=last))
later = uav.UAV.get_corrected_position(vehicle).alt_m
print(f"albatros-uav {version('albatros-uav')}: 50 m above 100 m is {above} m; 50 m and 1 s of a climb {later:.1f} m")
raise SystemExit(0 if above == -50 and round(later, 1) == 46 else 1)
PY
