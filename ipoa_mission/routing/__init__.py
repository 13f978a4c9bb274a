"""Choose the waypoints of a path."""
