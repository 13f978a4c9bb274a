#!/bin/sh
# avipy makes 2 Pa of a QNH of 29.92 inches of mercury, a tenth of a bar, and 10 m of 100 cm.
#
# avipy 0.3.3, qty and atmosphere.get_density. Guess: 1013.25 hPa, 29.9213 inches of mercury, 1.01325 bar and 14.696 psi
# are one pressure, with which air of 15 degrees has 1.225 kg/m3; 100 cm and 10 dm are 1 m. Seen: 1.225 for hPa only;
# 0.123 for the bar, and 0.000 for inches and psi, which are 2 and 1 Pa. 100 cm are 10 m, and 10 dm are 0.1 m. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q avipy==0.3.3
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from avipy import atmosphere, qty

pressures = {"hPa": qty.Pressure.Hpa(1013.25), "inHg": qty.Pressure.Inhg(29.9213)}
pressures |= {"bar": qty.Pressure.Bar(1.01325), "psi": qty.Pressure.Psi(14.696)}
air = qty.Temperature(288.15)
density = {unit: round(atmosphere.get_density(temp=air, pressure=pressure), 3) for unit, pressure in pressures.items()}
pascals = [round(pressure.base) for pressure in pressures.values()]
lengths = [round(length.base, 6) for length in (qty.Distance.Cm(100), qty.Distance.Dm(10), qty.Distance.Mm(1000))]
print(f"avipy {version('avipy')}: air of one pressure has {density} kg/m3, at {pascals} Pa")
print(f"100 cm, 10 dm and 1000 mm are {lengths} m")
as_seen = density == {"hPa": 1.225, "inHg": 0, "bar": 0.123, "psi": 0} and pascals == [101325, 2, 10132, 1]
raise SystemExit(0 if as_seen and lengths == [10, 0.1, 1] else 1)
PY
