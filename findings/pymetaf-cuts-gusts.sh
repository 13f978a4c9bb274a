#!/bin/sh
# pymetaf reads a gust of 102 knots as 10 m/s.
#
# pymetaf 1.1.1, parse_text, whose result names its units. Guess: 24045G102KT is 23 m/s with gusts of 52 m/s. Seen: 45
# and 10, both "m/s": of three digits the last is cut, and nothing is converted; of 24045G60KT both are converted. A2992
# is a "qnh" of 101320 "hPa", Q1013 one of 1013. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymetaf==1.1.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from pymetaf import parse_text

read = [
    parse_text(f"METAR KMWN 291150Z {wind} 9999 OVC010 M01/M02 {pressure}", 2026, 11)
    for wind, pressure in (("24045G102KT", "A2992"), ("24045G60KT", "Q1013"))
]
winds = [(one["wind_speed"], one["gust"], one["wind_speed_units"]) for one in read]
pressures = [(one["qnh"], one["qnh_units"]) for one in read]
print(f"pymetaf {version('pymetaf')}: wind and gust {winds}, pressure {pressures}")
as_seen = winds == [(45, 10, "m/s"), (23, 30, "m/s")] and pressures == [(101320, "hPa"), (1013, "hPa")]
raise SystemExit(0 if as_seen else 1)
PY
