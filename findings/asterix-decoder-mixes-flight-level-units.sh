#!/bin/sh
# asterix-decoder gives one flight level as 50 from ADS-B and radar reports, and as 5000 from tracks.
#
# asterix_decoder 0.7.11 and asterix4py 1.0.6, one record each of ASTERIX categories 21, 48 and 62 at FL 50. Guess: 50
# in all, as all three have quarters of a flight level. Seen: "Flight Level" of I021/145 and I048/090 is in flight
# levels, "Measured Flight Level" of I062/136 in feet, and no result names its unit. Both decoders do so. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q asterix_decoder==0.7.11 asterix4py==1.0.6
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import asterix
from asterix4py import AsterixParser

RECORDS = {  # category, length, presence of items, source, 200 quarters of a flight level
    ("145", "FL"): "15 000a 810102 0102 00c8",
    ("090", "FL"): "30 0008 84 0102 00c8",
    ("136", "MFL"): "3e 000a 810120 0102 00c8",
}


def levels(item, name, record):
    data = bytes.fromhex(record)
    ((read,), (other,)) = asterix.parse(data), AsterixParser(data).get_result().values()
    return read["I" + item][name]["val"], other[item][name]


seen = {record[:2]: levels(*names, record) for names, record in RECORDS.items()}
print(f"asterix_decoder {version('asterix_decoder')} and asterix4py, by category (hexadecimal): {seen}")
raise SystemExit(0 if seen == {"15": (50, 50), "30": (50, 50), "3e": (5000, 5000)} else 1)
PY
