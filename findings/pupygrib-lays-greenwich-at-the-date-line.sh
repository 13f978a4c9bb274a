#!/bin/sh
# pupygrib gives a wind at Greenwich the longitude 180 degrees, in a grid from 350 to 10 degrees.
#
# pupygrib 0.9.0 and eccodes 2.50.0, Message.get_coordinates on a GRIB 1 message of five columns. Guess: 350, 355, 0, 5
# and 10, as eccodes reads. Seen: 350, 265, 180, 95 and 10, as the way from the first to the last longitude is taken
# through 180; the values are in their order. A grid from -10 degrees on is right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pupygrib==0.9.0 eccodes==2.50.0 numpy==2.3.5
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import eccodes
import numpy as np
import pupygrib

VALUES = [-10.0, -5.0, 0.0, 5.0, 10.0]


def message(west):
    """A message of two rows, with the longitude as value."""
    handle = eccodes.codes_grib_new_from_samples("regular_ll_sfc_grib1")
    settings = {"Ni": 5, "Nj": 2, "latitudeOfFirstGridPoint": 48000, "latitudeOfLastGridPoint": 47000}
    settings |= {"longitudeOfFirstGridPoint": west, "longitudeOfLastGridPoint": 10000}
    settings |= {"iDirectionIncrement": 5000, "jDirectionIncrement": 1000, "bitsPerValue": 16}
    for key, value in settings.items():
        eccodes.codes_set(handle, key, value)
    eccodes.codes_set_values(handle, np.array(VALUES * 2))
    return eccodes.codes_get_message(handle), handle


def first_row(west):
    data, handle = message(west)
    with open("wind.grib", "wb") as file:
        file.write(data)
    with open("wind.grib", "rb") as file:
        (read,) = pupygrib.read(file)
        longitudes = read.get_coordinates()[0][0].round(3).tolist()
        values = read.get_values()[0].round(1).tolist()
    return longitudes, values, (eccodes.codes_get_array(handle, "longitudes")[:5] % 360).tolist()


seen, values, expected = first_row(350_000)
signed = first_row(-10_000)[0]
print(f"pupygrib {version('pupygrib')}: {seen}, of eccodes {expected}; values {values}; from -10: {signed}")
as_seen = seen == [350, 265, 180, 95, 10] and values == VALUES == signed
raise SystemExit(0 if as_seen and expected == [350, 355, 0, 5, 10] else 1)
PY
