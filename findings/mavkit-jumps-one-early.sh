#!/bin/sh
# mavkit uploads a DO_JUMP that leads to the item before the one meant.
#
# mavkit 0.3.0, items_for_wire_upload. Guess: home becomes item 0, all others move up by one, and the target of a jump
# moves with its item. Seen: the target stays. A plan whose item 3 repeats items 1 and 2 goes back to item 0, the
# takeoff; validate_plan finds nothing. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavkit==0.3.0
cd "$folder"
./venv/bin/python - <<'PY'
import mavkit

TAKEOFF, WAYPOINT, DO_JUMP = 22, 16, 177
frame = mavkit.MissionFrame.GlobalRelativeAltInt
rows = [(TAKEOFF, 474000000, 30.0), (WAYPOINT, 474000000, 50.0), (WAYPOINT, 474010000, 60.0)]
items = [
    mavkit.MissionItem(seq=n, command=command, frame=frame, x=x, y=85000000, z=z)
    for n, (command, x, z) in enumerate(rows)
]
jump = {"seq": 3, "command": DO_JUMP, "frame": mavkit.MissionFrame.Mission, "param1": 1, "param2": 2}
home = mavkit.HomePosition(latitude_deg=47.4, longitude_deg=8.5, altitude_m=400)
mission = mavkit.MissionType.Mission
plan = mavkit.MissionPlan(mission_type=mission, items=[*items, mavkit.MissionItem(**jump)], home=home)
sent = mavkit.items_for_wire_upload(plan)
target = sent[int(sent[-1].param1)]
print(f"mavkit {mavkit.__version__}: target of the plan {plan.items[1].z:g} m, as sent {target.z:g} m")
as_seen = [item.z for item in sent] == [400, 30, 50, 60, 0] and target.command == TAKEOFF
raise SystemExit(0 if as_seen and not mavkit.validate_plan(plan) else 1)
PY
