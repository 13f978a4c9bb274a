"""Read other people's files: buildings, zones, elevation models and winds.

Read `feature` first, then `map_reader`, `buildings` and `areas`; `elevation` and `winds` read the others.
"""
