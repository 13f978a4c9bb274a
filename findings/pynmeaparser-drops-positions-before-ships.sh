#!/bin/sh
# pynmeaparser drops each position that arrives in one chunk with a ship's AIS report.
#
# pynmeaparser 1.0.0, NMEAParser.process, which takes chunks of a stream and keeps what is not complete. Guess: two
# whole sentences in a chunk are both handled. Seen: of $GPGGA and !AIVDM only the ship, as all before the first "!" is
# dropped. Of two $ sentences the second waits for the next chunk. One sentence a chunk is right. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pynmeaparser==1.0.0
cd "$folder"
./venv/bin/python - <<'PY'
from functools import reduce
from importlib.metadata import version

from pynmeaparser import NMEAParser


def sentence(start, body):
    return f"{start}{body}*{reduce(lambda total, letter: total ^ ord(letter), body, 0):02X}\r\n"


place = sentence("$", "GPGGA,100000.00,4700.000,N,00800.000,E,1,08,1.0,500.0,M,48.0,M,,")
speed = sentence("$", "GPRMC,100000.00,A,4700.000,N,00800.000,E,5.0,90.0,010626,,,A")
ship = sentence("!", "AIVDM,1,1,,A," + "1" * 28 + ",0")


def handled(*chunks):
    names, parser = [], NMEAParser()
    for name in ("GPGGA", "GPRMC", "AIVDM"):
        parser.add_handler(name, lambda fields: names.append(fields[0]))
    for chunk in chunks:
        parser.process(chunk)
    return names


apart, together, waiting = handled(place, ship), handled(place + ship, speed), handled(place + speed)
print(f"pynmeaparser {version('pynmeaparser')}: two chunks {apart}; one, then a speed {together}; two of $ {waiting}")
as_seen = apart == ["GPGGA", "AIVDM"] and waiting == ["GPGGA"]
raise SystemExit(0 if as_seen and together == ["AIVDM", "GPRMC"] else 1)
PY
