"""The world of a planner, in meters east, north and up of home.

Read `airspace.py` first: it measures exact clearances of points and legs to bounds, `terrain` and `obstacles`.
"""
