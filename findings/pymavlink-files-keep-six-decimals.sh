#!/bin/sh
# pymavlink's files of missions, fences and rally points keep six decimals of a degree; MAVLink has seven.
#
# pymavlink 2.4.50, mavwp.MAVWPLoader, MAVFenceLoader and MAVRallyLoader. Guess: a place that is saved and loaded is the
# same to MAVLink's resolution of 1e-7 degrees. Seen: 47.3977414 is 47.397741 in all three files, 4 cm away; a list that
# is downloaded, saved and uploaded again differs from the first. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
from pathlib import Path

from pymavlink import mavwp
from pymavlink.dialects.v20 import ardupilotmega as dialect

LATITUDE, LONGITUDE = 47.3977414, 8.5455946
mission, fence, rally = mavwp.MAVWPLoader(), mavwp.MAVFenceLoader(), mavwp.MAVRallyLoader()
mission.add(dialect.MAVLink_mission_item_message(1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, LATITUDE, LONGITUDE, 20))
fence.add_latlon(LATITUDE, LONGITUDE)
rally.create_and_append_rally_point(round(LATITUDE * 1e7), round(LONGITUDE * 1e7), 30, 20, 9000, 0)
shown = []
for loader, name in ((mission, "mission"), (fence, "fence"), (rally, "rally")):
    loader.save(f"{name}.txt")
    shown += [word for word in Path(f"{name}.txt").read_text().split() if word.startswith("47.")]
print("47.3977414 in the files:", *shown)
raise SystemExit(0 if shown == ["47.397741"] * 3 else 1)
PY
