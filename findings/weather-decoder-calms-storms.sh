#!/bin/sh
# weather-decoder reads a wind above 99 knots as calm.
#
# weather-decoder 1.1.4, MetarDecoder. ICAO's Annex 3 has P99KT (P49MPS) for a wind of 100 kt (50 m/s) or more. Guess:
# the speed is at least 99 kt, or the report is refused. Seen: 240P99KT and 140P49MPS are direction 0, speed 0, as
# 00000KT. 24099KT is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q weather-decoder==1.1.4
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from weather_decoder import MetarDecoder

winds = {}
for wind in ("240P99KT", "140P49MPS", "24099KT", "00000KT"):
    read = MetarDecoder().decode(f"METAR LSZH 291150Z {wind} 0500 FG VV001 10/10 Q0990").wind
    winds[wind] = read["direction"], read["speed"]
print(f"weather-decoder {version('weather-decoder')}: direction and speed {winds}")
storms, gale = {winds["240P99KT"], winds["140P49MPS"]}, winds["24099KT"]
raise SystemExit(0 if storms == {(0, 0)} == {winds["00000KT"]} and gale == (240, 99) else 1)
PY
