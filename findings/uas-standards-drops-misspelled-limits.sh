#!/bin/sh
# uas-standards drops the limit of an ED-269 zone whose member is misspelled, and reads a time without a zone as UTC.
#
# uas-standards 4.4.0, implicitdict 5.0.0, ED269Schema.from_dict. Guess: an unknown member is refused or kept. Seen:
# "uperLimit": 120 is gone from the result, so the zone has no upper limit; "2026-11-28T10:00:00" becomes 10:00 UTC. No
# error, no warning. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q uas-standards==4.4.0 implicitdict==5.0.0
cd "$folder"
./venv/bin/python - <<'PY'
from uas_standards.eurocae_ed269 import ED269Schema

circle = {"type": "Circle", "center": [8.5, 47.4], "radius": 500}
volume = {"uomDimensions": "M", "lowerLimit": 0, "lowerVerticalReference": "AGL", "uperLimit": 120}
volume |= {"upperVerticalReference": "AGL", "horizontalProjection": circle}
zone = {"identifier": "A1", "country": "CHE", "type": "COMMON", "restriction": "PROHIBITED", "zoneAuthority": []}
zone |= {"applicability": [{"permanent": "NO", "startDateTime": "2026-11-28T10:00:00"}], "geometry": [volume]}
read = ED269Schema.from_dict({"features": [zone]}).features[0]
members, start = sorted(read.geometry[0]), read.applicability[0].startDateTime.datetime
print(f"members of the volume: {members}\nstart: {start.isoformat()}")
is_gone = "uperLimit" not in members and "upperLimit" not in members
raise SystemExit(0 if is_gone and start.isoformat() == "2026-11-28T10:00:00+00:00" else 1)
PY
