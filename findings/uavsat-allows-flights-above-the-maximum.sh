#!/bin/sh
# uavsat finds a flight at 500 m in controlled airspace valid, where the maximum is 120 m.
#
# uavsat 0.2.0, UAVSATValidator.validate, in VLOS and daylight, outside of its zones. Guess: an altitude above
# max_altitude is UNSAT, with its violation. Seen: SAT without a violation, as no rule needs the altitude that was
# denied. A large vehicle and controlled airspace are SAT, too, as the solver grants the coordination that they need. So
# is a leg through a zone: only a point of the path on a point of the zone counts. Rain is UNSAT. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps uavsat==0.2.0 python-sat==1.9.dev17 six==1.17.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from uavsat import UAVSATValidator

CASES = {
    "at 100 m": {},
    "at 500 m": {"altitudes": [500, 500]},
    "large in controlled airspace": {"drone_size": "large", "controlled_airspace": True},
    "through a zone": {"path": [(0, 1), (2, 1)]},
    "point in a zone": {"path": [(0, 0), (1, 1)]},
    "in rain": {"weather_flags": {"rain": True}},
}


def validate(**changes):
    flight = {"path": [(0, 0), (2, 0)], "altitudes": [100, 100], "max_altitude": 120, "weather_flags": {}}
    flight |= {"no_fly_zones": {"airports": [(1, 1)], "military": [], "infrastructure": []}} | changes
    return UAVSATValidator().validate(**flight)


seen = {name: validate(**changes) for name, changes in CASES.items()}
print(f"uavsat {version('uavsat')}: {seen}")
verdicts = [verdict for verdict, violations in seen.values() if verdict == "UNSAT" or not violations]
raise SystemExit(0 if verdicts == ["SAT"] * 4 + ["UNSAT"] * 2 else 1)
PY
