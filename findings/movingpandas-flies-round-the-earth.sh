#!/bin/sh
# MovingPandas puts a flight of 222 m at Fiji on the meridian of Greenwich.
#
# movingpandas 0.23.0, a trajectory in degrees from 179.999 E to 179.999 W. Guess: half-way in time it is at 180
# degrees, as get_length has it, 223 m. Seen: get_position_at is at longitude 0, 20,000 km away, no error; of a flight
# from 8 to 8.002 E it is at 8.001. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q movingpandas==0.23.0 geopandas==1.2.0 shapely==2.2.0 pyproj==3.7.2 pandas==2.3.3 \
  numpy==2.4.6
cd "$folder"
./venv/bin/python -W ignore - <<'PY'
from importlib.metadata import version

import geopandas
import movingpandas
import pandas
from shapely import Point


def flight(west, east):
    times = pandas.to_datetime(["2026-11-29 12:00:00", "2026-11-29 12:01:00"])
    places = geopandas.GeoDataFrame(geometry=[Point(west, 0), Point(east, 0)], index=times, crs=4326)
    way = movingpandas.Trajectory(places, 1)
    return round(way.get_length()), round(way.get_position_at(times[0] + pandas.Timedelta("30s")).x, 4)


far, fiji = flight(8, 8.002), flight(179.999, -179.999)
print(f"movingpandas {version('movingpandas')}, meters and longitude half-way: {far}; at Fiji {fiji}")
raise SystemExit(0 if (far, fiji) == ((223, 8.001), (223, 0)) else 1)
PY
