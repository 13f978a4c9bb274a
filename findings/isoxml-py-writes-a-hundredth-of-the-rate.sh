#!/bin/sh
# isoxml's from_numpy_array writes a rate of 200 of which its own to_numpy_array reads 2.
#
# isoxml 0.0.4 of PyPI, a grid of type 2 with DDI 1, in hundredths of mm3/m2. Guess: the array that was written is read
# back with the same DDI. Seen: from_numpy_array takes no DDI and writes 200, to_numpy_array takes it and multiplies by
# 0.01. from_numpy_array_to_type_2 with the DDI gives 200 back. A sprayer that follows the standard applies a hundredth.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q isoxml==0.0.4 numpy==2.3.5 shapely==2.2.0
cd "$folder"
./venv/bin/python - <<'PY'
from decimal import Decimal
from importlib.metadata import version

import numpy as np
from isoxml.converter.np_grid import from_numpy_array, from_numpy_array_to_type_2, to_numpy_array
from isoxml.models.base import v4
from isoxml.models.ddi_entities import DDEntity

rate = DDEntity.from_id(1)
grid = v4.Grid(
    minimum_north_position=Decimal("47"),
    minimum_east_position=Decimal("8"),
    cell_north_size=1e-4,
    cell_east_size=1e-4,
    maximum_column=2,
    maximum_row=1,
    filename="GRD00000",
    type=v4.GridType.GridType2,
)
rates = np.array([[200, 350]], dtype=np.int32)
plain = to_numpy_array(from_numpy_array(rates, grid), grid, [rate]).ravel()
scaled = to_numpy_array(from_numpy_array_to_type_2(rates, grid, [rate]), grid, [rate]).ravel()
seen = [[round(float(value), 2) for value in values] for values in (plain, scaled)]
print(f"isoxml {version('isoxml')}, {rate.unit}: 200 and 350 are read as {seen[0]}; written with the DDI {seen[1]}")
raise SystemExit(0 if seen == [[2.0, 3.5], [200.0, 350.0]] else 1)
PY
