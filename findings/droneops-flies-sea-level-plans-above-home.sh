#!/bin/sh
# droneops flies a plan of QGroundControl with altitudes above the sea at these heights above home: 538 m, not 50.
#
# droneops 0.1.0, QGroundControlUtils: convert_qgc_to_droneops_mission, then create_qgc_mission. Guess: a waypoint at
# 538 m above the sea (frame 0), over a home at 488 m, becomes 50 m above home, or stays in its frame. Seen: 538 m in
# frame 3, above home. A survey, a hold and the landing are left out, and a return is added; nothing is said.
# create_perimeter_scan with an offset of -20 m flies on the boundary itself. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q numpy==2.4.6 shapely==2.1.2
"$folder/venv/bin/pip" install -q --no-deps droneops==0.1.0
cd "$folder"
./venv/bin/python - <<'PY'
import json
import sysconfig
from importlib.metadata import version
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path


def load(name):
    """A module of the package without the package, which needs dronekit and with it an older Python."""
    spec = spec_from_file_location(name, Path(sysconfig.get_paths()["purelib"], "droneops", f"{name}.py"))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def item(command, frame, *params):
    return {"type": "SimpleItem", "command": command, "frame": frame, "autoContinue": True, "params": params}


items = [
    item(22, 0, 0, 0, 0, None, 47.397, 8.545, 538),
    {"type": "ComplexItem", "complexItemType": "survey", "version": 5},
    item(16, 0, 10, 0, 0, None, 47.398, 8.545, 538),
    item(21, 3, 0, 0, 0, None, 47.398, 8.545, 0),
]
home = [47.397, 8.545, 488]
Path("in.plan").write_text(json.dumps({"fileType": "Plan", "mission": {"items": items, "plannedHomePosition": home}}))
tool = load("q_ground_control").QGroundControlUtils()
tool.create_qgc_mission(tool.convert_qgc_to_droneops_mission("in.plan"), "out.plan")
mission = json.loads(Path("out.plan").read_text())["mission"]
written = [(one["command"], one["frame"], one["params"][0], one["params"][6]) for one in mission["items"]]
fence = [(47.0, 8.0), (47.001, 8.0), (47.001, 8.001)]
planner = load("mission_planner").MissionPlanner
inside = planner.create_perimeter_scan(fence, 50, offset=-20) == planner.create_perimeter_scan(fence, 50)
print(f"droneops {version('droneops')}, command, frame, hold and height: {written}; the offset is left out: {inside}")
raise SystemExit(0 if written == [(22, 3, 0, 538), (16, 3, 0, 538), (20, 3, 0, 0)] and inside else 1)
PY
