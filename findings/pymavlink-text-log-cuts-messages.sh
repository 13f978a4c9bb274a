#!/bin/sh
# pymavlink cuts the text of a MSG in a text log at its first comma.
#
# pymavlink 2.4.50, DFReader.DFReader_text, for logs that were converted to text (.log). Guess: the last field of a
# message, a text, is the rest of its line. Seen: "EKF3 IMU0 yaw aligned, using GPS" is read as "EKF3 IMU0 yaw aligned",
# without an error; the binary log of the same message keeps the text. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from pathlib import Path

from pymavlink import DFReader

TEXT = "EKF3 IMU0 yaw aligned, using GPS"
FORMATS = (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"), (150, 75, "MSG", "QZ", "TimeUS,Message")
lines = ["FMT, " + ", ".join(map(str, row)) for row in FORMATS]
Path("flight.log").write_text("\n".join([*lines, f"MSG, 1000000, {TEXT}", "MSG, 2000000, Reached command #3"]) + "\n")
binary = b"".join(
    b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", kind, size, *(word.encode() for word in words))
    for kind, size, *words in FORMATS
)
for time, text in ((1000000, TEXT), (2000000, "Reached command #3")):
    binary += b"\xa3\x95\x96" + struct.pack("<Q64s", time, text.encode())
Path("flight.bin").write_bytes(binary)
logs = DFReader.DFReader_text("flight.log"), DFReader.DFReader_binary("flight.bin")
seen = [log.recv_match(type="MSG").Message for log in logs]
print("text log:", seen[0], "| binary log:", seen[1])
raise SystemExit(0 if seen == ["EKF3 IMU0 yaw aligned", TEXT] else 1)
PY
