#!/bin/sh
# shapely's simplify takes the climb over a hill out of a line with heights.
#
# shapely 2.2.0 (GEOS). Guess: a point at another height is kept by simplify with a tolerance of 0.1 m, and by
# remove_repeated_points. Seen: of waypoints at 30, 30, 150, 30 and 30 m on a straight line only the ends are left, so
# that the hill is flown at 30 m; of a climb on the spot only the lower point is left. The result still has heights.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q shapely==2.2.0 numpy==2.4.1
cd "$folder"
./venv/bin/python - <<'PY'
import shapely

hill = shapely.LineString([(100 * n, 0, height) for n, height in enumerate((30, 30, 150, 30, 30))])
on_the_spot = shapely.LineString([(0, 0, 30), (0, 0, 120), (100, 0, 120)])
simple, unrepeated = shapely.simplify(hill, 0.1), shapely.remove_repeated_points(on_the_spot)
heights = [shapely.get_coordinates(line, include_z=True)[:, 2].tolist() for line in (simple, unrepeated)]
print(f"shapely {shapely.__version__}: hill of 150 m {heights[0]}, climb on the spot {heights[1]}")
raise SystemExit(0 if heights == [[30.0, 30.0], [30.0, 120.0]] else 1)
PY
