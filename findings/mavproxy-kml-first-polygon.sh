#!/bin/sh
# MAVProxy reads one polygon of a KML placemark with two, and none of a placemark without a name.
#
# MAVProxy 1.8.75, modules.lib.kmlread, from which `kml fence exc` makes fences. Guess: all polygons of a MultiGeometry
# are read, and a name is not needed, as KML has it. Seen: the second polygon is gone, and the placemark without <name>
# is None; nothing is said. Of KML with Google's older namespace, earth.google.com/kml/2.2, nothing is read. Exits 1 if
# that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q lxml==6.1.3
"$folder/venv/bin/pip" install -q --no-deps mavproxy==1.8.75
cd "$folder"
./venv/bin/python - <<'PY'
from pathlib import Path

from MAVProxy.modules.lib import kmlread


def polygon(west):
    ring = f"<coordinates>{west},47 {west}.1,47 {west}.1,47.1 {west},47</coordinates>"
    return f"<Polygon><outerBoundaryIs><LinearRing>{ring}</LinearRing></outerBoundaryIs></Polygon>"


two = f"<Placemark><name>two</name><MultiGeometry>{polygon(8)}{polygon(9)}</MultiGeometry></Placemark>"
zones = f"{two}<Placemark>{polygon(10)}</Placemark>"
text = f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{zones}</Document></kml>'
Path("zones.kml").write_text(text)
Path("older.kml").write_text(text.replace("www.opengis.net", "earth.google.com"))
read = [kmlread.readObject(node) for node in kmlread.readkmz("zones.kml")]
west = [zone and min(longitude for _, longitude in zone.vertexes) for zone in read]
older = kmlread.readkmz("older.kml")
print(f"zones at 8, 9 and 10 E: read at {west}; in the older namespace {len(older)} placemarks")
raise SystemExit(0 if west == [8.0, None] and not older else 1)
PY
