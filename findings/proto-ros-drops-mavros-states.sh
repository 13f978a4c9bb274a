#!/bin/sh
# proto-ros leaves out MAVROS' State and each message with a constant of 0xFF or 1e6, and reports success.
#
# proto-ros 0.1.0, msg2proto. Guess: each .msg file gives a .proto file, or is named as failed. Seen: none for a
# constant of text without quotes, as ROS has it and MAVROS' State uses it, none for 0xFF or 1e6, and none for a file
# without a last line feed. The exit code is 0, and "Converting" is all that it prints of them. A char, which ROS 2
# defines as uint8, becomes a string. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --no-deps proto-ros==0.1.0 parsimonious==0.10.0 regex==2026.9.10 numpy==2.3.5
cd "$folder"
mkdir messages
printf 'bool armed\nstring mode\nstring MODE_PX4_MISSION = AUTO.MISSION\n' >messages/State.msg
printf 'uint16 ALL=0xFF\nuint16 flags\n' >messages/Mask.msg
printf 'float32 LIMIT=1e6\nfloat32 height\n' >messages/Limit.msg
printf 'float32 height' >messages/Height.msg
printf 'uint16 ALL=255\nuint16 flags\nchar letter\n' >messages/Plain.msg
./venv/bin/msg2proto messages made --package demo >log
written=$(cd made/demo && echo *)
letter=$(grep letter made/demo/plain.proto | tr -s ' ')
said=$(grep State log)
echo "proto-ros 0.1.0: of 5 files, written: $written; letter:$letter the log of State: $said"
test "$written" = plain.proto
test "$letter" = ' string letter = 2;'
test "$said" = 'INFO Converting: messages/State.msg'
