#!/bin/sh
# gnssroute leaves out all photos south of the equator or west of Greenwich.
#
# gnssroute 0.1.1, io.mrk.read_mrk, on the MRK file that a DJI RTK drone writes with its photos. Guess: three lines are
# three waypoints anywhere. Seen: three at 47 N 8 E, none at 33 S or at 70 W, none below the ellipsoid, nothing said;
# lines are skipped where a number has a minus. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gnssroute==0.1.1
cd "$folder"
./venv/bin/python - <<'PY'
from gnssroute.io.mrk import read_mrk


def read(latitude, longitude, height):
    place = f"{latitude},Lat\t{longitude},Lon\t{height},Ellh"
    rows = [f"{n}\t{435000 + n}.25\t[2447]\t 12,N\t -5,E\t 190,V\t{place}\t0.01, 0.01, 0.02\t50,Q" for n in (1, 2, 3)]
    open("flight.MRK", "w").write("\n".join(rows) + "\n")
    return len(read_mrk("flight.MRK"))


seen = {place: read(*place) for place in [(47.4, 8.5, 500), (-33.9, 18.4, 50), (40.7, -70.5, 50), (52.3, 4.8, -5)]}
print(seen)
raise SystemExit(0 if list(seen.values()) == [3, 0, 0, 0] else 1)
PY
