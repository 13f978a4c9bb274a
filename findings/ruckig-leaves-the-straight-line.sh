#!/bin/sh
# ruckig leaves the straight line between two waypoints by 2 m.
#
# ruckig 0.19.4, from rest to rest, two axes with the same limits of 10 m/s, 3 m/s2 and 5 m/s3. Guess: the way to a
# place 100 m east and 30 m north is straight, as both axes start and arrive together. Seen: 2.12 m to each side; the
# default synchronizes the time only. With Synchronization.Phase it is straight, in the same time. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ruckig==0.19.4
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from ruckig import InputParameter, Ruckig, Synchronization, Trajectory


def flown(**options):
    asked, way = InputParameter(2), Trajectory(2)
    asked.target_position = [100, 30]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = [10, 10], [3, 3], [5, 5]
    for name, value in options.items():
        setattr(asked, name, value)
    Ruckig(2).calculate(asked, way)
    places = (way.at_time(way.duration * n / 1000)[0] for n in range(1001))
    off = [(100 * north - 30 * east) / math.hypot(100, 30) for east, north in places]
    return round(way.duration, 2), round(min(off), 2), round(max(off), 2)


plain, phase = flown(), flown(synchronization=Synchronization.Phase)
print(f"ruckig {version('ruckig')}, duration [s] and meters off the line: {plain}, with Phase {phase}")
raise SystemExit(0 if plain == (13.93, -2.12, 2.12) and phase == (13.93, 0, 0) else 1)
PY
