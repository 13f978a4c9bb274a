#!/bin/sh
# In pyadsb all aircraft sink, and fly to the south-west.
#
# pyadsb 0.0.3, AirborneVelocities of four messages of ADS-B, which pyModeS 3.6.1 reads, too. Guess: 100 knots east and
# 100 north, up at 640 feet a minute, are a track of 45 degrees and a climb. Seen: 225 degrees and -640, for each
# quadrant and each sign. The sign is -1**bit, which is -1 for both bits. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyadsb==0.0.3 pyModeS==3.6.1
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import pyModeS
from adsb import Adsb


def message(west, south, down):
    velocity = 19 << 51 | 1 << 48 | west << 42 | 101 << 32 | south << 31 | 101 << 21 | down << 19 | 11 << 10
    body = 0x8D485020 << 56 | velocity
    parity = body << 24
    for bit in range(111, 23, -1):
        if parity >> bit & 1:
            parity ^= 0x1FFF409 << bit - 24
    return (body << 24 | parity).to_bytes(14, "big")


signs = [(0, 0, 0), (1, 0, 0), (0, 1, 1), (1, 1, 1)]
sent = [pyModeS.decode(message(*sign).hex()) for sign in signs]
read = [Adsb.parse(message(*sign)).data for sign in signs]
tracks = [(round(plane["track"]), plane["vertical_rate"]) for plane in sent]
seen = [(round(plane.heading()), plane.altitude_rate()) for plane in read]
print(f"tracks and rates: pyModeS {version('pyModeS')} {tracks}; pyadsb {version('pyadsb')} {seen}")
right = tracks == [(45, 640), (315, 640), (135, -640), (225, -640)]
raise SystemExit(0 if right and seen == [(225, -640)] * 4 else 1)
PY
