#!/bin/sh
# dji-telemetry writes all GPX heights as 0 m, and reads heights below home as 0 m.
#
# dji-telemetry 1.0.1, parse_srt and to_gpx, on an SRT as its README shows: [rel_alt: 57.200 abs_alt: 204.644]. Guess:
# the GPX is at 204.6 m, and -12.3 m below home is kept. Seen: abs_alt is never read, 0 m; rel_alt is 57.2, but 0
# instead of -12.3. An SRT of the older form, GPS (8.5, 47.4, 15), is a track at 0 N 0 E without an error. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q dji-telemetry==1.0.1
cd "$folder"
./venv/bin/python - <<'PY'
import re

import dji_telemetry

new = "[iso: 100] [latitude: 47.400000] [longitude: 8.500000] [rel_alt: {} abs_alt: {}] [ct: 5500]"
old = "F/2.8, SS 206.14, ISO 150, EV 0, GPS (8.5000, 47.4000, 15), D 24.61m, H 6.00m, H.S 1.20m/s, V.S -0.50m/s"


def written(path, rows):
    times = "{0}\n00:00:0{0},000 --> 00:00:0{0},900\n"
    head = "FrameCnt: {0}, DiffTime: 900ms\n2026-11-28 10:00:0{0}.000\n"
    open(path, "w").write("".join((times + head).format(n) + row + "\n\n" for n, row in enumerate(rows, 1)))
    return dji_telemetry.parse_srt(path)


valley = written("valley.SRT", [new.format("57.200", "204.644"), new.format("-12.300", "135.144")])
before = written("old.SRT", [old, old])
dji_telemetry.to_gpx(valley, "valley.gpx")
in_gpx = re.findall("<ele>(.*)</ele>", open("valley.gpx").read())
heights = [frame.rel_alt for frame in valley.frames]
place = (before.frames[0].latitude, before.frames[0].longitude)
print(f"GPX {in_gpx} m, above home {heights} m; older form at {place}")
raise SystemExit(0 if in_gpx == ["0.0", "0.0"] and heights == [57.2, 0] and place == (0, 0) else 1)
PY
