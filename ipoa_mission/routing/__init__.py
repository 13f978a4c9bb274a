"""Choose the waypoints of a path.

Read `seek` first: it plans with larger margins until an `Attempt` holds. `assemble` chooses the kind of waypoints,
`fastest` the quickest ones. `build` writes their mission, `planned_returns` and `repairs` change its ways home.
"""
