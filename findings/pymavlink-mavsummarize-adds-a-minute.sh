#!/bin/sh
# pymavlink's mavsummarize adds a minute to half of all flights.
#
# pymavlink 2.4.50, mavsummarize.py. Guess: a log of 100 seconds has a total time of 1:40. Seen: the minutes are
# rounded, 100 seconds are 2:40, 59.9 seconds are 1:60; 80 seconds are 1:20. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
cat >write.py <<'PY'
import struct
import sys

from pymavlink.dialects.v20 import ardupilotmega

link, seconds = ardupilotmega.MAVLink(None, 1, 1), float(sys.argv[1])
with open(f"{sys.argv[1]}.tlog", "wb") as log:
    for n in range(round(seconds * 10) + 1):
        about = (n * 100000, 3, 473977418 + n, 85000000, 488000, 100, 100, 10, 0, 12)
        messages = [link.heartbeat_encode(2, 3, 129, 4, 4, 3), link.gps_raw_int_encode(*about)]
        for message in messages:
            log.write(struct.pack(">Q", 1790000000000000 + n * 100000) + message.pack(link))
            link.seq = (link.seq + 1) % 256
PY
seen=""
for seconds in 80 100 59.9; do
  ./venv/bin/python write.py $seconds
  total=$(./venv/bin/python venv/bin/mavsummarize.py $seconds.tlog | grep -m 1 "Total time" | tr -d ' ')
  echo "$seconds seconds: $total"
  seen="$seen ${total#*:}"
done
[ "$seen" = " ss):1:20 ss):2:40 ss):1:60" ]
