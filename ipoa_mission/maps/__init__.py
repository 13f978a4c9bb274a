"""Other people's maps: buildings and areas of GeoJSON and KML files, elevation models."""
