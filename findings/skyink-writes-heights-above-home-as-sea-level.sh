#!/bin/sh
# skyink writes a flight 30 m above home to KML and CSV as one 30 m above the sea, 458 m under ground.
#
# skyink 1.0.7, export_mission of waypoints of its CoordinateTransformer, over a home at 488 m. Guess: KML and CSV have
# 518 m, as their altitudes are "absolute" and "Altitude_MSL", or the KML is relative to the ground. Seen: 30 m in both,
# beside the home at 488 m in the same list; the plan for QGroundControl has 30 m in frame 3, above home. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymap3d==3.2.0 numpy==2.4.6
"$folder/venv/bin/pip" install -q --no-deps skyink==1.0.7
cd "$folder"
./venv/bin/python - <<'PY'
import csv
import json
import re
from importlib.metadata import version
from pathlib import Path

from skyink.coord_transformer import CoordinateTransformer
from skyink.format_exporters import export_mission

home = 47.397, 8.545, 488.0
waypoints = CoordinateTransformer(*home).path_to_gps([(0, 0), (0, 50)], altitude=30)
for kind in ("plan", "kml", "csv"):
    export_mission(waypoints, home, f"text.{kind}", format=kind)
items = json.loads(Path("text.plan").read_text())["mission"]["items"]
plan = {(item["frame"], item["params"][6]) for item in items if item["command"] == 16}
text = Path("text.kml").read_text()
path = re.search(r"<LineString>.*?</LineString>", text, re.S)[0]
kml = re.search(r"<altitudeMode>(\w+)<", path)[1], re.findall(r",([\d.]+)(?=\s|<)", path)
rows = [(row["Waypoint"], row["Altitude_MSL"]) for row in csv.DictReader(Path("text.csv").open())]
print(f"skyink {version('skyink')}: plan, frame and height {plan}; KML {kml}; CSV, above the sea {rows}")
as_seen = plan == {(3, 30)} and kml[0] == "absolute" and rows[0] == ("HOME", "488.00") and rows[1] == ("WP1", "30.00")
raise SystemExit(0 if as_seen and kml[1] == ["30", "30"] else 1)
PY
