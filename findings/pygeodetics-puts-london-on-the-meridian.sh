#!/bin/sh
# pygeodetics reads 0 degrees 7 minutes 40 seconds as 0 degrees: 8.8 km off in London, up to 111 km elsewhere.
#
# pygeodetics 1.2.0, utils.dms2deg and deg2dms, to_mgrs. Guess: 0, 7, 40 is 0.1278 degrees, and -0.1278 degrees come
# back from degrees, minutes and seconds. Seen: 0, as the value is multiplied by the sign of its degrees, and the sign
# of 0 is 0; all places within a degree of the equator or of Greenwich are moved onto it. deg2dms(-0.1278) has no sign.
# Bergen is in 31V for to_mgrs, in 32V by the standard and for mgrs. 51, 28, 40 is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pygeodetics==1.2.0 mgrs==1.6.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import mgrs
from pygeodetics import to_mgrs
from pygeodetics.utils.deg2dms import deg2dms
from pygeodetics.utils.dms2deg import dms2deg

read = [round(float(dms2deg(*parts)), 4) for parts in ((0, 7, 40), (0, 59, 59), (51, 28, 40))]
west, east = (deg2dms(degrees)[:2] for degrees in (-0.1278, 0.1278))
bergen = str(to_mgrs(60.4, 5.3))[:3], mgrs.MGRS().toMGRS(60.4, 5.3)[:3]
print(f"pygeodetics {version('pygeodetics')}: 0 7 40, 0 59 59 and 51 28 40 are {read} degrees;")
print(f"-0.1278 and 0.1278 are {west} and {east}; Bergen is in {bergen[0]}, for mgrs in {bergen[1]}")
as_seen = read == [0, 0, 51.4778] and west == east == (0, 7)
raise SystemExit(0 if as_seen and bergen == ("31V", "32V") else 1)
PY
