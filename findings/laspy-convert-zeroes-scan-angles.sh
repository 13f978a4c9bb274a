#!/bin/sh
# laspy sets the scan angles of a point cloud to 0 when it converts it to LAS 1.4's point formats, and back.
#
# laspy 2.7.0, convert. Guess: a scan_angle_rank of -20 degrees becomes a scan_angle of -3333 (of 0.006 degrees), as
# coordinates and classes are kept. Seen: 0 for each point from format 3 to 6 and from 6 to 3, no warning. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q laspy==2.7.0 numpy==2.4.6
cd "$folder"
./venv/bin/python -W error - <<'PY'
import laspy
import numpy as np

old = laspy.create(point_format=3, file_version="1.2")
old.x = old.y = old.z = np.array([1.0, 2.0, 3.0])
old.scan_angle_rank = np.array([-20, 0, 15])
old.classification = np.array([2, 6, 5])
new = laspy.convert(old, point_format_id=6)
forth = np.array([new.z, new.classification, new.scan_angle]).tolist()
new.scan_angle = np.array([-3333, 0, 2500])
back = np.array(laspy.convert(new, point_format_id=3, file_version="1.2").scan_angle_rank).tolist()
print(f"laspy {laspy.__version__}: height, class and angle in format 6 {forth}; angle in format 3 {back}")
raise SystemExit(0 if forth == [[1, 2, 3], [2, 6, 5], [0, 0, 0]] and back == [0, 0, 0] else 1)
PY
