#!/bin/sh
# cflib reads an angle that differs by -0 from another as two billion radians.
#
# cflib 0.1.34, the Crazyflie's library: Localization of a packet with the angles of a lighthouse, whose sensors 1 to 3
# come as 16-bit differences from sensor 0. Guess: a difference of 0 or -0 gives the angle of sensor 0. Seen: -0, as a
# difference too small for 16 bits is rounded to from below, gives -2147483647.5 rad, and an infinite one the finite
# -2139095039.5, as fp16_to_float returns the bits of these numbers, not their values. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q cflib==0.1.34
cd "$folder"
./venv/bin/python - <<'PY'
import struct
from importlib.metadata import version

from cflib.crazyflie.localization import Localization
from cflib.crtp.crtpstack import CRTPPacket
from cflib.utils.encoding import fp16_to_float


class Link:
    """The part of a Crazyflie that Localization uses."""

    def add_port_callback(self, port, callback):
        self.receive = callback


link, seen = Link(), []
Localization(link).receivedLocationPacket.add_callback(lambda packet: seen.append(packet.data["x"]))
packet = CRTPPacket()
differences = 0.0, -0.0, -1e-9
payload = struct.pack("<Bfeeefeee", 0, 0.5, *differences, 0, 0, 0, 0)
packet.data = bytes([Localization.LH_ANGLE_STREAM]) + payload
link.receive(packet)
numbers = [fp16_to_float(bits) for bits in (0x0000, 0x8000, 0x3C00, 0x7C00)]
print(f"cflib {version('cflib')}: angles {seen[0]} rad; 0, -0, 1 and infinity are {numbers}")
as_seen = numbers == [0, 2**31, 1, 0x7F800000]
raise SystemExit(0 if as_seen and seen[0] == [0.5, 0.5, -2147483647.5, -2147483647.5] else 1)
PY
