#!/bin/sh
# gpx-etl measures 1001 km for two flights of 0.4 km with one name, and nothing of a flight without a name.
#
# gpx-etl 0.0.2, GPXTransformer.stats. Guess: each track of a GPX file has its own distance, duration and speeds. Seen:
# two tracks of one name at the same times, 111 km apart, become one that jumps from one to the other, with infinite
# speeds. A track without a <name>, which GPX lets be left out, has neither distance nor duration. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps gpx-etl==0.0.2 gpxpy==1.6.2
"$folder/venv/bin/pip" install -q pandas==2.3.3 numpy==2.3.5
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
import math
from importlib.metadata import version

from gpx_etl.transform import GPXTransformer


def track(latitude, name):
    points = "".join(
        f'<trkpt lat="{latitude + index / 1000:.3f}" lon="8"><ele>100</ele>'
        f"<time>2026-06-01T10:00:{10 * index:02}Z</time></trkpt>"
        for index in range(5)
    )
    return f"<trk>{name}<trkseg>{points}</trkseg></trk>"


def kilometers(*tracks):
    head = '<gpx version="1.1" creator="log" xmlns="http://www.topografix.com/GPX/1/1">'
    stats = GPXTransformer.from_xml(head + "".join(tracks) + "</gpx>").stats
    return [round(float(distance) / 1000, 1) for distance in stats["total_distance"].unique()]


name = "<name>survey</name>"
one, two, unnamed = kilometers(track(47, name)), kilometers(track(47, name), track(48, name)), kilometers(track(47, ""))
print(f"gpx-etl {version('gpx-etl')}, kilometers: one track {one}, two of one name {two}, one without a name {unnamed}")
raise SystemExit(0 if one == [0.4] and two == [1001.4] and math.isnan(unnamed[0]) else 1)
PY
