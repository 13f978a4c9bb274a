#!/bin/sh
# ezdxf's GeoProxy draws a climb and a roof on the ground.
#
# ezdxf 1.4.5, addons.geo, GeoProxy.parse and to_dxf_entities. Guess: the heights of GeoJSON are those of the drawing.
# Seen: a line from 100 to 200 m and an area at 50 m are at height 0; a point keeps its height. The other way, from
# entities to GeoJSON, heights are kept. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ezdxf==1.4.5 numpy==2.4.6
cd "$folder"
./venv/bin/python - <<'PY'
import ezdxf
from ezdxf.addons import geo

climb = {"type": "LineString", "coordinates": [(0, 0, 100), (10, 0, 200)]}
roof = {"type": "Polygon", "coordinates": [[(0, 0, 50), (10, 0, 50), (10, 10, 50), (0, 0, 50)]]}
line, area, mast = (
    next(iter(geo.GeoProxy.parse(shape).to_dxf_entities(polygon=2)))
    for shape in (climb, roof, {"type": "Point", "coordinates": (0, 0, 100)})
)
heights = {position.z for entity in (line, area) for position in entity.vertices_in_wcs()}
drawn = ezdxf.new().modelspace().add_line((0, 0, 100), (10, 0, 200))
back = [position[2] for position in geo.proxy(drawn).__geo_interface__["coordinates"]]
print(f"{line.dxftype()} and {area.dxftype()} at {heights}, POINT at {mast.dxf.location.z}; from the drawing {back}")
raise SystemExit(0 if heights == {0.0} and mast.dxf.location.z == 100 and back == [100, 200] else 1)
PY
