"""Read map files: buildings, areas, elevation and winds."""
