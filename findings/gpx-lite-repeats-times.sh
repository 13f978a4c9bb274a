#!/bin/sh
# gpx_lite gives each point of a planned track the time at which the file was written.
#
# gpx_lite 0.0.5, parse and iterparse of a GPX track without times, whose metadata have one. Guess: both give points
# without a time. Seen: parse does; iterparse gives each the time of the metadata, and in a log each point without a
# time that of the point before. Heights are dropped by both. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps gpx_lite==0.0.5 tqdm==4.67.1
cd "$folder"
./venv/bin/python - 2>/dev/null <<'PY'
from importlib.metadata import version
from pathlib import Path

import gpx_lite

WRITTEN, FLOWN = "2026-06-01T08:00:00Z", "2026-06-02T10:00:00Z"


def times(read, first):
    points = f'<trkpt lat="47" lon="8">{first}</trkpt><trkpt lat="47.1" lon="8"><ele>500</ele></trkpt>'
    head = f"<metadata><time>{WRITTEN}</time></metadata>"
    track = f"<trk><number>1</number><trkseg>{points}</trkseg></trk>"
    Path("track.gpx").write_text(f'<gpx xmlns="http://www.topografix.com/GPX/1/1">{head}{track}</gpx>')
    with open("track.gpx") as file:
        (line,) = read(file).tracks
    return [point._time for segment in line.segments for point in segment.points]


log = f"<time>{FLOWN}</time>"
seen = [[times(read, first) for first in ("", log)] for read in (gpx_lite.parse, gpx_lite.iterparse)]
print(f"gpx_lite {version('gpx_lite')}: plan and log of parse {seen[0]}, of iterparse {seen[1]}")
as_seen = seen[0] == [[None, None], [FLOWN, None]]
raise SystemExit(0 if as_seen and seen[1] == [[WRITTEN, WRITTEN], [FLOWN, FLOWN]] else 1)
PY
