#!/bin/sh
# geopy reads "47.375, 8.5083, 500" as 8.5 N 140 E.
#
# geopy 2.5.0, Point from a text, as every distance takes one. Guess: the third number is the height, or the text is
# refused. Seen: a height without a unit makes the second number the latitude and the third the longitude, 500 less 360;
# with "500m" it is right. "47 22.5 N 8 30.5 E", degrees and minutes, is 8 N 30.5 E. Nothing is raised. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q geopy==2.5.0 geographiclib==2.1
cd "$folder"
./venv/bin/python - <<'PY'
import geopy

texts = "47.375, 8.5083, 500", "47.375, 8.5083, 500m", "47 22.5 N 8 30.5 E"
read = {text: tuple(round(number, 6) for number in geopy.Point(text)) for text in texts}
print(f"geopy {geopy.__version__}: {read}")
as_seen = [*read.values()] == [(8.5083, 140.0, 0.0), (47.375, 8.5083, 0.5), (8.0, 30.5, 0.0)]
raise SystemExit(0 if as_seen else 1)
PY
