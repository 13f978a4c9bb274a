#!/bin/sh
# uas-standards cuts the decimals off a zone's limit, and refuses times with seconds.
#
# uas-standards 4.4.0, eurocae_ed269, implicitdict 5.0.0. Guess: an upper limit of 100.9 m stays 100.9 m, or is refused;
# "06:00:00Z", ISO 8601, is a time. Seen: the limit is 100, without a word, so that the zone is 0.9 m lower than
# published; of times only "06:00Z" and "06:00:00.00Z" are taken. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q uas-standards==4.4.0 implicitdict==5.0.0 arrow==1.4.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from implicitdict import ImplicitDict
from uas_standards.eurocae_ed269 import ED269TimeType, UASZoneAirspaceVolume

volume = {"uomDimensions": "M", "lowerLimit": 0, "lowerVerticalReference": "AGL", "upperLimit": 100.9}
volume |= {"upperVerticalReference": "AGL", "horizontalProjection": {"type": "Circle", "center": [8, 47], "radius": 50}}
limit = ImplicitDict.parse(volume, UASZoneAirspaceVolume).upperLimit
taken = []
for text in ("06:00Z", "06:00:00.00Z", "06:00:00Z"):
    try:
        taken.append(str(ED269TimeType(text)))
    except ValueError as error:
        print(f"{text}: {type(error).__name__}")
print(f"uas-standards {version('uas-standards')}: upperLimit 100.9 becomes {limit}; times taken {taken}")
raise SystemExit(0 if limit == 100 and len(taken) == 2 else 1)
PY
