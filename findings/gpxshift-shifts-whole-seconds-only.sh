#!/bin/sh
# gpxshift saves a log of five positions a second with one of five times shifted, while its screen shows all of them.
#
# gpxshift 0.0.1, GPXShiftApp.shift_time and save_gpx. Guess: 2 hours are added to each time. Seen: only to times of
# whole seconds with a Z; 10:00:00.200Z and a time with +02:00 stay, so the points are out of order. Nothing is said.
# current_gpx, which is shown before saving, has all times shifted. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gpxshift==0.0.1 gpxpy==1.6.2 rich==14.2.0
cd "$folder"
./venv/bin/python - <<'PY'
import io
from importlib.metadata import version
from pathlib import Path

import gpxpy
from gpxshift import GPXShiftApp

TIMES = ("10:00:00Z", "10:00:00.200Z", "12:00:01+02:00")


def seconds(track):
    """Seconds after the first time of the log."""
    times = [point.time.timestamp() for point in track.tracks[0].segments[0].points]
    return [round(time - start, 1) for time in times]


points = "".join(f'<trkpt lat="47" lon="8"><time>2026-06-01T{time}</time></trkpt>' for time in TIMES)
head = '<gpx version="1.1" creator="log" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
Path("log.gpx").write_text(f"{head}{points}</trkseg></trk></gpx>")
app = GPXShiftApp("log.gpx")
start = app.original_gpx.tracks[0].segments[0].points[0].time.timestamp()
app.shift_time(2)
shown, saved = seconds(app.current_gpx), seconds(gpxpy.parse(io.StringIO(app.save_gpx().read_text())))
print(f"gpxshift {version('gpxshift')}: seconds after the first, shown {shown}, saved {saved}")
raise SystemExit(0 if shown == [7200, 7200.2, 7201] and saved == [7200, 0.2, 1] else 1)
PY
