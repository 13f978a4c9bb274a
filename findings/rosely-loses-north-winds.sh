#!/bin/sh
# rosely leaves winds from 0 degrees out of its wind rose.
#
# rosely 0.0.2.post3 with pandas 2.2.3, WindRose.calc_stats. Guess: of six winds, three from north at 0 degrees, half
# are from N. Seen: none; east, south and west have a third each, and nothing is said. Bins are open on the left, and
# the first begins at 0. At 360 degrees all six are there. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rosely==0.0.2.post3 pandas==2.2.3 numpy==2.2.6 plotly==5.24.1
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import pandas as pd
from rosely import WindRose


def shares(north):
    rose = WindRose(pd.DataFrame({"ws": [5.0, 5.1, 5.2, 5.3, 5.4, 5.5], "wd": [north] * 3 + [90.0, 180.0, 270.0]}))
    rose.calc_stats(bins=2)
    return rose.wind_df.groupby("direction").frequency.sum()[lambda share: share > 0].round(1).to_dict()


at_0, at_360 = shares(0.0), shares(360.0)
print(f"rosely {version('rosely')}: north at 0 degrees {at_0}, at 360 {at_360}")
raise SystemExit(0 if at_0 == {"E": 33.3, "S": 33.3, "W": 33.3} and at_360["N"] == 50 else 1)
PY
