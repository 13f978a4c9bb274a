#!/bin/sh
# aviconv-met loses the gale of a TAF after FM, and after PROB30 TEMPO.
#
# aviconv-met 0.4.0, parse_taf. Guess: 35 knots with gusts of 55 are in change_groups with their time. Seen: for
# FM282000 there is no group at all, for PROB30 TEMPO 2820/2824 one without a time and a wind, nothing said; for PROB40
# 2820/2824 and for BECMG all is there. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q aviconv-met==0.4.0
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from aviconv_met import parse_taf


def gusts(change):
    read = parse_taf(f"TAF LSZH 281125Z 2812/2918 24005KT 9999 SCT030 {change} 24035G55KT=")
    return [(group.validity_from, group.wind and group.wind.gust) for group in read.change_groups]


seen = [gusts(change) for change in ("FM282000", "PROB30 TEMPO 2820/2824", "PROB40 2820/2824", "BECMG 2820/2824")]
print(f"aviconv-met {version('aviconv-met')}, start and gust: {seen}")
raise SystemExit(0 if seen == [[], [(None, None)], [("2820", 55)], [("2820", 55)]] else 1)
PY
