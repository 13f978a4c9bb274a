#!/bin/sh
# pyproj adds the hole of a zone to its area where both rings turn one way.
#
# pyproj 3.7.2, Geod.geometry_area_perimeter of a shapely polygon, whose hole has its own ring. Guess: the hole is
# subtracted, as by shapely's area. Seen: 0.88 km2 for a zone of 0.81 km2 whose outline has 0.85 km2, no warning. It is
# subtracted where it turns the other way, as the reference demands, but neither shapely nor KML. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyproj==3.7.2 shapely==2.2.0 numpy==2.4.6
cd "$folder"
./venv/bin/python -W error - <<'PY'
import pyproj
from shapely import Polygon

earth = pyproj.Geod(ellps="WGS84")
outline = [(8, 47), (8.01, 47), (8.01, 47.01), (8, 47.01)]
hole = [(8.004, 47.004), (8.006, 47.004), (8.006, 47.006), (8.004, 47.006)]


def measured(*holes):
    zone = Polygon(outline, holes)
    return round(earth.geometry_area_perimeter(zone)[0] / 1e6, 3), round(zone.area * 1e4, 2)


without, one_way, other_way = measured(), measured(hole), measured(hole[::-1])
print(f"pyproj {pyproj.__version__}, km2 and shapely's area: no hole {without}, {one_way}, reversed {other_way}")
raise SystemExit(0 if (without, one_way, other_way) == ((0.845, 1.0), (0.879, 0.96), (0.812, 0.96)) else 1)
PY
