"""Choose the waypoints of a path.

Read `seek` first: it plans with larger margins until an `Attempt` is acceptable. `assemble` chooses the kind of
waypoints, `fastest` the quickest. `build` makes their mission, `planned_returns` and `repairs` change its ways home.
"""
