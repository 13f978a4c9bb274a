"""Cost of a path, and the search for the best one."""
