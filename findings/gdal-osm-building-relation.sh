#!/bin/sh
# GDAL's OSM driver gives a building that is a relation of type `building` as lines, apart from all other buildings.
#
# pyogrio 0.13.0 (GDAL 3.12.4) and osmium 4.3.2. Simple 3D Buildings lets a relation of type `building` hold the outline
# and the parts of a building; the tags lie on it. Guess: it is an area, as a relation of type `multipolygon` is. Seen:
# GDAL has it in `other_relations` as a collection of lines, its tags in `other_tags`; osmium makes no area of it. Who
# reads the layer `multipolygons`, or osmium's areas, has no building there. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.2.0 numpy==2.4.1 osmium==4.3.2
cat >"$folder/town.osm" <<'OSM'
<osm version="0.6">
 <node id="1" version="1" lat="47.000" lon="8.000"/><node id="2" version="1" lat="47.000" lon="8.001"/>
 <node id="3" version="1" lat="47.001" lon="8.001"/><node id="4" version="1" lat="47.001" lon="8.000"/>
 <way id="10" version="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/></way>
 <way id="11" version="1"><nd ref="3"/><nd ref="4"/><nd ref="1"/></way>
 <relation id="20" version="1"><member type="way" ref="10" role="outline"/><member type="way" ref="11" role="outline"/>
  <tag k="type" v="building"/><tag k="building" v="yes"/><tag k="height" v="30"/></relation>
</osm>
OSM
cd "$folder"
./venv/bin/python - <<'PY'
import osmium
import pyogrio
import shapely

found = {}
for layer in ("multipolygons", "other_relations"):
    meta, _, shapes, fields = pyogrio.raw.read("town.osm", layer=layer)
    found[layer] = [shapely.from_wkb(shape).geom_type for shape in shapes]
areas = [each.orig_id() for each in osmium.FileProcessor("town.osm").with_areas() if each.is_area()]
print(f"GDAL {pyogrio.__gdal_version_string__}: {found}; osmium's areas: {areas}")
as_seen = found == {"multipolygons": [], "other_relations": ["GeometryCollection"]} and areas == []
raise SystemExit(0 if as_seen else 1)
PY
