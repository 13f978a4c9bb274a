#!/bin/sh
# gnsstime adds 1024 days for a rollover of the GPS week, not 1024 weeks: a log of 2025 is one of 1992.
#
# gnsstime 0.0.9, gnsstime.from_gpsw and the difference of two times. Guess: week 346 after two rollovers is week 2394,
# 23 November 2025, as legacy messages and RTCM count weeks modulo 1024. Seen: 2 April 1992. With gpswd, the seconds of
# tow are left out; without it they count. Two times that are 0.3 s apart differ by 0 s, as microseconds are subtracted
# from themselves; at 15 m/s these are 4.5 m. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q gnsstime==0.0.9
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from gnsstime import gnsstime

full, rolled = gnsstime.from_gpsw(2394), gnsstime.from_gpsw(2394 - 2 * 1024, nrollover=2)
with_day, without = gnsstime.from_gpsw(2394, gpswd=0, tow=3600.0), gnsstime.from_gpsw(2394, tow=3600.0)
later, earlier = (gnsstime(2025, 11, 23, 12, 0, 0, micros) for micros in (500000, 200000))
apart = (later - earlier).total_seconds()
print(f"gnsstime {version('gnsstime')}: week 2394 is {full:%F}, 346 after two rollovers {rolled:%F};")
print(f"second 3600 of it {without:%T}, with its day {with_day:%T}; 0.3 s apart: {apart} s")
as_seen = f"{full:%F} {rolled:%F}" == "2025-11-23 1992-04-02" and f"{without:%T} {with_day:%T}" == "01:00:00 00:00:00"
raise SystemExit(0 if as_seen and apart == 0 else 1)
PY
