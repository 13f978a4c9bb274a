#!/bin/sh
# GDAL gives the box of an image on a KML as a polygon among the zones, and a second KML of a KMZ not at all.
#
# pyogrio 0.13.0 (GDAL 3.12.4, driver LIBKML). Guess: a GroundOverlay, an image such as a chart, is no feature, or is in
# a layer of its own; a KMZ is read whole. Seen: the box of the image is a polygon in the layer of the placemarks, told
# from a zone only by its field `icon`; of a KMZ with doc.kml and more.kml only the first is there, without a warning.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q pyogrio==0.13.0 shapely==2.2.0 numpy==2.4.1
cd "$folder"
./venv/bin/python - <<'PY'
import warnings
import zipfile
from pathlib import Path

import pyogrio
import shapely

KML = '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document>{}</Document></kml>'
BOX = "<north>47.1</north><south>47</south><east>8.1</east><west>8</west>"
IMAGE = f"<GroundOverlay><Icon><href>chart.png</href></Icon><LatLonBox>{BOX}</LatLonBox></GroundOverlay>"
RING = "<coordinates>9,47 9.1,47 9.1,47.1 9,47 </coordinates>"
ZONE = f"<Placemark><Polygon><outerBoundaryIs><LinearRing>{RING}</LinearRing></outerBoundaryIs></Polygon></Placemark>"
Path("chart.kml").write_text(KML.format(IMAGE + ZONE))
with zipfile.ZipFile("two.kmz", "w") as archive:
    archive.writestr("doc.kml", KML.format(ZONE))
    archive.writestr("more.kml", KML.format(ZONE.replace("9", "8")))
counts = {}
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    for name in ("chart.kml", "two.kmz"):
        layers = pyogrio.list_layers(name)[:, 0]
        shapes = [shape for layer in layers for shape in pyogrio.raw.read(name, layer=layer)[2]]
        counts[name] = [shapely.from_wkb(shape).geom_type for shape in shapes]
print(f"GDAL {pyogrio.__gdal_version_string__}: {counts}, warnings {[str(one.message) for one in said]}")
as_seen = counts == {"chart.kml": ["Polygon", "Polygon"], "two.kmz": ["Polygon"]} and not said
raise SystemExit(0 if as_seen else 1)
PY
