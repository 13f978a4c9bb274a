#!/bin/sh
# arinc424 gives the minimum altitudes of the last eleven cells of a row to their eastern neighbors.
#
# arinc424 0.3.0, Record of a Grid MORA, which has a minimum off-route altitude in hundreds of feet for each of 30
# degrees of longitude. Guess: they are named 1 to 30, in their order. Seen: 1 to 19 and 21 to 31. The wall of 15,300
# feet in the 25th cell is "MORA (26)", and "MORA (25)" is the 1,200 feet of the valley to its west; the 20th has none.
# It is so in json and in the table of decode. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q arinc424==0.3.0
cd "$folder"
./venv/bin/python - <<'PY'
import json
from importlib.metadata import version

from arinc424.record import Record

hundreds = [12] * 30
hundreds[25 - 1] = 153
cells = "".join(f"{altitude:03d}" for altitude in hundreds)
record = Record()
assert record.read(f"S   AS       N45E000{'':10}{cells}   000012601")
read = {name: value for name, value in json.loads(record.json(output=False)).items() if name.startswith("MORA")}
wall = [name for name, value in read.items() if value == "153"]
missing = [number for number in range(2, 32) if f"MORA ({number})" not in read]
print(f"arinc424 {version('arinc424')}: {len(read)} cells, without {missing}; the wall of the 25th is {wall}")
as_seen = len(read) == 30 and missing == [20] and wall == ["MORA (26)"] and read["MORA (25)"] == "012"
raise SystemExit(0 if as_seen and "MORA (31)" in read else 1)
PY
