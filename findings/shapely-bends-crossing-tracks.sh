#!/bin/sh
# shapely moves two flights to one height where they cross on the map.
#
# shapely 2.2.0, union, split and intersection. Guess: flights at 50 and at 200 m keep their heights. Seen: the union of
# a climb from 0 to 100 m and of a flight at 200 m has both at 125 m at their crossing, as the intersection has. split
# lifts the climb by 75 m, too. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q shapely==2.2.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import shapely
from shapely import ops

climb = shapely.LineString([(0, 0, 0), (100, 100, 100)])
level = shapely.LineString([(0, 100, 200), (100, 0, 200)])


def heights(shape):
    rows = shapely.get_coordinates(shape, include_z=True)
    return sorted({float(z) for x, y, z in rows if (x, y) == (50, 50)})


seen = [heights(shape) for shape in (climb.union(level), climb.intersection(level), ops.split(climb, level))]
print(f"shapely {shapely.__version__} (GEOS {shapely.geos_version_string}): heights at the crossing {seen}")
raise SystemExit(0 if seen == [[125.0]] * 3 else 1)
PY
