"""Buildings, areas, elevation and winds of files."""
