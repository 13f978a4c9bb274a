#!/bin/sh
# drone-swarm finds a wind from the west where a hovering drone leans to the east against it.
#
# drone-swarm 0.1.1, wind.WindEstimator.update: "the drone tilts INTO the wind", roll positive with the right wing down,
# pitch positive with the nose up, the direction that the wind comes from. Guess: nose to the north and right side down
# is a wind from the east, 90 degrees. Seen: 270; nose to the east and left side down, into a north wind, is 180. By
# pitch the direction is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q drone-swarm==0.1.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from drone_swarm.wind import WindEstimator


def from_degrees(roll, pitch, heading):
    estimator = WindEstimator()
    for _ in range(50):
        estimator.update(None, roll, pitch, 0.0, heading)
    return round(estimator.get_wind().direction_deg) % 360


by_pitch = [from_degrees(0.0, -0.1, heading) for heading in (0, 90)]
by_roll = [from_degrees(0.1, 0.0, 0), from_degrees(-0.1, 0.0, 90)]
print(f"drone-swarm {version('drone-swarm')}: winds from 0 and 90 degrees, nose into them, {by_pitch}; from 90 and")
print(f"0 degrees, from the side, {by_roll}")
raise SystemExit(0 if (by_pitch, by_roll) == ([0, 90], [270, 180]) else 1)
PY
