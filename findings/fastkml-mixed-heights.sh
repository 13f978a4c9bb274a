#!/bin/sh
# fastkml gives a placemark no geometry where some of its positions have a height and some have none.
#
# fastkml 1.4.0. KML 2.2 lets the altitude of each position be left out. Guess: the missing heights are 0, as in GDAL, or
# the file is refused. Seen: the placemark is there, its geometry is None, and nothing is raised with strict=False or
# with the default; a zone is lost. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q fastkml==1.4.0 lxml==6.1.3
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

from fastkml import KML, Placemark
from fastkml.utils import find_all

RING = "<coordinates>8,47 8.1,47,30 8.1,47.1 8,47</coordinates>"
ZONE = f"<Polygon><outerBoundaryIs><LinearRing>{RING}</LinearRing></outerBoundaryIs></Polygon>"
TEXT = f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark>{ZONE}</Placemark></Document></kml>'
texts = (TEXT, TEXT.replace(",30", ""))
found = [mark.geometry for text in texts for mark in find_all(KML.from_string(text), of_type=Placemark)]
print(f"fastkml {version('fastkml')}: with mixed heights {found[0]}, without {found[1].geom_type}")
raise SystemExit(0 if found[0] is None and found[1] is not None else 1)
PY
