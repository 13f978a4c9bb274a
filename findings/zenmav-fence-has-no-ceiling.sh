#!/bin/sh
# zenmav's fence with a ceiling of 120 m lets a vehicle fly at 500 m.
#
# zenmav 0.2.0, Limits of a fence file with z.min and z.max, which it reads, and refuses where z.min is above z.max.
# Guess: a position above z.max is outside. Seen: inside, at 500 m and at -50 m; the height is never compared. Of two
# regions only the first counts. A local fence of 100 m that a margin of 60 m would leave nothing of is taken without
# any margin. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q zenmav==0.2.0 pymavlink==2.4.50 shapely==2.1.2 pyproj==3.7.2 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
from contextlib import redirect_stdout
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace

from zenmav.zenboundary import Limits, load_fence_toml
from zenmav.zenpoint import wp

LINES = ["version = 1", 'frame = "global"', "[z]", "min = 0", "max = 120"]
for south in (47.0, 47.1):
    corners = [[south, 8.0], [south + 0.01, 8.0], [south + 0.01, 8.01], [south, 8.01]]
    LINES += ["[[regions]]", 'kind = "include-polygon"', f"latlon = {corners}"]
Path("fence.toml").write_text("\n".join(LINES))
square = "[[0, 0], [100, 0], [100, 100], [0, 100]]"
Path("local.toml").write_text(
    f'version = 1\nframe = "local"\nmargin = 60\n[[regions]]\nkind = "include-polygon"\npoints = {square}'
)
home = wp(47.005, 8.005, 0, frame="global")
vehicle = SimpleNamespace(home=home, get_global_pos=lambda: home, set_mode=print)


def fence(name):
    with redirect_stdout(None):
        limits = Limits(vehicle, name, check_interval=60)
    limits.stop_breach_monitor()
    return limits


world, local = fence("fence.toml"), fence("local.toml")
heights = [world.check_inside(wp(47.005, 8.005, height, frame="global")) for height in (50, 500, -50)]
second = world.check_inside(wp(47.105, 8.005, 50, frame="global"))
edge = local.check_inside(wp(1, 1, -50, frame="local"), frame="local")
ceiling = load_fence_toml("fence.toml").z_max_m
print(f"zenmav {version('zenmav')}, below {ceiling} m: inside at 50, 500 and -50 m {heights}; in region 2 {second};")
print(f"1 m from the edge with a margin of 60 m {edge}")
raise SystemExit(0 if heights == [True] * 3 and not second and edge and ceiling == 120 else 1)
PY
