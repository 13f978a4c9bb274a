#!/bin/sh
# pymavlink's mavflighttime finds no time in the air in a slow survey.
#
# pymavlink 2.4.50, mavflighttime.py. Guess: the time in the air is that of an armed vehicle above the ground. Seen:
# only the ground speed of the GPS counts. Ten minutes at 30 m and 2 m/s are 0:00; at 5 m/s with five stops of a minute,
# 5:00. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
./venv/bin/python - <<'PY'
import struct

from pymavlink.dialects.v20 import ardupilotmega


def write(path, speed_at):
    link = ardupilotmega.MAVLink(None, 1, 1)
    with open(path, "wb") as log:
        for n in range(601):
            gps = (n * 1000000, 3, 473977418, 85000000 + 100 * n, 518000, 100, 100, round(speed_at(n) * 100), 9000, 12)
            place = (n * 1000, 473977418, 85000000 + 100 * n, 518000, 30000, 0, 0, 0, 9000)
            beat, armed = (2, 3, 129, 3, 4, 3), 1790000000000000 + n * 1000000
            rows = [link.heartbeat_encode(*beat), link.gps_raw_int_encode(*gps)]
            rows += [link.global_position_int_encode(*place)]
            for row in rows:
                log.write(struct.pack(">Q", armed) + row.pack(link))
                link.seq = (link.seq + 1) % 256


write("slow.tlog", lambda n: 2.0)
write("stops.tlog", lambda n: 5.0 if n % 120 < 60 else 0.0)
PY
slow=$(./venv/bin/python venv/bin/mavflighttime.py slow.tlog | grep "Total time")
stops=$(./venv/bin/python venv/bin/mavflighttime.py stops.tlog | grep "Total time")
echo "2 m/s: $slow; five stops: $stops"
[ "$slow" = "Total time in air: 0:00" ] && [ "$stops" = "Total time in air: 5:00" ]
