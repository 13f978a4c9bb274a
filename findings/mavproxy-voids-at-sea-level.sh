#!/bin/sh
# MAVProxy gives -1 m for a void of an SRTM tile, and blends it into the heights around.
#
# MAVProxy 1.8.75, modules.lib.srtm.SRTMTile, which its ElevationModel uses: it is said to give None where the height is
# unknown. Guess: None at a void. Seen: in ground of 1500 m, -1 m at the void and 749.5 m halfway to the next post; a
# height above ground that is made from it lies 1501 m too low. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mavproxy==1.8.75 pymavlink==2.4.50 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import zipfile

import numpy as np
from MAVProxy.modules.lib.srtm import SRTMTile

heights = np.full((1201, 1201), 1500, ">i2")
heights[600, 600] = -32768  # void at 47.5 N 8.5 E
with zipfile.ZipFile("N47E008.hgt.zip", "w") as tile:
    tile.writestr("N47E008.hgt", heights.tobytes())
tile = SRTMTile("N47E008.hgt.zip", 47, 8)
seen = [tile.getAltitudeFromLatLon(47.5, 8.5 + post / 1200) for post in (0, 0.5, 1)]
print(f"at the void {seen[0]:g} m, half a post away {seen[1]:.1f} m, one post away {seen[2]:g} m")
raise SystemExit(0 if np.allclose(seen, [-1, 749.5, 1500], atol=0.1) else 1)
PY
