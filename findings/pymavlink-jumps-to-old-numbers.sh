#!/bin/sh
# pymavlink's MAVWPLoader renumbers a mission, but not the numbers that its DO_JUMPs lead to.
#
# pymavlink 2.4.50, MAVWPLoader.remove and insert. Guess: a DO_JUMP keeps its waypoint, or the call refuses. Seen: after
# remove(2) the jump to item 4 leads to itself; after insert(1, ...) to the waypoint before the one meant. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from pymavlink import mavwp
from pymavlink.dialects.v20 import ardupilotmega as mavlink

WAYPOINT, TAKEOFF, JUMP = 16, 22, 177


def mission():
    loader = mavwp.MAVWPLoader()
    steps = [(WAYPOINT, 0, 488), (TAKEOFF, 0, 20), *((WAYPOINT, 0, height) for height in (30, 40, 50)), (JUMP, 4, 0)]
    for command, first, height in steps:
        item = (0, 0, 0, 3, command, 0, 1, first, 2 if command == JUMP else 0, 0, 0, 47.4, 8.5, height)
        loader.add(mavlink.MAVLink_mission_item_message(*item))
    return loader


def target(loader):
    jump = next(item for item in loader.wpoints if item.command == JUMP)
    return loader.wp(int(jump.param1))


shorter, longer = mission(), mission()
shorter.remove(shorter.wp(2))
longer.insert(1, mavlink.MAVLink_mission_item_message(0, 0, 0, 3, WAYPOINT, 0, 1, 0, 0, 0, 0, 47.4, 8.5, 25))
print(f"before: to the waypoint at {target(mission()).z} m")
print(f"after remove: to command {target(shorter).command}, itself; after insert: to the one at {target(longer).z} m")
is_as_stated = (target(mission()).z, target(shorter).command, target(longer).z) == (50, JUMP, 40)
raise SystemExit(0 if is_as_stated else 1)
PY
