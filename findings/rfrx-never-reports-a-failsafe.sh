#!/bin/sh
# rfrx reports neither a failsafe nor a lost frame of an SBUS receiver.
#
# rfrx 2.1.2, SbusDecoder, whose channels are right. PX4, ArduPilot and Betaflight read 4 in the last byte but one as a
# lost frame, and 8 as a failsafe. Guess: frame_lost and failsafe are set. Seen: both are 0, as are channels 17 and 18
# of flags 1 and 2. rfrx reads the four flags from the upper half of the byte, in reversed order. A program that stops
# on a failsafe goes on with the last sticks. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q rfrx==2.1.2 pyserial==3.5
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from rfrx.sbus import SbusDecoder

FLAGS = {"ch17": 1, "ch18": 2, "frame_lost": 4, "failsafe": 8}
STICKS = [172 + 100 * channel for channel in range(16)]


def decoded(flags):
    packed = sum(stick << 11 * channel for channel, stick in enumerate(STICKS))
    return SbusDecoder(b"\x0f" + packed.to_bytes(22, "little") + bytes([flags, 0]))


channels = decoded(0).chans
seen = {name: getattr(decoded(flag), name) for name, flag in FLAGS.items()}
above = {name: bool(getattr(decoded(0x80 // flag), name)) for name, flag in FLAGS.items()}
print(f"rfrx {version('rfrx')}: channels are right: {channels == STICKS}; flags where each is set: {seen};")
print(f"where its mirror in the byte is set: {above}")
is_deaf = set(seen.values()) == {0} and all(above.values())
raise SystemExit(0 if channels == STICKS and is_deaf else 1)
PY
