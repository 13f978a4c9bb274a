#!/bin/sh
# importRosbag gives the quaternion of an IMU with w last, and that of a pose with w first.
#
# importRosbag 1.0.4, a bag with one attitude, yawed by 60 degrees, as sensor_msgs/Imu and as geometry_msgs/PoseStamped.
# Guess: both have one order. Seen: rotQ of the IMU is x, y, z, w and rotation of the pose w, x, y, z, and neither says
# so in its result. Read in one order, one of the two is a level vehicle with a course and the other one on its back.
# The IMU's magnetometer, which the message does not have, is 0 in all axes. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q importRosbag==1.0.4 rosbags==0.11.9 numpy==2.3.5 setuptools==80.9.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from importRosbag.importRosbag import importRosbag
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS1_NOETIC)


def make(kind, **values):
    return store.types[kind](**values)


time = make("builtin_interfaces/msg/Time", sec=10, nanosec=0)
header = make("std_msgs/msg/Header", seq=0, stamp=time, frame_id="map")
attitude = make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.5, w=np.sqrt(0.75))
place = make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0)
still = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
unknown = {f"{name}_covariance": np.zeros(9) for name in ("orientation", "angular_velocity", "linear_acceleration")}
pose = make("geometry_msgs/msg/Pose", position=place, orientation=attitude)
messages = {
    "/imu": make("sensor_msgs/msg/Imu", header=header, orientation=attitude, angular_velocity=still,
                 linear_acceleration=still, **unknown),
    "/pose": make("geometry_msgs/msg/PoseStamped", header=header, pose=pose),
}
with Writer("flight.bag") as bag:
    for topic, message in messages.items():
        connection = bag.add_connection(topic, message.__msgtype__, typestore=store)
        bag.write(connection, 10**10, store.serialize_ros1(message, message.__msgtype__))
read = importRosbag("flight.bag", log="ERROR", disable_bar=True)
seen = read["/imu"]["rotQ"][0].round(3).tolist(), read["/pose"]["rotation"][0].round(3).tolist()
magnetic = read["/imu"]["mag"][0].tolist()
print(f"importRosbag {version('importRosbag')}: IMU {seen[0]}, pose {seen[1]}, magnetometer {magnetic}")
raise SystemExit(0 if seen == ([0, 0, 0.5, 0.866], [0.866, 0, 0, 0.5]) and magnetic == [0, 0, 0] else 1)
PY
