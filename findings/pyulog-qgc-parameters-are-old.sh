#!/bin/sh
# pyulog's ulog_params writes a parameter file for QGroundControl with the values before the last change.
#
# pyulog 1.3.0, ulog_params -f qgc. Guess: the file has the values at the end of the log, or names a change. Seen: only
# those at its start. Who lowers RTL_RETURN_ALT from 60 to 30 m in flight finds 60 in the file; the format csv has both
# values. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyulog==1.3.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from pathlib import Path


def message(kind, content):
    return struct.pack("<HB", len(content), ord(kind)) + content


def parameter(value):
    key = b"float RTL_RETURN_ALT"
    return message("P", bytes([len(key)]) + key + struct.pack("<f", value))


def row(time):
    return message("D", struct.pack("<HQf", 0, time, 1))


parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), message("B", bytes(40)), parameter(60)]
parts += [message("F", b"height:uint64_t timestamp;float z;"), message("A", struct.pack("<BH", 0, 0) + b"height")]
Path("flight.ulg").write_bytes(b"".join([*parts, row(1000), parameter(30), row(2000)]))
PY
qgc=$(./venv/bin/ulog_params -f qgc flight.ulg | tr '\t' ' ')
csv=$(./venv/bin/ulog_params -f csv flight.ulg)
echo "qgc: $qgc; csv: $csv"
[ "$qgc" = "1 1 RTL_RETURN_ALT 60.0 9" ] && [ "$csv" = "RTL_RETURN_ALT,60.0,30.0" ]
