#!/bin/sh
# geoarea gives a zone with GeoJSON's order of corners an area of -0.85 km2.
#
# geoarea 0.1.3, area(latitudes, longitudes), of which the README says that it is the area. Guess: a zone has one area,
# whichever way its corners run. Seen: it is negative against the clock, as RFC 7946 has an outer ring, and positive
# with it. A sum of zones drawn both ways is their difference, 0 for two of one size. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q geoarea==0.1.3
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from geoarea import area

LATITUDES, LONGITUDES = [47, 47, 47.01, 47.01, 47], [8, 8.01, 8.01, 8, 8]

against, along = area(LATITUDES, LONGITUDES), area(LATITUDES[::-1], LONGITUDES[::-1])
print(f"geoarea {version('geoarea')}, km2: against the clock {against / 1e6:.2f}, with it {along / 1e6:.2f}")
raise SystemExit(0 if (round(against / 1e6, 2), round(along / 1e6, 2)) == (-0.85, 0.85) else 1)
PY
