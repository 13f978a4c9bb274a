#!/bin/sh
# ros2-numpy turns the pose of a level vehicle by 180 degrees, and reads the intensity of points from their places.
#
# ros2-numpy 0.0.5, numpify and msgify, with the messages of rosbags 0.11.9 for those of ROS. Guess: the matrix of a
# pose with x, y, z, w = 0, 0, 0, 1 has no rotation, and a transform comes back from its matrix. Seen: it turns by 180
# degrees about z, for the package transformations has w first. A transform of 1 m comes back turned by 180 degrees. A
# cloud has the intensity 40 at byte 12; it becomes 65, from bytes 3 and 4, of x and y. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ros2-numpy==0.0.5 transformations==2026.1.18 rosbags==0.11.9 numpy==1.24.2
cd "$folder"
./venv/bin/python - <<'PY'
import sys
from importlib.metadata import version
from types import ModuleType

import numpy as np
from rosbags.typesys import Stores, get_typestore

TYPES = get_typestore(Stores.ROS2_HUMBLE).types
for package in ("geometry_msgs", "sensor_msgs", "nav_msgs"):
    messages = ModuleType(f"{package}.msg")
    for name, message in TYPES.items():
        if name.startswith(f"{package}/msg/"):
            setattr(messages, name.split("/")[-1], message)
    sys.modules[package], sys.modules[messages.__name__] = ModuleType(package), messages

from ros2_numpy import msgify, numpify
from sensor_msgs.msg import PointCloud2, PointField
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3

level = Pose(position=Point(x=0.0, y=0.0, z=0.0), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
matrix = numpify(level).round(9)
moved = Transform(translation=Vector3(x=1.0, y=0.0, z=0.0), rotation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
back = msgify(Transform, numpify(moved)).rotation
back = [abs(round(float(getattr(back, axis)), 9)) for axis in "xyzw"]
names = {"x": (0, 7), "y": (4, 7), "z": (8, 7), "intensity": (12, 4)}
fields = [PointField(name=name, offset=at, datatype=kind, count=1) for name, (at, kind) in names.items()]
data = np.frombuffer(np.array([8, 50, 2], "<f4").tobytes() + np.uint16(40).tobytes(), np.uint8)
cloud = dict(header=None, height=1, width=1, fields=fields, is_bigendian=False, point_step=14, row_step=14)
intensity = int(numpify(PointCloud2(**cloud, data=data, is_dense=True))["intensity"][0, 0])
print(f"ros2-numpy {version('ros2-numpy')}: level {matrix[:3, :3].tolist()}; back in x, y, z, w {back};")
print(f"intensity 40 as {intensity}")
is_turned = matrix[:3, :3].tolist() == np.diag([-1.0, -1.0, 1.0]).tolist() and back == [0, 0, 1, 0]
raise SystemExit(0 if is_turned and intensity == 65 else 1)
PY
