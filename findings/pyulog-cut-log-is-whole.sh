#!/bin/sh
# pyulog reads a log that was cut in its last message and says nothing of it.
#
# pyulog 1.3.0. Guess: `file_corruption` is true, or it is said in the log. Seen: it is false, and the last message is
# missing. A log that ends so is usual where the battery was pulled. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyulog==1.3.0 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from importlib.metadata import version
from pathlib import Path

from pyulog import ULog


def message(kind, content):
    return struct.pack("<HB", len(content), ord(kind)) + content


parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), message("B", bytes(40))]
parts += [message("F", b"height:uint64_t timestamp;float z;"), message("A", struct.pack("<BH", 0, 0) + b"height")]
parts += [message("D", struct.pack("<HQf", 0, 1000 * n, float(n))) for n in range(1, 6)]
Path("whole.ulg").write_bytes(b"".join(parts))
Path("cut.ulg").write_bytes(b"".join(parts)[:-3])
whole, cut = (ULog(name) for name in ("whole.ulg", "cut.ulg"))
counts = [len(log.data_list[0].data["z"]) for log in (whole, cut)]
print(f"pyulog {version('pyulog')}: {counts[0]} values whole, {counts[1]} cut, file_corruption {cut.file_corruption}")
raise SystemExit(0 if counts == [5, 4] and not cut.file_corruption else 1)
PY
