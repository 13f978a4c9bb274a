#!/bin/sh
# coordinates-label-photos tags a picture from 105 degrees west as one from 105 degrees east, below the sea.
#
# coordinates-label-photos 1.0.7, calibrate_photo with a track at 40 N 105 W and 1600 m. Guess: the picture has the
# track's place. Seen: 105 E, in China, as the letter of the longitude is that of the latitude's sign; at 34 S 151 E it
# is 151 W. GPSAltitudeRef is 1, below sea level, for each height, and the tool's own exif_to_coordinates reads 1600 m
# from it. North of the equator in the east, and south in the west, places are right. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q piexif==1.1.3 geopy==2.4.1 gpxpy==1.6.2 tqdm==4.67.1 pillow==12.0.0
"$folder/venv/bin/pip" install -q --no-deps coordinates-label-photos==1.0.7
cd "$folder"
./venv/bin/python - 2>/dev/null <<'PY'
from datetime import datetime, timedelta, timezone
from importlib.metadata import version

import piexif
from coordinates_label_photos.coordinates import Coordinates
from coordinates_label_photos.coordinates.coordinates_collection import CoordinatesCollection
from coordinates_label_photos.photos import calibrate_photo
from PIL import Image

START = datetime(2026, 6, 1, 12, tzinfo=timezone.utc)


def tagged(latitude, longitude):
    """The letters of the picture's place, its whole degrees, and the reference and value of its altitude."""
    time = {piexif.ExifIFD.DateTimeOriginal: b"2026:06:01 12:00:05"}
    Image.new("RGB", (8, 8)).save("shot.jpg", exif=piexif.dump({"Exif": time}))
    ends = (Coordinates(latitude, longitude, 1600.0, START + timedelta(seconds=10 * n)) for n in range(2))
    calibrate_photo(["shot.jpg"], CoordinatesCollection(list(ends)))
    tags = {piexif.TAGS["GPS"][tag]["name"][3:]: value for tag, value in piexif.load("shot.jpg")["GPS"].items()}
    letters = (tags["LatitudeRef"] + tags["LongitudeRef"]).decode()
    return letters, tags["Latitude"][0][0], tags["Longitude"][0][0], tags["AltitudeRef"], tags["Altitude"][0]


seen = [tagged(*place) for place in ((40, -105), (-34, 151), (47, 8))]
print(f"coordinates-label-photos {version('coordinates-label-photos')}, of 40 N 105 W, 34 S 151 E, 47 N 8 E: {seen}")
raise SystemExit(0 if seen == [("NE", 40, 105, 1, 1600), ("SW", 34, 151, 1, 1600), ("NE", 47, 8, 1, 1600)] else 1)
PY
