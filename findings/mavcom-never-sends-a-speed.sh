#!/bin/sh
# mavcom says that it set a ground speed, and sends nothing; its heading in degrees is in hundredths.
#
# mavcom 1.1.8, set_groundspeed, motion_state. Guess: set_groundspeed(5) sends MAV_CMD_DO_CHANGE_SPEED; a vehicle that
# points to the east has "heading in degrees" 90. Seen: the command is encoded and dropped, and "Set groundspeed: 5m/s"
# is printed; heading is 9000. fly_to with a speed flies at the old one. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavcom==1.1.8 pymavlink==2.4.50 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
import io
from contextlib import redirect_stdout
from importlib.metadata import version
from types import SimpleNamespace

from mavcom.mavcontrol import Mavcom
from pymavlink.dialects.v20 import ardupilotmega as mavlink

wire = io.BytesIO()
vehicle = Mavcom.__new__(Mavcom)
vehicle.connection = SimpleNamespace(mav=mavlink.MAVLink(wire))
said = io.StringIO()
with redirect_stdout(said):
    vehicle.set_groundspeed(5)
sent = len(wire.getvalue())
position = {"lat": 470000000, "lon": 80000000, "relative_alt": 50_000, "hdg": 9000}
vehicle.current_values = {"GLOBAL_POSITION_INT": position, "VFR_HUD": {"groundspeed": 5, "climb": 0}}
heading = vehicle.motion_state.heading
print(f"mavcom {version('mavcom')}: {said.getvalue().strip()!r}, bytes sent {sent}; heading to the east {heading}")
raise SystemExit(0 if sent == 0 and "5m/s" in said.getvalue() and heading == 9000 else 1)
PY
