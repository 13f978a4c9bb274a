#!/bin/sh
# geo2kml leaves geometry collections out, and can write no point.
#
# geo2kml 0.0.3, to_kml of GeoJSON. Guess: a GeometryCollection becomes a MultiGeometry, as its code has a writer for
# it, and a point a Point. Seen: the collection is left out without a word, as its test looks for a key
# "GeometryCollection"; each point raises TypeError, as numbers are joined as texts. Heights of a line are written
# without an altitudeMode. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q geo2kml==0.0.3
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from geo2kml import to_kml

line = {"type": "LineString", "coordinates": [[8, 47, 100], [8.1, 47.1, 200]]}
collection = {"type": "GeometryCollection", "geometries": [line, line]}


def written(*geometries):
    features = [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in geometries]
    return to_kml({"type": "FeatureCollection", "features": features})


both = written(line, collection)
try:
    point = written({"type": "Point", "coordinates": [8.0, 47.0, 100.0]})
except TypeError as error:
    point = type(error).__name__
places = both.count("<LineString>")
print(f"geo2kml {version('geo2kml')}: lines written {places} of 3; a point: {point}")
raise SystemExit(0 if places == 1 and "altitudeMode" not in both and point == "TypeError" else 1)
PY
