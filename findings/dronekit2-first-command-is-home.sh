#!/bin/sh
# dronekit2 uploads the first command of a mission in the place of home, which ArduPilot does not fly.
#
# dronekit2 3.0.0, pymavlink 2.4.50, with a vehicle of ArduPilot's protocol on the loopback and the calls of the class's
# example: clear, add, upload. Guess: item 0 is home, the first command is item 1. Seen: without a download before, the
# takeoff is item 0, a mission of one command has the length 0, and nothing is said. After a download it is item 1.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q dronekit2==3.0.0 pymavlink==2.4.50
cd "$folder"
cat >upload.py <<'PY'
import socket
import threading
import time

from dronekit import Command, connect
from pymavlink import mavutil

PLACE = 473977000, 85456000
TAKEOFF, FRAME = 22, 3
received = []


def fly(port):
    link = mavutil.mavlink_connection(f"tcpin:127.0.0.1:{port}", source_system=1, source_component=1)
    due = 0.0
    while True:
        if time.monotonic() > due:
            due = time.monotonic() + 0.5
            link.mav.heartbeat_send(2, 3, 81, 0, 4)
            link.mav.gps_raw_int_send(0, 3, *PLACE, 500000, 100, 100, 0, 0, 10)
        message = link.recv_match(blocking=True, timeout=0.1)
        kind = message and message.get_type()
        if kind == "PARAM_REQUEST_LIST":
            link.mav.param_value_send(b"SYSID_THISMAV", 1.0, 9, 1, 0)
        elif kind == "MISSION_REQUEST_LIST":
            link.mav.mission_count_send(255, 0, 1)
        elif kind == "MISSION_REQUEST":
            link.mav.mission_item_send(255, 0, 0, 0, 16, 0, 1, 0, 0, 0, 0, 47.3977, 8.5456, 500)
        elif kind == "MISSION_COUNT":
            received.append([None] * message.count)
            link.mav.mission_request_send(255, 0, 0)
        elif kind == "MISSION_ITEM":
            received[-1][message.seq] = message.command
            if message.seq + 1 < len(received[-1]):
                link.mav.mission_request_send(255, 0, message.seq + 1)
            else:
                link.mav.mission_ack_send(255, 0, 0)


with socket.create_server(("127.0.0.1", 0)) as free:
    port = free.getsockname()[1]
threading.Thread(target=fly, args=(port,), daemon=True).start()
time.sleep(1)
vehicle = connect(f"tcp:127.0.0.1:{port}", wait_ready=False)
commands = vehicle.commands
lengths = []
for is_downloaded in (False, True):
    if is_downloaded:
        commands.download()
        commands.wait_ready()
    commands.clear()
    commands.add(Command(0, 0, 0, FRAME, TAKEOFF, 0, 1, 0, 0, 0, 0, 47.3977, 8.5456, 30))
    commands.upload(timeout=20)
    lengths.append(len(commands))
print(f"commands uploaded without and with a download {received}, lengths {lengths}", flush=True)
vehicle.close()
raise SystemExit(0 if received == [[TAKEOFF], [16, TAKEOFF]] and lengths == [0, 1] else 1)
PY
timeout 90 ./venv/bin/python upload.py
