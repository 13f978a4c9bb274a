#!/bin/sh
# metar-cli shows no ceiling where fog hides the sky from 100 feet on.
#
# metar-cli 0.3.5, get_ceiling of layers as the weather service sends them. Guess: a vertical visibility of 100 feet,
# VV001 in a report, is the ceiling, as the definition of a ceiling has it; the service names its cover OVX, others VV.
# Seen: "None", as in a clear sky, for both. Its density altitude and BKN and OVC are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q metar-cli==0.3.5
cd "$folder"
HOME=$folder ./venv/bin/python - <<'PY'
from importlib.metadata import version

import metar

covers = "OVX", "VV", "OVC", "BKN", "FEW"
ceilings = {cover: metar.get_ceiling([{"cover": cover, "base": 100}]) for cover in covers}
density = metar.density_alt(30, 1013.25, 1500)
print(f"metar-cli {version('metar-cli')}: ceilings at 100 feet {ceilings};")
print(f"density altitude of 1500 m at 30 C {density} feet")
expected = {"OVX": "None", "VV": "None", "OVC": "100 ft", "BKN": "100 ft", "FEW": "None"}
raise SystemExit(0 if ceilings == expected and 7700 < density < 8000 else 1)
PY
