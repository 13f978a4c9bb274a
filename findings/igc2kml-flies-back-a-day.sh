#!/bin/sh
# igc2kml sends a flight that passes midnight UTC back by a day.
#
# igc2kml 0.1.0, parse_igc; aerofiles 1.5.6 reads the same file. An IGC file has one date, of its first fix, and times
# in UTC, whose midnight is in the afternoon in California. Guess: the fix after 23:59:59 is a second later. Seen: it is
# 23 hours 59 minutes 59 seconds earlier, also in the time stamps of the KML; a player of it shows the end first. Exits
# 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q igc2kml==0.1.0 aerofiles==1.5.6 python-dateutil==2.9.0.post0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import aerofiles
from igc2kml.igc2kml import parse_igc

TIMES = ("235958", "235959", "000000", "000001")
fixes = [f"B{time}3723{n}00N12200000WA0050000500" for n, time in enumerate(TIMES)]
with open("flight.igc", "w") as out:
    out.write("\r\n".join(["AXXXABC", "HFDTE291126", *fixes, ""]))
flight, _ = parse_igc("flight.igc")
with open("flight.igc") as file:
    records = aerofiles.igc.Reader().read(file)["fix_records"][1]
other = [record["datetime"] for record in records]
steps = [[(after - before).total_seconds() for before, after in zip(each, each[1:])] for each in (flight.t, other)]
print(f"igc2kml {version('igc2kml')}: seconds from fix to fix {steps[0]}, by aerofiles {steps[1]}")
raise SystemExit(0 if steps == [[1, -86399, 1], [1, 1, 1]] else 1)
PY
