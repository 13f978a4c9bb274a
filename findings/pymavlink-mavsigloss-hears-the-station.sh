#!/bin/sh
# pymavlink's mavsigloss finds no loss of signal in a flight that was without one for a minute.
#
# pymavlink 2.4.50, mavsigloss.py of a telemetry log of 100 s with a vehicle's heartbeats, which stop for 60 s, and
# those of the station, which writes its own, once a second. Guess: "Sig lost for 61.0s". Seen: nothing, as the messages
# of all systems, the station's own too, count as signal; with --condition on the vehicle's heartbeat it is found. Exits
# 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pymavlink==2.4.50
cd "$folder"
cat >log.py <<'PY'
import struct
from pathlib import Path

from pymavlink.dialects.v20 import ardupilotmega as dialect

vehicle, station = dialect.MAVLink(None, 1, 1), dialect.MAVLink(None, 255, 190)
log = b""
for half in range(200):
    sender, kind = (vehicle, 2) if half % 2 else (station, 6)
    if sender is vehicle and 20 < half / 2 < 80:
        continue
    stamp = struct.pack(">Q", 1_780_000_000_000_000 + 500_000 * half)
    log += stamp + sender.heartbeat_encode(kind, 3, 81, 0, 4).pack(sender)
Path("flight.tlog").write_bytes(log)
PY
./venv/bin/python log.py
MAVLINK20=1 ./venv/bin/mavsigloss.py flight.tlog >all
MAVLINK20=1 ./venv/bin/mavsigloss.py --condition 'HEARTBEAT.type==2' flight.tlog >vehicle
echo "losses found: $(grep -c lost all); of the vehicle's heartbeats: $(grep -o 'lost for [0-9.]*s' vehicle)"
[ "$(grep -c lost all)" = 0 ] && grep -q 'lost for 6[01]\.[0-9]s' vehicle
