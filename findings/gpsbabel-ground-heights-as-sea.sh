#!/bin/sh
# GPSBabel turns a KML height above ground into a GPX elevation above the sea, and drops areas beside a line.
#
# gpsbabel 1.8.0+ds-5 of Debian 12, kml to gpx. Guess: a point with altitudeMode relativeToGround has no <ele>, or a
# warning is printed; both geometries of a MultiGeometry are kept. Seen: <ele>30.000</ele>, which GPX defines above the
# sea; of a polygon and a line in a MultiGeometry only the line; no warning. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq gpsbabel=1.8.0+ds-5 libshp2 libusb-1.0-0 libqt5core5a libicu72 libdouble-conversion3 \
  libpcre2-16-0 libglib2.0-0 libmd4c0 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done
cat >places.kml <<'KML'
<?xml version="1.0"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
<Placemark><name>waypoint</name><Point><altitudeMode>relativeToGround</altitudeMode>
<coordinates>8.5,47.3,30</coordinates></Point></Placemark>
<Placemark><name>zone</name><MultiGeometry><Polygon><outerBoundaryIs><LinearRing>
<coordinates>8.5,47.3 8.6,47.3 8.6,47.4 8.5,47.3</coordinates></LinearRing></outerBoundaryIs></Polygon>
<LineString><coordinates>8.5,47.3 8.6,47.4</coordinates></LineString></MultiGeometry></Placemark>
</Document></kml>
KML
libraries=$(find root -name '*-linux-gnu' -path '*lib*' -type d | tr '\n' ':')
LD_LIBRARY_PATH=$libraries root/usr/bin/gpsbabel -i kml -f places.kml -o gpx -F places.gpx 2>warnings
echo "warnings: $(wc -c <warnings) bytes; elevations: $(grep -c '<ele>30.000' places.gpx);" \
  "places of the zone: $(grep -c '<trkpt' places.gpx)"
[ ! -s warnings ] && [ "$(grep -c '<ele>30.000' places.gpx)" = 1 ] && [ "$(grep -c '<trkpt' places.gpx)" = 2 ]
