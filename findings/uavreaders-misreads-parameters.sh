#!/bin/sh
# UAVReaders gives a return altitude of 14 cm for a log with 1500 cm.
#
# UAVReaders 1.0.6, data_flash_reader, pymavlink 2.4.50 to compare. Guess: the PARM rows of ArduPilot's log have their
# values. Seen: the value is read from within the 16 bytes of the name, so it depends on the name: RTL_ALT 1500 is
# 13.956, WPNAV_SPEED 1000 is 5.3e13. Nothing is raised; the number after the time is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q uavreaders==1.0.6 pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from pathlib import Path

from pymavlink import DFReader
from UAVReaders import data_flash_reader

FORMATS = (
    (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
    (135, 35, "PARM", "QNff", "TimeUS,Name,Value,Default"),
)
log = b"".join(
    b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", kind, size, *(word.encode() for word in words))
    for kind, size, *words in FORMATS
)
for name, value in ((b"RTL_ALT", 1500), (b"WPNAV_SPEED", 1000)):
    log += b"\xa3\x95\x87" + struct.pack("<Q16sff", 2000, name, value, value)
Path("flight.bin").write_bytes(log)
rows = [packet for packet in data_flash_reader("flight.bin")() if packet.name == "PARM"]
read = {row["Name"]: row["Value"] for row in rows}
reader = DFReader.DFReader_binary("flight.bin")
logged = {row.Name: row.Value for row in iter(lambda: reader.recv_match(type="PARM"), None)}
print(f"UAVReaders {read}\npymavlink {logged}")
is_wrong = round(read["RTL_ALT"], 3) == 13.956 and read["WPNAV_SPEED"] > 1e13
raise SystemExit(0 if is_wrong and logged == {"RTL_ALT": 1500, "WPNAV_SPEED": 1000} else 1)
PY
