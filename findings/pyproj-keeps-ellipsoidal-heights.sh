#!/bin/sh
# pyproj gives an ellipsoidal height as a height above the sea where the geoid's grid is missing.
#
# pyproj 3.7.2 as its wheel comes, without grids. Guess: EPSG:4979 to EPSG:4326+5773 (EGM96) raises, or gives inf, at
# least with only_best=True and errcheck=True. Seen: 535.3 m stays 535.3 m, where EGM96 lies 47.3 m above the ellipsoid.
# Only the accuracy, -1, and the description tell. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyproj==3.7.2
cd "$folder"
env -u PROJ_DATA -u PROJ_LIB HOME="$folder" XDG_DATA_HOME="$folder" PROJ_NETWORK=OFF ./venv/bin/python - <<'PY'
from pyproj import Transformer

transformer = Transformer.from_crs("EPSG:4979", "EPSG:4326+5773", only_best=True)
height = transformer.transform(47.3977, 8.5456, 535.3, errcheck=True)[2]
print(f"535.3 m above the ellipsoid: {height:.1f} m above EGM96; accuracy {transformer.accuracy}")
print(transformer.description)
raise SystemExit(0 if height == 535.3 and transformer.accuracy == -1 else 1)
PY
