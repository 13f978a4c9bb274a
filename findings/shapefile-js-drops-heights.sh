#!/bin/sh
# The npm package shapefile reads obstacles of a Shapefile without their heights.
#
# shapefile 0.6.6 (npm), shpjs 6.2.0, pyshp 3.1.6 to write. Guess: a PointZ of 530.5 m has a third coordinate, as in
# shpjs. Seen: two coordinates, for PointZ and PolyLineZ, and no mark that there were three. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyshp==3.1.6
cd "$folder"
npm install --silent --no-audit --no-fund shapefile@0.6.6 shpjs@6.2.0 >/dev/null
./venv/bin/python - <<'PY'
import shapefile

for name, kind in (("mast", shapefile.POINTZ), ("cable", shapefile.POLYLINEZ)):
    with shapefile.Writer(name, shapeType=kind) as out:
        out.field("number", "N")
        if name == "mast":
            out.pointz(8, 47, 530.5)
        else:
            out.linez([[[8, 47, 530.5], [8, 48, 610]]])
        out.record(1)
PY
cat >read.mjs <<'JS'
import { readFileSync } from "fs";
import { read } from "shapefile";
import shp from "shpjs";

const found = { shapefile: [], shpjs: [] };
for (const name of ["mast", "cable"]) {
  found.shapefile.push((await read(`${name}.shp`)).features[0].geometry.coordinates);
  const both = await shp({ shp: readFileSync(`${name}.shp`), dbf: readFileSync(`${name}.dbf`) });
  found.shpjs.push(both.features[0].geometry.coordinates);
}
console.log(JSON.stringify(found));
const lost = JSON.stringify(found.shapefile) === "[[8,47],[[8,47],[8,48]]]";
process.exit(lost && JSON.stringify(found.shpjs) === "[[8,47,530.5],[[8,47,530.5],[8,48,610]]]" ? 0 : 1);
JS
node read.mjs
