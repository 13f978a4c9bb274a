#!/bin/sh
# homewatch reports a drone without a known altitude 1000 m below the ellipsoid, and each height as one above ground.
#
# homewatch 0.2.1, remoteid.parse_message, on a Location message of ASTM F3411. The format encodes an unknown altitude
# as 0, that is -1000 m, and says by a bit whether the height is above takeoff or above ground. Guess: no altitude, and
# a height above ground only where the bit is set. Seen: -1000.0, and height_agl_m with and without the bit. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q homewatch==0.2.1
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from importlib.metadata import version

from homewatch.remoteid import parse_message

AIRBORNE, ABOVE_GROUND = 0x20, 0x04


def read(altitude, height_type):
    place = struct.pack("<ii", 470000000, 85000000)
    pressure, geodetic, height = (int((meters + 1000) * 2) for meters in (-1000, altitude, 30))
    message = bytes([0x12, AIRBORNE | height_type, 90, 10, 0]) + place + struct.pack("<HHH", pressure, geodetic, height)
    found = parse_message(message.ljust(25, b"\0"))
    return found["alt_m"], found["height_agl_m"]


seen = [read(450, ABOVE_GROUND), read(450, 0), read(-1000, 0)]
print(f"homewatch {version('homewatch')}: altitude and height above ground {seen[0]}, above takeoff {seen[1]},")
print(f"of an unknown altitude {seen[2]}")
raise SystemExit(0 if seen == [(450.0, 30.0), (450.0, 30.0), (-1000.0, 30.0)] else 1)
PY
