#!/bin/sh
# gpx2exif takes the altitude and the direction out of a picture, and tags it up to a second too early.
#
# gpx2exif 12, process_image of a picture of a drone at 12:00:00.9, with a track at 15 m/s that has heights. Guess: the
# position is corrected, and altitude and direction stay, or come from the track. Seen: latitude and longitude only, as
# the whole GPS block is replaced; they are those of 12:00:00, 13.5 m behind, as SubSecTimeOriginal is not read. Exits 1
# if that changes. (The package pins a pandas without a wheel, so its dependencies are named here.)
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q piexif==1.1.3 gpxpy==1.6.2 simplekml==1.3.6 click==8.1.8 colorama==0.4.6 \
  python-dateutil==2.9.0.post0 pandas==2.3.3 pillow==12.0.0 setuptools==80.9.0 wheel==0.45.1
"$folder/venv/bin/pip" install -q --no-deps --no-build-isolation gpx2exif==12
cd "$folder"
cat >track.gpx <<'GPX'
<gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>
<trkpt lat="47.0" lon="8.0"><ele>500</ele><time>2026-06-01T12:00:00Z</time></trkpt>
<trkpt lat="47.000135" lon="8.0"><ele>500</ele><time>2026-06-01T12:00:01Z</time></trkpt>
</trkseg></trk></gpx>
GPX
./venv/bin/python - <<'PY'
from datetime import timedelta
from importlib.metadata import version
from pathlib import Path

import piexif
from gpx2exif.common import read_gpx
from gpx2exif.gpx2exif import process_image
from PIL import Image

GPS = piexif.GPSIFD
place = {GPS.GPSLatitudeRef: b"N", GPS.GPSLatitude: ((47, 1), (0, 1), (0, 1))}
place |= {GPS.GPSLongitudeRef: b"E", GPS.GPSLongitude: ((8, 1), (0, 1), (0, 1))}
place |= {GPS.GPSAltitudeRef: 0, GPS.GPSAltitude: (5004, 10), GPS.GPSImgDirection: (270, 1)}
time = {piexif.ExifIFD.DateTimeOriginal: b"2026:06:01 12:00:00", piexif.ExifIFD.SubSecTimeOriginal: b"900"}
Image.new("RGB", (8, 8)).save("shot.jpg", exif=piexif.dump({"GPS": place, "Exif": time}))
picture, none = Path("shot.jpg"), timedelta()
track, near = read_gpx("track.gpx"), timedelta(seconds=10)
latitude, _ = process_image(picture, track, none, none, near, False, False, True, False)
left = {piexif.TAGS["GPS"][tag]["name"] for tag in piexif.load("shot.jpg")["GPS"]}
behind = (47 + 0.000135 * 0.9 - latitude) * 111200
print(f"gpx2exif {version('gpx2exif')}: {behind:.1f} m behind; left are {sorted(left)}")
as_seen = left == {f"GPS{name}" for name in ("VersionID", "LatitudeRef", "Latitude", "LongitudeRef", "Longitude")}
raise SystemExit(0 if as_seen and round(behind, 1) == 13.5 else 1)
PY
