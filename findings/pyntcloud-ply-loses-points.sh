#!/bin/sh
# PyntCloud writes a lidar cloud as a PLY that has one of its two points, as it reads it itself.
#
# pyntcloud 0.3.1, from_file of a LAS 1.2 by laspy 2.7.0, to_file of a PLY. Guess: both points are there, with their
# classes 2 and 6. Seen: one point, of class 0. The header names an intensity of 16 bits a byte, and a time of 64 bits
# a float, so that all that follows is shifted. The same as text keeps the classes, and an intensity of 60000 is 96.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyntcloud==0.3.1 laspy==2.7.0 numpy==2.2.6 pandas==2.2.3
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import laspy
import numpy as np
from pyntcloud import PyntCloud

header = laspy.LasHeader(point_format=1, version="1.2")
header.offsets, header.scales = np.array([500000, 5200000, 0]), np.full(3, 0.001)
flown = laspy.LasData(header)
flown.x, flown.y, flown.z = 500000 + np.array([0, 10]), 5200000 + np.array([0, 20]), np.array([420.5, 520.5])
flown.classification, flown.intensity = np.array([2, 6]), np.array([100, 60000])
flown.write("flown.las")


def through(name, **how):
    PyntCloud.from_file("flown.las").to_file(name, **how)
    points = PyntCloud.from_file(name).points
    return [column.tolist() for column in (points.z, points.raw_classification, points.intensity)]


binary, text = through("binary.ply"), through("text.ply", as_text=True)
print(f"pyntcloud {version('pyntcloud')}, heights, classes and intensities: binary {binary}, text {text}")
as_seen = binary == [[420.5], [0], [100]] and text == [[420.5, 520.5], [2, 6], [100, 96]]
raise SystemExit(0 if as_seen else 1)
PY
