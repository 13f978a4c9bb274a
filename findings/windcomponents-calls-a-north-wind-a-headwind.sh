#!/bin/sh
# windcomponents has no crosswind from north: a METAR's 36020KT is a headwind of 20 knots on each runway.
#
# windcomponents 0.6, RunwayWindComponents.calculate_cross_tail_head_wind. Guess: a wind from 360 degrees, as reports
# write north, is one from 0 degrees: a crosswind of 20 knots on runway 09, a tailwind on 18. Seen: a crosswind of 0 and
# a headwind of 20 knots on all of them, as only 0 is in its list. A wind from 185 degrees is a headwind, too, as each
# that is no multiple of ten. From 0 degrees it is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q windcomponents==0.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from windcomponents import RunwayWindComponents


def components(runway, wind):
    """Crosswind, tailwind and headwind, in knots, of 20 knots."""
    return [round(part) for part in RunwayWindComponents(runway).calculate_cross_tail_head_wind(wind, 20)[1:]]


north = [components(runway, 360) for runway in (90, 180, 270)]
zero = [components(runway, 0) for runway in (90, 180, 270)]
south = components(90, 185)
print(f"windcomponents {version('windcomponents')}, crosswind, tailwind and headwind on runways 09, 18 and 27:")
print(f"from 360 {north}, from 0 {zero}; from 185 on runway 09 {south}")
as_seen = north == [[0, 0, 20]] * 3 and south == [0, 0, 20]
raise SystemExit(0 if as_seen and zero == [[20, 0, 0], [0, 20, 0], [20, 0, 0]] else 1)
PY
