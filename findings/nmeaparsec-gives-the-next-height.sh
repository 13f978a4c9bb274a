#!/bin/sh
# nmeaparsec gives a position the height of the next one, from a receiver with five positions a second.
#
# nmeaparsec 0.1.0, NMEAParser on a climb with GGA before RMC each 0.2 s. Guess: each point has the height of its time.
# Seen: that of 0.2 s later, and the last point is lost. Both sentences are joined by the whole second, and the first
# GGA has no date yet. At one position a second all but the first are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q nmeaparsec==0.1.0 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
from functools import reduce
from importlib.metadata import version

from nmeaparsec import NMEAParser

PLACE = "4700.000,N,00800.000,E"


def sentence(body):
    return f"${body}*{reduce(lambda total, letter: total ^ ord(letter), body, 0):02X}"


def heights(step):
    """Times in seconds and heights that the parser gives; the climb is 10 m/s from 500 m."""
    parser = NMEAParser()
    for index in range(4):
        seconds = index * step
        clock = f"1000{seconds:05.2f}"
        parser.parse_line(sentence(f"GPGGA,{clock},{PLACE},1,08,1.0,{500 + 10 * seconds:.1f},M,48.0,M,,"))
        parser.parse_line(sentence(f"GPRMC,{clock},A,{PLACE},5.0,90.0,010626,,,A"))
    return [(point.timestamp.second + point.timestamp.microsecond / 1e6, point.altitude) for point in parser.gps_data]


fast, slow = heights(0.2), heights(1)
print(f"nmeaparsec {version('nmeaparsec')}: seconds and meters at 5 Hz {fast}, at 1 Hz {slow}")
as_seen = fast == [(0.0, 502.0), (0.2, 504.0), (0.4, 506.0)]
raise SystemExit(0 if as_seen and slow == [(1.0, 510.0), (2.0, 520.0), (3.0, 530.0)] else 1)
PY
