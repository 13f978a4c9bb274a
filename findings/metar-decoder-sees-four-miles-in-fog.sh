#!/bin/sh
# metar-decoder reads a visibility of a quarter mile as four miles, and air of -1 degrees as 14 from a runway's number.
#
# metar-decoder 1.0.2, MetarDecoder, of reports in fog with cloud at 200 feet. Guess: 1/4SM and 3/4SM are 402 and 1207
# m, as 1 1/2SM is 2414 m; M01/M01 is -1 degrees, whatever is before it. Seen: both are 6437 m, as what follows the bar
# is taken for whole miles. With the runway range "R14/0600" the air has 14 degrees, its dew point 6 and its humidity is
# 58 %. A forecast "BECMG CAVOK" makes the visibility of 2000 m at present one of 10000. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q metar-decoder==1.0.2
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from metar_decoder.decoder import MetarDecoder


def read(report, *names):
    fields = MetarDecoder(report).to_flat_dict()
    return [getattr(fields[name], "celsius", fields[name]) for name in names]


american = "METAR KJFK 121251Z 31003KT {} FG OVC002 18/16 A2992"
sight = {miles: read(american.format(miles), "visibility_m")[0] for miles in ("1/4SM", "3/4SM", "1 1/2SM")}
names = "temperature", "dew_point", "humidity_rel_percent"
air = [read(f"METAR LSZH 121250Z 24003KT 0300 {range_}FG OVC002 M01/M01 Q0998", *names) for range_ in ("R14/0600 ", "")]
storm = "METAR LSZH 121250Z 24008KT 2000 TSRA BKN010CB 18/16 Q1013"
trend = [read(storm + end, "visibility_m", "ceiling_ft") for end in (" BECMG CAVOK", "")]
print(f"metar-decoder {version('metar-decoder')}: {sight} m; air with a runway's range {air[0]}, without {air[1]};")
print(f"visibility and ceiling with the trend {trend[0]}, without {trend[1]}")
as_seen = [*sight.values()] == [6437, 6437, 2414] and air == [[14, 6, 58.5], [-1, -1, 100]]
raise SystemExit(0 if as_seen and trend == [[10000, None], [2000, 1000]] else 1)
PY
