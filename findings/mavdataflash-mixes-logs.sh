#!/bin/sh
# MAVdataflash gives the track of one flight for the log of another.
#
# MAVdataflash 3.0.0, DataFlash.GetData. Guess: two open logs keep their own data. Seen: the tables belong to the class.
# If both logs are open before the first is read, the second gives the first one's positions: Lat 47.1 instead of 52.1,
# Alt 500 instead of 30, two rows instead of three, without a warning. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavdataflash==3.0.0 pymavlink==2.4.50 polars==1.36.1 pandas==2.3.3 pyarrow==22.0.0
cd "$folder"
./venv/bin/python - <<'PY'
import struct

from MAVdataflash import DataFlash


def described(number, layout, name, kinds, columns):
    size = 3 + struct.calcsize("<" + layout)
    row = struct.pack("<BB4s16s64s", number, size, name.encode(), kinds.encode(), columns.encode())
    return b"\xa3\x95\x80" + row


def written(path, latitudes, altitude):
    rows = [described(128, "BB4s16s64s", "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")]
    rows += [described(130, "QBIHiif", "GPS", "QBIHLLf", "TimeUS,Status,GMS,GWk,Lat,Lng,Alt")]
    for n, latitude in enumerate(latitudes, 1):
        fix = struct.pack("<QBIHiif", n * 1000000, 3, n * 1000, 2400, round(latitude * 1e7), 85000000, altitude)
        rows.append(b"\xa3\x95\x82" + fix)
    open(path, "wb").write(b"".join(rows))


written("first.bin", [47.1, 47.11], 500.0)
written("second.bin", [52.1, 52.11, 52.12], 30.0)
first, second = DataFlash("first.bin"), DataFlash("second.bin")
tracks = [log.GetData("GPS")[["Lat", "Alt"]].values.tolist() for log in (first, second)]
print(f"first log: {tracks[0]}\nsecond log: {tracks[1]}")
raise SystemExit(0 if tracks[1] == tracks[0] == [[47.1, 500.0], [47.11, 500.0]] else 1)
PY
