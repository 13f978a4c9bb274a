#!/bin/sh
# GPSBabel writes a planned track as NMEA of a receiver without a fix, and reads none of its points back.
#
# gpsbabel 1.8.0+ds-5 of Debian 12, gpx to nmea, and back. Guess: a GPX track of two points with times becomes two
# sentences that a simulated receiver can use. Seen: RMC has status V and GGA quality 0, as no <fix> is in the file;
# GPSBabel's own reader then has no point, and says nothing. With <fix>3d</fix> both are valid. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq gpsbabel=1.8.0+ds-5 libshp2 libusb-1.0-0 libqt5core5a libicu72 libdouble-conversion3 \
  libpcre2-16-0 libglib2.0-0 libmd4c0 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done
LD_LIBRARY_PATH=$(find root -name '*-linux-gnu' -path '*lib*' -type d | tr '\n' ':')
export LD_LIBRARY_PATH
track() {
  echo '<?xml version="1.0"?><gpx version="1.1" creator="plan" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
  for second in 10 20; do
    echo "<trkpt lat=\"47\" lon=\"8.00$second\"><ele>500</ele><time>2026-06-01T10:00:${second}Z</time>$1</trkpt>"
  done
  echo '</trkseg></trk></gpx>'
}
count() {
  root/usr/bin/gpsbabel -t -i gpx -f "$1.gpx" -o nmea -F "$1.nmea" 2>>warnings
  root/usr/bin/gpsbabel -t -i nmea -f "$1.nmea" -o gpx -F "$1.back" 2>>warnings
  status=$(grep RMC "$1.nmea" | cut -d, -f3 | tr -d '\n')
  quality=$(grep GGA "$1.nmea" | cut -d, -f7 | tr -d '\n')
  echo "status $status, quality $quality, points $(grep -c '<trkpt' "$1.back" || true)"
}
track >plan.gpx
track '<fix>3d</fix>' >fixed.gpx
plan=$(count plan)
fixed=$(count fixed)
echo "planned: $plan; with a fix: $fixed; warnings: $(wc -c <warnings) bytes"
[ "$plan" = "status VV, quality 00, points 0" ] && [ "$fixed" = "status AA, quality 11, points 2" ] && [ ! -s warnings ]
