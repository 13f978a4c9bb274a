#!/bin/sh
# pymavlink loads nothing from a parameter file of QGroundControl, and returns success.
#
# pymavlink 2.4.50, mavparm.MAVParmDict.load, which MAVProxy's `param load` uses. QGroundControl writes five columns:
# vehicle, component, name, value, type. Guess: load() reads them, or returns False. Seen: each line is printed as
# "Invalid line", the dictionary is empty, and load() returns True. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from pathlib import Path

from pymavlink import mavparm

lines = ["# Onboard parameters for Vehicle 1", "1\t1\tMPC_XY_VEL_MAX\t8.000000000000000000\t9", "1\t1\tRTL_TYPE\t0\t6"]
Path("vehicle.params").write_text("\n".join(lines) + "\n")
parameters = mavparm.MAVParmDict()
is_loaded = parameters.load("vehicle.params")
print(f"load returns {is_loaded}, parameters: {dict(parameters)}")
raise SystemExit(0 if is_loaded is True and not parameters else 1)
PY
