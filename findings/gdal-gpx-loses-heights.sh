#!/bin/sh
# GDAL reads the tracks and routes of a GPX without their heights.
#
# pyogrio 0.13.0 (GDAL 3.12.4). Guess: a track whose points have <ele> is a line with heights. Seen: tracks and routes
# have two coordinates and no field with heights; points alone have a field `ele`. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.2.0 numpy==2.4.1
cd "$folder"
./venv/bin/python - <<'PY'
import warnings
from pathlib import Path

import pyogrio
import shapely

points = ['{{}} lat="47.{0}" lon="8"><ele>53{0}</ele></{{}}>'.format(n) for n in (0, 1)]
route, track = ("".join(f"<{point.format(tag, tag)}" for point in points) for tag in ("rtept", "trkpt"))
shapes = f"<rte>{route}</rte><trk><trkseg>{track}</trkseg></trk>"
head = '<gpx version="1.1" creator="a" xmlns="http://www.topografix.com/GPX/1/1">'
Path("flight.gpx").write_text(f"{head}{shapes}</gpx>")
found = {}
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    for layer in ("routes", "tracks", "track_points"):
        meta, _, read, _ = pyogrio.raw.read("flight.gpx", layer=layer)
        found[layer] = shapely.from_wkb(read[0]).has_z, "ele" in meta["fields"]
print(f"GDAL {pyogrio.__gdal_version_string__}: has z, has ele: {found}, warnings {[str(one.message) for one in said]}")
as_seen = found == {"routes": (False, False), "tracks": (False, False), "track_points": (False, True)}
raise SystemExit(0 if as_seen and not said else 1)
PY
