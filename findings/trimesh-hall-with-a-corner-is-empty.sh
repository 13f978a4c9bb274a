#!/bin/sh
# trimesh finds a vehicle inside a building in collision if the building is a box, and 9.5 m clear if it has an L shape.
#
# trimesh 5.2.0 with python-fcl 0.7.0.11, collision.CollisionManager; both buildings are watertight. Guess: a vehicle of
# 0.5 m radius in the middle of a wing is in collision with both, as contains says of its center. Seen: a convex mesh
# is a solid, a concave one is its surface: not in collision, with 9.5 m to the wall. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q trimesh==5.2.0 python-fcl==0.7.0.11 mapbox_earcut==2.0.0 rtree==1.4.1 shapely==2.2.0 \
  scipy==1.17.1 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import trimesh
from shapely import Polygon, box

vehicle = trimesh.creation.icosphere(radius=0.5)
vehicle.apply_translation((15, 15, 10))


def met(outline):
    building = trimesh.creation.extrude_polygon(outline, 20)
    around = trimesh.collision.CollisionManager()
    around.add_object("building", building)
    assert building.is_watertight and building.contains([vehicle.centroid])[0]
    return bool(around.in_collision_single(vehicle)), round(around.min_distance_single(vehicle), 1)


hall, corner = met(box(0, 0, 30, 100)), met(Polygon([(0, 0), (100, 0), (100, 30), (30, 30), (30, 100), (0, 100)]))
print(f"trimesh {trimesh.__version__}, collision and distance [m] inside: box {hall}, L {corner}")
raise SystemExit(0 if hall[0] and corner == (False, 9.5) else 1)
PY
