#!/bin/sh
# geobuf of PyPI drops the heights of lines and areas, and keeps those of points.
#
# geobuf 2.0.1, encode; decode by itself. Guess: 3 numbers a position come back, as with npm's geobuf. Seen: a climb
# from 100 to 200 m has no heights, a point has; encode's third argument, 3 dimensions, keeps them. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q geobuf==2.0.1
cd "$folder"
./venv/bin/python - <<'PY'
import geobuf

climb, mast = [[8.0, 47.0, 100.0], [8.1, 47.0, 200.0]], [8.0, 47.0, 100.0]
shapes = [{"type": "LineString", "coordinates": climb}, {"type": "Point", "coordinates": mast}]
features = [{"type": "Feature", "properties": {}, "geometry": shape} for shape in shapes]


def read(*options):
    encoded = geobuf.encode({"type": "FeatureCollection", "features": features}, *options)
    return [feature["geometry"]["coordinates"] for feature in geobuf.decode(encoded)["features"]]


seen, asked = read(), read(6, 3)
print(f"line {seen[0]}, point {seen[1]}; with dimensions 3: line {asked[0]}")
raise SystemExit(0 if seen == [[row[:2] for row in climb], mast] and asked == [climb, mast] else 1)
PY
