#!/bin/sh
# posim's simulated receiver flies to the south on a path to the east, and to the north on one to the west.
#
# posim 0.1, Simulation.run_sim, with posim's stationary for the latitude. Guess: a direction of 0 to the north and 1 to
# the east is a course of 90 degrees. Seen: 180, and 0 for one to the west, as the quotient of both is not taken where
# the first is 0; to the north-east, north, south and south-west courses are right. Nothing is raised. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps posim==0.1 numpy==2.3.5 geographiclib==2.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from geographiclib.geodesic import Geodesic
from posim.paths import stationary
from posim.simulate import Character, Simulation

WAYS = {"east": (0, 1), "west": (0, -1), "north": (1, 0), "south": (-1, 0)}
WAYS |= {"north-east": (1, 1), "south-west": (-1, -1)}


def path(way):
    return (lambda distance, _: way * distance) if way else stationary


def course(north, east):
    simulation = Simulation()
    simulation.start_time, simulation.end_time, simulation.timestep = 0.0, 60.0, 1
    receiver = Character()
    receiver.start_pos = (47.0, 8.0)
    receiver.lat_func, receiver.lon_func = path(north), path(east)
    flown = simulation.run_sim(receiver)
    leg = Geodesic.WGS84.Inverse(*receiver.start_pos, flown["lat"][-1], flown["lon"][-1])
    return round(leg["azi1"]) % 360


seen = {name: course(*way) for name, way in WAYS.items()}
print(f"posim {version('posim')}, courses: {seen}")
raise SystemExit(0 if list(seen.values()) == [180, 0, 0, 180, 45, 225] else 1)
PY
