#!/bin/sh
# orangebox reads a latitude as a number of satellites in a blackbox log that has each frame.
#
# orangebox 0.4.0, the newest that pip installs, on two logs of one position. Cleanflight writes a time into GPS frames
# only where it leaves frames of the log out, and the header says so. Guess: both logs give the same position. Seen:
# without a time, the first field is left out as if it were one. The satellites are 473977418, the first coordinate is
# the longitude, and the second is the altitude; the course is in no row. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q orangebox==0.4.0
cd "$folder"
./venv/bin/python - <<'PY'
from contextlib import redirect_stdout
from importlib.metadata import version
from pathlib import Path

from orangebox import Parser

POSITION = {"GPS_numSat": 11, "GPS_coord[0]": 473977418, "GPS_coord[1]": 85455941, "GPS_altitude": 488}
POSITION |= {"GPS_speed": 520, "GPS_ground_course": 900}


def number(value, is_signed=False):
    """A number in groups of seven bits, the lowest first."""
    rest = value * 2 if is_signed else value
    groups = []
    while rest > 127:
        groups.append(rest & 127 | 128)
        rest >>= 7
    return bytes([*groups, rest])


def log(is_timed):
    time = {"time": (10, 1)} if is_timed else {}
    ways = time | dict.fromkeys(POSITION, (0, 1)) | dict.fromkeys(("GPS_coord[0]", "GPS_coord[1]"), (7, 0))
    fields = {"I": {"loopIteration": (0, 1), "time": (0, 1)}, "G": ways}
    fields["H"] = {"GPS_home[0]": (0, 0), "GPS_home[1]": (0, 0)}
    head = ["Product:Blackbox flight data recorder by Nicholas Sherlock", "Data version:2", "I interval:32"]
    head += ["P interval:1/1" if not is_timed else "P interval:1/2", "minthrottle:1150", "motorOutput:1150,1850"]
    head += ["vbatref:4095", "Field P predictor:6,2", "Field P encoding:9,0"]
    for kind, defined in fields.items():
        head.append(f"Field {kind} name:" + ",".join(defined))
        for index, name in enumerate(("predictor", "encoding")):
            head.append(f"Field {kind} {name}:" + ",".join(str(way[index]) for way in defined.values()))
    data = "".join(f"H {line}\n" for line in head).encode()
    home = 473977000, 85455000
    offsets = [POSITION["GPS_coord[0]"] - home[0], POSITION["GPS_coord[1]"] - home[1]]
    row = [number(value) for value in POSITION.values()]
    row[1:3] = [number(value, is_signed=True) for value in offsets]
    data += b"I" + number(0) + number(1000) + b"H" + b"".join(number(value, is_signed=True) for value in home)
    data += b"G" + (number(5) if is_timed else b"") + b"".join(row)
    data += b"".join(b"I" + number(turn) + number(1000 * turn + 1000) for turn in (1, 2, 3))
    return data + b"E\xffEnd of log\0"


def read(is_timed):
    path = Path("log.bbl")
    path.write_bytes(log(is_timed))
    with redirect_stdout(None):
        parser = Parser.load(str(path))
        last = [frame.data for frame in parser.frames()][-1]
    return {name: value for name, value in zip(parser.field_names, last) if name in POSITION}


timed, untimed = read(True), read(False)
print(f"orangebox {version('orangebox')}, with times {timed}\nwithout times {untimed}")
shifted = dict(zip(POSITION, list(POSITION.values())[1:]))
raise SystemExit(0 if timed == POSITION and untimed == shifted else 1)
PY
