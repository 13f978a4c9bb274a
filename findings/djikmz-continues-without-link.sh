#!/bin/sh
# djikmz's return_home_on_signal_loss() makes a DJI mission that flies on without its radio link.
#
# djikmz 0.1.0, DroneTask. Guess: the call writes exitOnRCLost executeLostAction with executeRCLostAction goBack. Seen:
# return_home_on_signal_loss(True) writes goContinue, so the aircraft flies on; False writes the action "handover",
# which WPML does not have (goBack, landing, hover). No call of the builder gives a return. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q djikmz==0.1.0 pydantic==2.12.5 xmltodict==1.0.2
cd "$folder"
./venv/bin/python - <<'PY'
import re

from djikmz import DroneTask


def on_lost_link(returns_home):
    task = DroneTask("M3E").return_home_on_signal_loss(returns_home)
    task.fly_to(47.3977, 8.5456, 60)
    task.fly_to(47.4077, 8.5456, 60)
    return re.findall(r"<wpml:\w*RCLost\w*>(\w+)<", task.build().to_xml())


seen = on_lost_link(True), on_lost_link(False)
print(f"return_home_on_signal_loss: True writes {seen[0]}, False writes {seen[1]}")
raise SystemExit(0 if seen == (["goContinue"], ["executeLostAction", "handover"]) else 1)
PY
