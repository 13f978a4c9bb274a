#!/bin/sh
# pymfx writes the speed of a DJI log as its altitude, and loses all courses.
#
# pymfx 1.0.1, from_dji_csv of an AirData log, write and parse. Guess: what is written is read again, and no altitude
# stays none. Seen: rows have the values that are there, one after the other, under a header of eight columns. Where a
# height is empty, 20 mph become an altitude of 8.941 m; courses, pitch and roll are none. validate refuses the file
# that pymfx wrote, and its date is 1970, as this log has milliseconds, too. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymfx==1.0.1
cd "$folder"
cat >flown.csv <<'CSV'
time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),speed(mph),compass_heading(degrees)
0,2025-06-01 10:00:00,47.0000,8.0,100,10,90
100,2025-06-01 10:00:00,47.0001,8.0,,20,91
200,2025-06-01 10:00:00,47.0002,8.0,110,30,92
CSV
./venv/bin/python - <<'PY'
from importlib.metadata import version
from pathlib import Path

import pymfx
from pymfx.convert.from_dji_csv import from_dji_csv


def rows(flight):
    return [(point.alt_m, point.speed_ms, point.heading) for point in flight.trajectory.points]


flown = from_dji_csv(Path("flown.csv"))
again = pymfx.parse(pymfx.write(flown))
print(f"pymfx {version('pymfx')}, altitudes, speeds and courses: {rows(flown)}, as written {rows(again)}")
print(f"date {flown.meta.date_start}; {pymfx.validate(again)}")
as_read = rows(flown) == [(30.48, 4.47, 90), (None, 8.941, 91), (33.528, 13.411, 92)]
as_seen = rows(again) == [(30.48, 4.47, None), (8.941, None, None), (33.528, 13.411, None)]
raise SystemExit(0 if as_read and as_seen and flown.meta.date_start.startswith("1970") else 1)
PY
