"""Read other people's files: buildings, zones, elevation models and winds.

`map_reader` picks a reader by suffix; each returns features, from which `buildings` and `areas` find obstacles and
zones. `elevation` and `winds` read the others. Read `feature` first.
"""
