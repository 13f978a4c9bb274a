#!/bin/sh
# pymavlink's mavtogpx weaves the positions of two GPS receivers into one zigzag track.
#
# pymavlink 2.4.50, mavtogpx.py, on a log of ArduPilot with GPS[0] and GPS[1] 56 m and 20 m of height apart. Guess: one
# track of the first receiver, or one track each. Seen: one track takes both in turn; a flight of 8 m is 1047 m long.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from pathlib import Path

COLUMNS = "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"
FORMATS = (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"), (130, 51, "GPS", "QBBIHBcLLeffffB", COLUMNS)
log = b"".join(
    b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", kind, size, *(word.encode() for word in words))
    for kind, size, *words in FORMATS
)
for n in range(10):
    for receiver, latitude, altitude in ((0, 470000000, 50000), (1, 470005000, 52000)):
        place = latitude + 90 * n, 85000000, altitude
        row = 1000000 + 200000 * n + receiver, receiver, 3, 345600000 + 200 * n, 2394, 12, 80, *place, 5, 0, 0, 0, 1
        log += b"\xa3\x95\x82" + struct.pack("<QBBIHBhiiiffffB", *row)
Path("flight.bin").write_bytes(log)
PY
./venv/bin/mavtogpx.py flight.bin >/dev/null
./venv/bin/python - <<'PY'
import re
from pathlib import Path

text = Path("flight.bin.gpx").read_text()
latitudes = [float(latitude) for latitude in re.findall(r'trkpt lat="([\d.]+)"', text)]
heights = [float(height) for height in re.findall(r"<ele>([\d.]+)<", text)]
length = sum(abs(after - before) for before, after in zip(latitudes, latitudes[1:])) * 111194
print(f"{text.count('<trk>')} track, {len(latitudes)} points, {length:.0f} m, heights {heights[:4]}")
as_seen = text.count("<trk>") == 1 and heights[:4] == [500.0, 520.0, 500.0, 520.0] and 1000 < length < 1100
raise SystemExit(0 if as_seen else 1)
PY
