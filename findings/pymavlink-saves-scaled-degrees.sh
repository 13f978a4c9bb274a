#!/bin/sh
# pymavlink's waypoint loader saves a MISSION_ITEM_INT with its scaled coordinates, as degrees.
#
# pymavlink 2.4.50, mavwp.MAVWPLoader. Guess: add() takes a MISSION_ITEM_INT as it takes a MISSION_ITEM, and save() writes
# degrees. Seen: the file has 473977418.000000 where a QGC WPL 110 file has 47.3977418, and load() reads it back without
# an error. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from pymavlink import mavwp
from pymavlink.dialects.v20 import ardupilotmega as dialect

saved, read = mavwp.MAVWPLoader(), mavwp.MAVWPLoader()
for seq in (0, 1):
    saved.add(dialect.MAVLink_mission_item_int_message(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 473977418, 85455941, 20, 0))
saved.save("mission.txt")
print("count read:", read.load("mission.txt"), " latitude:", read.wp(1).x, " longitude:", read.wp(1).y)
raise SystemExit(0 if (read.wp(1).x, read.wp(1).y) == (473977418.0, 85455941.0) else 1)
PY
