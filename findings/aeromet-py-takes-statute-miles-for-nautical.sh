#!/bin/sh
# aeromet-py sees 15 % further than a report in statute miles: 3SM are 5556 m, above a minimum of 5 km.
#
# aeromet-py 0.1.2, Metar, prevailing_visibility.in_meters. Guess: 1/4SM, 1 1/2SM and 3SM are 402, 2414 and 4828 m, as
# SM is a statute mile in reports. Seen: 463, 2778 and 5556 m, as they are taken for nautical miles; in_sea_miles is 3.0
# for 3SM. A visibility in meters and a runway's range in feet are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q aeromet-py==0.1.2 typing_extensions==4.15.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from aeromet_py import Metar

SIGHTS = "1/4SM", "1 1/2SM", "3SM", "4800"
reports = {sight: Metar(f"METAR KJFK 121251Z 31003KT {sight} R04R/1200FT FG OVC002 18/16 A2992") for sight in SIGHTS}
meters = [round(report.prevailing_visibility.in_meters) for report in reports.values()]
miles = round(reports["3SM"].prevailing_visibility.in_sea_miles, 3)
print(f"aeromet-py {version('aeromet-py')}: {SIGHTS} are {meters} m; 3SM are {miles} sea miles")
raise SystemExit(0 if meters == [463, 2778, 5556, 4800] and miles == 3 else 1)
PY
