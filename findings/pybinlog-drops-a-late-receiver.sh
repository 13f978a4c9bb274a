#!/bin/sh
# pybinlog leaves out a GPS receiver that joins late, or weaves it into the track of another.
#
# pybinlog 0.3.4, bin2csv of a log of ArduPilot, a CSV file for each instance of a message. Guess: a file for each
# receiver. Seen: the instances are those of the first six rows. Of three receivers, the third of which finds its
# satellites after two seconds, the ten rows of the third are in no file. Of two receivers, the second of which does so,
# one file has both in turn, 111 m apart. Nothing is said. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pybinlog==0.3.4 pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import csv
import struct
from contextlib import redirect_stdout
from importlib.metadata import version
from pathlib import Path

from utils.bin2csv import convert2csv

COLUMNS = "TimeUS,I,Lat,Lng,Alt"
FORMATS = (128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"), (130, 24, "GPS", "QBLLf", COLUMNS)
HEAD = b"".join(
    b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", kind, size, *(word.encode() for word in words))
    for kind, size, *words in FORMATS
)


def files(receivers):
    """Rows of each receiver in each file: all but the last receiver from the start, the last after ten rounds."""
    log = HEAD
    for turn in range(20):
        for receiver in range(receivers if turn >= 10 else receivers - 1):
            row = 200000 * turn, receiver, 470000000 + 10000 * receiver, 85000000, 500
            log += b"\xa3\x95\x82" + struct.pack("<QBiif", *row)
    place = Path(f"of{receivers}")
    place.mkdir()
    (place / "log.bin").write_bytes(log)
    with redirect_stdout(None):
        convert2csv(str(place / "log.bin"), "GPS", str(place))
    read = {path.name: [row["I"] for row in csv.DictReader(path.open())] for path in sorted(place.glob("*.csv"))}
    return {name: {one: rows.count(one) for one in sorted(set(rows))} for name, rows in read.items()}


two, three = files(2), files(3)
print(f"pybinlog {version('pybinlog')}, rows of each receiver: of two {two}, of three {three}")
as_seen = two == {"GPS-log.csv": {"0": 20, "1": 10}}
raise SystemExit(0 if as_seen and three == {"GPS0-log.csv": {"0": 20}, "GPS1-log.csv": {"1": 20}} else 1)
PY
