#!/bin/sh
# aeroagentsim finds no consumption in a flight from 100 to 40 %, and 60 % an hour in the charging after it.
#
# aeroagentsim 1.1.1, StatsAnalyzer.analyze_battery_consumption, "battery consumption rate", which leaves charging out
# by its comment. Guess: of an hour of flight from 100 to 40 %, 60 % an hour; of charging, 0. Seen: 0 for the flight and
# 60 for the charging, as the rises are added, not the falls. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q simpy==4.1.1 numpy==2.4.6 pandas==2.3.3 matplotlib==3.10.7
"$folder/venv/bin/pip" install -q --no-deps aeroagentsim==1.1.1
cd "$folder"
./venv/bin/python - 2>/dev/null <<'PY'
from importlib.metadata import version
from pathlib import Path

from aeroagentsim.statistics.stats_analyzer import StatsAnalyzer


def rate(levels):
    """Percent an hour, of levels in equal steps of an hour."""
    folder = Path("stats", f"{levels[0]}")
    folder.mkdir(parents=True)
    rows = (f"{3600 * step / (len(levels) - 1)},drone,DroneAgent,{level}" for step, level in enumerate(levels))
    (folder / "agent_battery.csv").write_text("timestamp,agent_id,agent_type,battery_level\n" + "\n".join(rows))
    return StatsAnalyzer(str(folder)).analyze_battery_consumption()["average_hourly_rate"]


flight, charging = rate([100, 80, 60, 40]), rate([40, 60, 80, 100])
print(f"aeroagentsim {version('aeroagentsim')}: flight {flight:g} % an hour, charging {charging:g}")
raise SystemExit(0 if (flight, charging) == (0, 60) else 1)
PY
