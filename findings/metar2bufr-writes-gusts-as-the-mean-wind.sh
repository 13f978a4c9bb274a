#!/bin/sh
# metar2bufr writes each gust in knots as the mean wind, and 9999 m of visibility as 16092 km.
#
# metar2bufr 0.0.2.59 with csv2bufr 0.8.8, parse_metar, whose values go into a BUFR message. Guess: 21016G24KT is 8.23
# m/s with gusts of 12.35, and 9999 is 9999 m. Seen: gusts of 8.23 m/s, as the mean is written; 16091790 m, as
# meters are converted as miles. A gale's gust of 60 knots becomes the 20 knots of its mean. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q metar2bufr==0.0.2.59 csv2bufr==0.8.8
cd "$folder"
./venv/bin/python - 2>/dev/null <<'PY'
from importlib.metadata import version

from metar2bufr.metar_bufr_encoder import parse_metar


def read(report, *names):
    return [parse_metar(report, 2026, 7)[0][name] for name in names]


wind = read("METAR KABC 121755Z 21016G24KT 10SM OVC025 06/04 A2990=", "wind_speed", "gust_speed")
gale = read("METAR LSZH 121750Z 24020G60KT 9999 FEW040 22/12 Q1018=", "wind_speed", "gust_speed", "visibility")
print(f"metar2bufr {version('metar2bufr')}: 16 with gusts of 24 knots {wind} m/s")
print(f"20 with gusts of 60 knots and 9999 m {gale}")
raise SystemExit(0 if wind == [8.23, 8.23] and gale == [10.29, 10.29, 16091790] else 1)
PY
