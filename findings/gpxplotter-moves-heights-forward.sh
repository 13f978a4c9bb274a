#!/bin/sh
# One point without a height, and gpxplotter gives each point after it the height of the next.
#
# gpxplotter 0.2.12, read_gpx_file of five points, the second without <ele>, which GPX 1.1 leaves optional. Guess: NaN
# for that point, or five heights with a gap filled. Seen: [400, 500, 450, 400] for five points and times, with no
# warning: 500 m, the height of the third, is second. gpxpy 1.6.2 gives 400, none, 500, 450 and 400. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps gpxplotter==0.2.12
"$folder/venv/bin/pip" install -q numpy==2.4.6 scipy==1.17.1 pandas==3.1.1 matplotlib==3.11.2 folium==0.20.0 \
    branca==0.8.2 scikit-learn==1.9.1 python-dateutil==4.0.0 gpxpy==1.6.2
cd "$folder"
cat >track.gpx <<'GPX'
<?xml version="1.0" encoding="UTF-8"?>
<gpx version="1.1" creator="finding" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>
<trkpt lat="47.000" lon="8"><ele>400</ele><time>2026-06-01T10:00:00Z</time></trkpt>
<trkpt lat="47.001" lon="8"><time>2026-06-01T10:00:10Z</time></trkpt>
<trkpt lat="47.002" lon="8"><ele>500</ele><time>2026-06-01T10:00:20Z</time></trkpt>
<trkpt lat="47.003" lon="8"><ele>450</ele><time>2026-06-01T10:00:30Z</time></trkpt>
<trkpt lat="47.004" lon="8"><ele>400</ele><time>2026-06-01T10:00:40Z</time></trkpt>
</trkseg></trk></gpx>
GPX
./venv/bin/python - <<'PY'
import warnings
from importlib.metadata import version

import gpxpy
from gpxplotter import read_gpx_file

with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    segment = next(read_gpx_file("track.gpx"))["segments"][0]
heights = [float(height) for height in segment["elevation"]]
points = (len(segment["lat"]), len(segment["time"]))
with open("track.gpx") as file:
    expected = [point.elevation for point in gpxpy.parse(file).tracks[0].segments[0].points]
said = [str(warning.message) for warning in caught if "elevation" in str(warning.message).lower()]
print(f"gpxplotter {version('gpxplotter')}: heights {heights} of {points} points; gpxpy {expected}; warnings {said}")
as_seen = heights == [400, 500, 450, 400] and points == (5, 5) and not said
raise SystemExit(0 if as_seen and expected == [400, None, 500, 450, 400] else 1)
PY
