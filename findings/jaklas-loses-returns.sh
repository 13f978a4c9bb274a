#!/bin/sh
# jaklas writes a point cloud without the returns that it read: each point becomes return 0 of 0.
#
# jaklas 0.4.4 with laspy 2.6.1, on a LAS file of point format 3. Guess: what read() returns, write() writes.
# Seen: intensity and class are kept; return_number, number_of_returns, point_source_id, scan_angle_rank and user_data
# are 0, and nothing is said. A filter of last returns, which finds the ground under trees, then finds nothing. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q jaklas==0.4.4 laspy==2.6.1 numpy==2.3.5 pyproj==3.7.2
cd "$folder"
./venv/bin/python - <<'PY'
import warnings
from importlib.metadata import version

import jaklas
import laspy

FIELDS = {"return_number": [1, 2], "number_of_returns": [2, 2], "point_source_id": [7, 7], "user_data": [3, 3]}
FIELDS |= {"scan_angle_rank": [-10, 10], "intensity": [5, 6], "classification": [2, 6]}

cloud = laspy.create(point_format=3)
cloud.x, cloud.y, cloud.z = [500_000.0, 500_001.0], [5_200_000.0, 5_200_001.0], [100.0, 101.0]
for field, values in FIELDS.items():
    cloud[field] = values
cloud.write("cloud.las")
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    read = jaklas.read("cloud.las")
    jaklas.write(read, "copy.las")
copy = laspy.read("copy.las")
lost = [field for field in FIELDS if list(read[field]) == FIELDS[field] and list(copy[field]) == [0, 0]]
kept = [field for field in FIELDS if list(copy[field]) == FIELDS[field]]
print(f"jaklas {version('jaklas')}: read, but written as 0: {lost}; kept: {kept}; warnings {len(said)}")
raise SystemExit(0 if len(lost) == 5 and kept == ["intensity", "classification"] and not said else 1)
PY
