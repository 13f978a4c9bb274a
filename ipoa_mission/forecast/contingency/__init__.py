"""Compute how a flight can end: RTL, LAND, SmartRTL and hold at each second.

`contingencies` makes rows of grade, distance, duration and energy, from `contingency_paths`.
`contingency_paths` finds stopping points, paths, and distances in `enlarged_airspace`.
`return_routes` gives it goals, and returns along the mission or over terrain.
`contingency_samples` holds its arrays, refined until no shortfall can hide.
`shortfalls` finds its nearest passings, and return altitudes without one.
`energy_budget` compares RTL with the battery; `contingencies_now` looks up rows in flight.
"""
