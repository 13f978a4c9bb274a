#!/bin/sh
# atis-parser finds a dust storm in each report of Stuttgart, and no later period in a forecast.
#
# atis_parser 0.0.1, parse_metar and parse_taf. Guess: a METAR of EDDS without weather has none, and FM121800 begins a
# second period. Seen: its DS is the one in the name EDDS, as the whole text is searched; Stansted, EGSS, has small hail
# (GS). A gale of 27025G45KT after FM121800 is lost, and its thunderstorm is in the first period, with 8 knots. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q atis_parser==0.0.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from atis_parser import parse_metar, parse_taf

REST = "121220Z 24008KT 9999 FEW040 22/12 Q1018"
FORECAST = "TAF KBOS 121130Z 1212/1318 24008KT P6SM SKC FM121800 27025G45KT 2SM TSRA BKN020"

weather = {place: parse_metar(f"METAR {place} {REST}").weather_phenomena for place in ("LFPG", "EDDS", "EGSS")}
periods = [
    (part.wind_speed, part.wind_gust, sorted(part.weather_phenomena)) for part in parse_taf(FORECAST).forecasts
]
print(f"atis_parser {version('atis_parser')}: weather {weather}")
print(f"wind, gust and weather of the forecast's periods: {periods}")
as_seen = weather == {"LFPG": [], "EDDS": ["DS"], "EGSS": ["GS"]}
raise SystemExit(0 if as_seen and periods == [(8, None, ["RA", "TS"])] else 1)
PY
