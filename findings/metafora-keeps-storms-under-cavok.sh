#!/bin/sh
# metafora forecasts a thunderstorm under CAVOK, which says that there is none.
#
# metafora 1.1.8, propagate_forecasts of "TAF LSZH 121100Z 1212/1318 24008KT 2000 TSRA BKN010CB BECMG 1214/1216 CAVOK".
# It hands what holds from each period on to the next. Guess: as CAVOK is for visibility, weather and cloud (ICAO
# Annex 3), the second period has neither TSRA nor CB, as after "9999 NSW NSC". Seen: CAVOK, TSRA and BKN010CB in one
# period. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q metafora==1.1.8 dataclasses-json==0.6.7 pandas==3.1.1 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from metafora import Taf
from metafora.taf import propagate_forecasts

first = "TAF LSZH 121100Z 1212/1318 24008KT 2000 TSRA BKN010CB BECMG 1214/1216 "


def later(end):
    period = propagate_forecasts(Taf.from_text(first + end).forecasts)[1].to_dict()
    return period["visibility"]["cavok"], period["weather"], period["clouds"]


found, written_out = later("CAVOK"), later("9999 NSW NSC")
print(f"metafora {version('metafora')}, from 14 h: CAVOK, weather and cloud {found}; by NSW and NSC {written_out}")
storm = [{"descriptor": "TS", "phenomena": "RA"}], [{"amount": "BKN", "height": 305, "cloud": "CB"}]
raise SystemExit(0 if found == (True, *storm) and written_out == (False, [{}], [{}]) else 1)
PY
