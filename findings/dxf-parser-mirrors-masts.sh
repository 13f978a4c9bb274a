#!/bin/sh
# dxf-parser puts the circle of a mast, drawn on a mirrored plane, 200 m to the west and below the ground.
#
# dxf-parser 1.1.2 (npm); ezdxf 1.4.5 writes. A DXF circle with the extrusion 0, 0, -1, as CAD programs write after a
# mirroring, has its center in a coordinate system of its own. Guess: the center is in world coordinates, or the entity
# has its extrusion, as dxf-parser's arcs, lines and LWPOLYLINEs have it. Seen: -100, 50, -300 for 100, 50, 300, and no
# member that tells it from a circle there. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ezdxf==1.4.5
cd "$folder"
npm install --silent --no-audit --no-fund dxf-parser@1.1.2 >/dev/null
./venv/bin/python - <<'PY'
import ezdxf

drawing = ezdxf.new("R2010")
space = drawing.modelspace()
for place, up in (((100, 50, 300), (0, 0, 1)), ((-100, 50, -300), (0, 0, -1))):
    circle = space.add_circle(place, 2, dxfattribs={"extrusion": up})
    space.add_arc(place, 2, 0, 90, dxfattribs={"extrusion": up})
    print("center in the world", [round(each) for each in circle.ocs().to_wcs(place)])
drawing.saveas("masts.dxf")
PY
cat >read.cjs <<'JS'
const Parser = require("dxf-parser");
const text = require("fs").readFileSync("masts.dxf", "utf8");
const { entities } = new Parser().parseSync(text);
const of = (type) => entities.filter((each) => each.type === type);
const centers = of("CIRCLE").map((each) => Object.values(each.center).join());
const members = of("CIRCLE").map((each) => Object.keys(each).filter((key) => key !== "handle").join());
const arcs = of("ARC").map((each) => each.extrusionDirectionZ);
console.log(`dxf-parser: centers ${centers.join(" and ")}, members ${members[1]}; extrusion of the arcs ${arcs}`);
const seen = centers.join(";") === "100,50,300;-100,50,-300" && members[0] === members[1] && arcs[1] === -1;
process.exit(seen && !members[1].includes("xtrusion") ? 0 : 1);
JS
node read.cjs
