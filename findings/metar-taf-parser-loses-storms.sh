#!/bin/sh
# metar-taf-parser gives no wind where a report has more than 99 knots.
#
# metar-taf-parser 9.1.3 (npm) and metar-taf-parser-mivek 1.13.1 (PyPI). Guess: P99KT and P49MPS (ICAO's Annex 3: 100 kt
# or 50 m/s and more) are read as at least that. Seen: the wind of the METAR is undefined or None, that of the TAF, too;
# visibility and clouds are read, nothing is raised. A limit on the wind is not exceeded. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q metar-taf-parser-mivek==1.13.1
cd "$folder"
npm install --silent --no-audit --no-fund metar-taf-parser@9.1.3 >/dev/null
cat >parse.mjs <<'JS'
import { parseMetar, parseTAF } from "metar-taf-parser";

const rest = "0500 OVC010";
const winds = ["240P99KT", "140P49MPS", "24099KT"];
const reports = winds.map((wind) => parseMetar(`LSZH 291150Z ${wind} ${rest} 10/10 Q0990`));
const taf = parseTAF(`TAF LSZH 291130Z 2912/3012 240P99KT ${rest}`);
const speeds = [...reports, taf].map((report) => report.wind?.speed);
console.log(`npm: speeds of 240P99KT, 140P49MPS, 24099KT and of a TAF with 240P99KT: ${JSON.stringify(speeds)}`);
const isRead = [...reports, taf].every((report) => report.clouds.length === 1);
process.exit(JSON.stringify(speeds) === "[null,null,99,null]" && isRead ? 0 : 1);
JS
node parse.mjs
./venv/bin/python - <<'PY'
from metar_taf_parser.parser.parser import MetarParser, TAFParser

rest = "0500 OVC010"
reports = [
    MetarParser().parse(f"LSZH 291150Z {wind} {rest} 10/10 Q0990") for wind in ("240P99KT", "140P49MPS", "24099KT")
]
reports.append(TAFParser().parse(f"TAF LSZH 291130Z 2912/3012 240P99KT {rest}"))
speeds = [report.wind and report.wind.speed for report in reports]
print(f"PyPI: the same speeds {speeds}")
raise SystemExit(0 if speeds == [None, None, 99, None] and all(len(r.clouds) == 1 for r in reports) else 1)
PY
