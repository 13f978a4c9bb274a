"""Compute how a flight can end: RTL, LAND, SmartRTL and hold at each second.

`contingencies`: rows with grade, distance, duration and energy, from `forecast.cached(Contingencies)`; it calls
`contingency_paths`: stopping points, paths and distances, from `forecast.cached(ContingencyPaths)`; that calls
`return_routes` (goals, returns along the mission or over terrain) and `enlarged_airspace` (distances to obstacles), and
fills `contingency_samples`: arrays by time, refined until no shortfall can hide.
`shortfalls`: the nearest passings of `ContingencyPaths`, and return altitudes without one.
`energy_budget`: each RTL against the battery, by `predict_contingency`. `contingencies_now`: looks up rows in flight.
PX4's RTL is timed by `FlightModel.predict_contingency`, an RTL item by `_Navigator.visit`: both use `return_orders`.
"""
