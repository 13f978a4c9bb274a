"""How a path's waypoints are chosen."""
