#!/bin/sh
# opencoverage plans a survey at 80 m and writes waypoints 530 m above home.
#
# opencoverage 0.2.0, plan and save_qgc, with an area of a KML whose corners have the altitude of the field, 450 m.
# Guess: the altitudes of the area do not count, or the frame is that above the sea. Seen: 450 + 80 m in frame 3,
# relative to home, and the aircraft's max_height of 120 m is passed. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q opencoverage==0.2.0 shapely==2.2.0 numpy==2.4.1 pyproj==3.7.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version
from pathlib import Path

import opencoverage

ring = " ".join(f"{x},{y},450" for x, y in ((8.54, 47.39), (8.543, 47.39), (8.543, 47.392), (8.54, 47.39)))
outer = f"<outerBoundaryIs><LinearRing><coordinates>{ring}</coordinates></LinearRing></outerBoundaryIs>"
area = f"<Placemark><Polygon><altitudeMode>absolute</altitudeMode>{outer}</Polygon></Placemark>"
Path("field.kml").write_text(f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{area}</Document></kml>')
sensor = {"pixel_size_mm": 0.0032, "focal_length_mm": 8.43, "sensor_width_mm": 6.55, "sensor_height_mm": 4.92}
mission = opencoverage.plan(
    polygon="field.kml",
    uav=opencoverage.UAV(min_height=70, max_height=120, survey_velocity=10),
    camera=opencoverage.PinholeCamera(**sensor, capture_rate_s=3),
    lateral_overlap=0.6,
    forward_overlap=0.7,
    target="altitude",
    target_value=80,
)
mission.save_qgc("field.txt", reference=mission.reference)
rows = [line.split("\t") for line in Path("field.txt").read_text().splitlines()[1:]]
frames, altitudes = {row[2] for row in rows}, {float(row[10]) for row in rows}
print(f"opencoverage {version('opencoverage')}: height {mission.flight_height}, frame {frames}, altitudes {altitudes}")
raise SystemExit(0 if mission.flight_height == 80 and frames == {"3"} and altitudes == {530.0} else 1)
PY
