"""Other people's files: buildings, zones, elevation models and winds, as obstacles, areas, ground and wind.

Entries: `buildings.search_buildings`, `areas.find_zones`, `elevation.local_grid`, `winds.read_wind`.
`map_reader` picks a reader by suffix (`geojson`, `kml`, `osm`, `pbf`, `parquet`, `gdal_layers`); each returns features.
`kinds`, `keys`, `tag_heights` and `building_rules` decide from tags what a feature is, and how high.
What is not understood is reported (`passed`, `Unread`), never dropped. Read `feature` and `map_reader` first.
"""
