#!/bin/sh
# multirotor's propellers lift 14 N at the origin, 25 N at 20 m above it and 252 N at 100 m to the side.
#
# multirotor 0.5.0, get_forces_torques with the thrust of blades, use_thrust_constant=False, at one speed of rotation.
# Guess: the lift depends on the velocity and not on the place. Seen: it takes the place for the velocity of the air,
# and the velocity for the rates of the attitude. A climb of 5 m/s changes 14.31 to 14.38 N, 15 m/s forward nothing. A
# vehicle that climbs needs less and less throttle. A thrust constant has no such dependence. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q numpy==2.2.6 numba==0.61.2 scipy==1.15.3
"$folder/venv/bin/pip" install -q --no-deps multirotor==0.5.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from multirotor.simulation import Multirotor
from multirotor.vehicle import PropellerParams, SimulationParams, VehicleParams


def lift(place, velocity=(0, 0, 0)):
    blades = {"moment_of_inertia": 1e-5, "diameter": 6, "pitch": 3, "use_thrust_constant": False}
    blades |= {"k_thrust": 1e-5, "k_drag": 1e-6}
    angles = np.radians([45, 135, 225, 315])
    propellers = [PropellerParams(**blades) for _ in angles]
    frame = {"propellers": propellers, "angles": angles, "distances": np.full(4, 0.2)}
    params = VehicleParams(mass=1.0, inertia_matrix=np.diag([0.01, 0.01, 0.02]), **frame)
    vehicle = Multirotor(params, SimulationParams())
    vehicle.state[:6] = [*place, *velocity]
    return round(float(vehicle.get_forces_torques(np.full(4, 400.0), vehicle.state)[0][2]), 2)


by_place = [lift((0, 0, 0)), lift((0, 0, 20)), lift((100, 0, 20))]
by_velocity = [lift((0, 0, 0), (0, 0, 5)), lift((0, 0, 0), (15, 0, 0))]
print(f"multirotor {version('multirotor')}: lift in N at the origin, 20 m above, and 100 m to the side {by_place};")
print(f"at the origin with 5 m/s up and 15 m/s forward {by_velocity}")
raise SystemExit(0 if by_place == [14.31, 24.56, 251.55] and by_velocity == [14.38, 14.31] else 1)
PY
